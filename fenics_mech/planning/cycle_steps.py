"""Steps of a cycle: equal ones, cut where an impulse acts, a load jumps, or a load's factor has hidden corners."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene
from fenics_mech.scene.applied_loads import FactorHarmonics, Varying, factor_pieces
from fenics_mech.scene.sampling import SAMPLING, gauss_points
from fenics_mech.solve.stages import Tableau, radau


@dataclass(frozen=True)
class CutLimits:
    """When a step of a cycle is cut."""

    hidden: float = 1e-4  # of the largest mean of a step, by which another's may lie outside the values at its points
    missed: float = 1e-2  # of that mean, that points of a step may miss where corners show where to cut
    most_corners: int = 5000  # of the loads in a cycle, at which steps are cut


CUTS = CutLimits()


@dataclass(frozen=True)
class Steps:
    """Steps of a cycle, in the order of time; arrays of shape ``(steps,)``."""

    start: Array  # drive angle (rad) at which each begins
    rate: float  # rate of the drive coordinate (rad/s), with its sign
    jumps: NDArray[np.bool_]  # whether a load jumps at the end of a step
    breaks: NDArray[np.bool_]  # whether a load jumps, or an impulse acts, where a step begins

    @classmethod
    def of(cls, scene: Scene) -> Steps:
        """Cut the cycle of a scene."""
        return cls._cut_at(scene, corners_to_cut(scene))

    @classmethod
    def _cut_at(cls, scene: Scene, corners: Array) -> Steps:
        """Cut the cycle where impulses act and loads jump, and at corners of their factors (rad)."""
        rate, count = scene.cycle_rate, scene.analysis.sub_intervals
        turned = np.arange(count) / count * TURN
        impulses = _turned(rate, [x.angle for x in scene.impulses.values() if x.angle is not None])
        jumps = _turned(rate, [angle for load in scene.loads.values() for angle in load.jumps])
        for angle in (*impulses, *jumps, *_turned(rate, corners)):
            if _differences(np.array([angle]), turned).min() > SAMPLING.same:
                turned = np.sort(np.append(turned, angle))
        jumping, struck = (_differences(turned, x).min(axis=1, initial=TURN) < SAMPLING.same for x in (jumps, impulses))
        return cls(math.copysign(1, rate) * turned, rate, np.roll(jumping, -1), jumping | struck)

    @property
    def times(self) -> Array:
        """When they begin (s): at a jump or an impulse, which count to the step after it, a rounding before it."""
        return (np.abs(self.start) - 2 * SAMPLING.same * self.breaks) / abs(self.rate)

    def angles(self, places: Array) -> Array:
        """Drive angles (rad) at places 0..1 in every step, ``(steps x places,)``."""
        # The end of a step at which a load jumps is taken just before the jump.
        # places: shares of a step, ``(places,)``
        turned = np.diff(np.abs(self.start), append=TURN)  # the rate times the duration, but the same at all rates
        angles = self.start[:, None] + math.copysign(1, self.rate) * turned[:, None] * places
        before = math.copysign(2 * SAMPLING.same, self.rate) * (self.jumps[:, None] & (places > 1 - SAMPLING.same))
        return (angles - before).ravel()


def corners_to_cut(scene: Scene) -> Array:
    """Give the corners of loads' factors in sub-intervals whose points do not show what a factor does there."""
    # In such a sub-interval the mean by the quadrature of the points is off by more than `CutLimits.missed`. Or the
    # mean is not between the values at the points. In a step that is cut there the factor is a polynomial.
    # Gives drive angles (rad), ``(corners,)``.
    steps, tableau, found = Steps._cut_at(scene, np.zeros(0)), radau(scene.analysis.stages), [np.zeros(0)]
    for name, load in scene.loads.items():
        if load.factor is None or not load.factor.corners:
            continue
        means = _Means.of(load, steps, tableau)
        wrong = means.outside | (np.abs(means.quadrature - means.exact) > CUTS.missed * means.largest)
        corners = np.unique(_turned(steps.rate, load.factor.corners))
        found.append(corners[wrong[np.searchsorted(np.abs(steps.start), corners, side="right") - 1]])
        if len(found[-1]) > CUTS.most_corners:
            raise SceneError(
                f"the factor changes at {len(found[-1])} angles between the points of {len(steps.start)} steps, and "
                f"steps are cut at {CUTS.most_corners} of them at most",
                place=f"loads.{name}.factor",
                hint="Take more sub_intervals, or fewer and smoother values",
            )
    return math.copysign(1, steps.rate) * np.unique(np.concatenate(found))


def loads_with_hidden_peaks(scene: Scene) -> list[str]:
    """Name the loads whose factor has a peak in a step that none of its values at the points shows."""
    # Harmonics have none where their points are as many as `enough_angles`.
    steps, tableau = Steps.of(scene), radau(scene.analysis.stages)
    return [
        name
        for name, load in scene.loads.items()
        if not (load.over_cycle is None or isinstance(load.factor, FactorHarmonics))
        and _Means.of(load, steps, tableau).outside.any()
    ]


@dataclass(frozen=True)
class _Means:
    """Means of a load's factor over steps; arrays of shape ``(steps,)``."""

    exact: Array  # exact, quadrature: the mean, and what the points of the step make of it
    quadrature: Array
    # whether the mean is not between the values at the points of the step and at those next to it
    outside: NDArray[np.bool_]
    largest: float  # the largest mean of the factor's magnitude

    @classmethod
    def of(cls, load: Varying, steps: Steps, tableau: Tableau) -> _Means:
        """Integrate a load's factor over steps."""
        assert load.over_cycle is not None
        sense, begin = math.copysign(1, steps.rate), np.abs(steps.start)
        pieces = _turned(steps.rate, factor_pieces(load.over_cycle))
        angles, weights = gauss_points(np.unique(np.concatenate([begin, pieces, [TURN]])))
        values, step = load.factor_at(sense * angles), np.searchsorted(begin, angles, side="right") - 1
        width = np.bincount(step, weights, len(begin))
        mean, size = (np.bincount(step, weights * part, len(begin)) / width for part in (values, np.abs(values)))
        seen = load.factor_at(steps.angles(tableau.c)).reshape(len(begin), -1)
        around = np.column_stack([np.roll(seen[:, -1], 1), seen, np.roll(seen[:, 0], -1)])
        largest = float(size.max())
        outside = np.maximum(around.min(axis=1) - mean, mean - around.max(axis=1)) > CUTS.hidden * largest
        return cls(mean, seen @ tableau.A[-1], outside, largest)


def _turned(rate: float, angles: ArrayLike) -> Array:
    """Give by how much (0 to 2 pi) the drive has turned at drive angles (rad), in the sense of its rate."""
    return np.asarray(np.mod(math.copysign(1, rate) * np.asarray(angles, dtype=float), TURN))


def _differences(turned: Array, others: Array) -> Array:
    """Differences of angles around the cycle, ``(angles, others)``."""
    return np.abs(np.mod(turned[:, None] - others + math.pi, TURN) - math.pi)
