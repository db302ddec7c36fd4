"""Poincaré section of a motion: its state once in each period, or as often as a freedom passes a place.

Source: Nayfeh and Balachandran, Applied Nonlinear Dynamics (1995), chapter 7.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.scene import Scene
from fenics_mech.scene.analysis_options import PoincareSection
from fenics_mech.solve import Step

NODES = 24  # at which a step is looked at for passages, at least
NODES_IN_A_RADIAN = 4  # of a pin that turns fast
ROUNDING = 1e-12  # of the time, by which a passage may be beside the end of a step
Freedoms = Callable[[Step, Array], tuple[Array, Array]]  # places and rates at shares of a step, ``(shares, freedoms)``


@dataclass(frozen=True)
class SectionPoints:
    """States in the section.

    Parameters
    ----------
    time
        When (s), ``(points,)``.
    place, rate
        Angles and strokes of the freedoms there, and their rates, ``(points, freedoms)``.
    """

    time: Array
    place: Array
    rate: Array


@dataclass
class PoincareRecord:
    """Finds the points of the section in the steps of a motion.

    Parameters
    ----------
    scene
        The scene, with freedoms.
    section
        What it states.
    freedoms
        Gives angles and strokes of the freedoms in a step, and their rates.
    """

    scene: Scene
    section: PoincareSection
    freedoms: Freedoms
    found: list[tuple[float, Array, Array]] = field(default_factory=list)

    def take(self, step: Step) -> None:
        """Find the points in a step that is solved."""
        for time in self._times(step):
            place, rate = self._at(step, np.array([time]))
            self.found.append((time, place[0], rate[0]))

    def points(self) -> SectionPoints:
        """Give what was found."""
        n = len(self.scene.freedoms)
        time = np.array([one[0] for one in self.found])
        place, rate = (np.array([one[i] for one in self.found]).reshape(-1, n) for i in (1, 2))
        return SectionPoints(time, place, rate)

    def _at(self, step: Step, times: Array) -> tuple[Array, Array]:
        return self.freedoms(step, (times - step.t) / step.h)

    def _times(self, step: Step) -> list[float]:
        """Times in a step, its end included and its start not."""
        if self.section.joint is not None:
            return self._passages(step)
        every = self.section.every or self.scene.period
        first, last = ((at * (1 + ROUNDING)) / every for at in (step.t, step.t + step.h))
        return [every * k for k in range(math.floor(first) + 1, math.floor(last) + 1)]

    def _passages(self, step: Step) -> list[float]:
        """Times at which a freedom passes its place."""
        which, turns = list(self.scene.freedoms).index(str(self.section.joint)), self._turns

        def ahead(times: Array) -> Array:
            way = self._at(step, times)[0][:, which] - self.section.at
            return np.sin(way / 2) * np.sign(np.cos(way / 2)) if turns else way

        end, nodes = step.t + step.h, NODES
        if turns:
            rate = self._at(step, np.linspace(step.t, end, NODES))[1][:, which]
            nodes += int(NODES_IN_A_RADIAN * step.h * np.abs(rate).max())
        times = np.linspace(step.t, end, nodes)
        values, sign = ahead(times), 1.0 if self.section.direction == "+" else -1.0
        passed = (sign * values[:-1] < 0) & (sign * values[1:] >= 0)
        if turns:
            passed &= np.abs(values[1:] - values[:-1]) < 1  # half a turn away the difference jumps
        if not passed.any():
            return []
        from scipy.optimize import brentq  # noqa: PLC0415  (slow to import, and few steps pass the section)

        known = dict(zip(times.tolist(), values.tolist()))  # anew, rounding may give a value near 0 another sign

        def value(time: float) -> float:
            return known[time] if time in known else float(ahead(np.array([time]))[0])

        return [float(brentq(value, times[k], times[k + 1])) for k in np.flatnonzero(passed)]

    @property
    def _turns(self) -> bool:
        return self.scene.joints[str(self.section.joint)].kind == "revolute"
