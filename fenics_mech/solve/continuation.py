"""Periodic motions along a branch, through its folds: pseudo-arc-length continuation over one number of a machine.

The number is an unknown beside the motion. A step goes along the tangent of the branch, and back to the branch in the
plane across the tangent:

    J dx + R' dp = -R,    (n, (x + dx, p + dp) - guess) = 0,

with the residual R of the cycle, its tangent J and its change R' with the number. Both right-hand sides are solved with
the same factors (Keller's bordering). J is singular at a fold alone, where dx and dp stay what they are.
Motions count by their states over shares of the period, so that a speed changes the equation and not the unknowns.

Source: Keller, Applications of Bifurcation Theory (1977) 359; Seydel, Practical Bifurcation and Stability Analysis,
ch. 4 and 5; Nayfeh and Balachandran, Applied Nonlinear Dynamics, ch. 3 and 6.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import MechanismError, SolverError
from fenics_mech.machine import Machine
from fenics_mech.solve.blows import blows_of, gaps_between
from fenics_mech.solve.newton import newton
from fenics_mech.solve.path import Path
from fenics_mech.solve.periodic import LEAST, Cycle, Iteration

FOLD, DIVIDES, DOUBLES, TURNS = "fold", "branching", "period doubling", "Neimark-Sacker"
PARTS = 4  # of the range: one counts as much as the size of the motion
TURN = 0.5  # angle (rad) by which the tangent turns in a step of the right length; twice that is too much
SHORTEST = 1e-4  # of the largest step, before the branch is given up
DIFFERENCE = 1e-4  # of the range, over which the change of the residual with the number is taken
CLOSE, MOST = 1e-7, 10  # Newton's last change, relative to the motion, and its steps
ZERO = 1e-4  # slope of the number at a fold; magnitude of a multiplier above 1 that steps make of an undamped motion
TRIALS = 30  # for a fold, or another point at which stability changes
REAL = 1e-6  # imaginary part of a multiplier that counts as none


class Driven(Protocol):
    """A machine that repeats its motion in a period (s)."""

    @property
    def machine(self) -> Machine:
        """The machine."""

    @property
    def period(self) -> float:
        """The period (s)."""


@dataclass(frozen=True)
class Family:
    """A machine as a function of a number.

    Parameters
    ----------
    at
        Gives the machine at a value of the number. All have the same coordinates.
    ends
        The range of the number, in the order in which it is followed.
    """

    at: Callable[[float], Driven]
    ends: tuple[float, float]


@dataclass(frozen=True)
class Point:
    """A periodic motion at a value of the number.

    Parameters
    ----------
    value
        The number.
    driven
        The machine at the number.
    cycle
        The motion.
    unknowns, tangent
        Motion and number, and a tangent of the branch, as of `_Branch`.
    kind
        What happens here, `FOLD`, `DIVIDES`, `DOUBLES` or `TURNS`; empty at other points.
    """

    value: float
    driven: Driven
    cycle: Cycle
    unknowns: Array
    tangent: Array
    kind: str = ""

    @cached_property
    def leading(self) -> complex:
        """The largest Floquet multiplier."""
        return complex(self.cycle.multipliers(2)[0])

    @property
    def stable(self) -> bool:
        """Whether no disturbance grows."""
        return abs(self.leading) <= 1 + ZERO


def continued(family: Family, first: Cycle, points: int) -> Iterator[Point]:
    """Follow a branch from a motion at the start of the range until it leaves the range.

    Parameters
    ----------
    family
        The machine over the number.
    first
        The motion at the start of the range.
    points
        Smallest number of points over the range. Folds, and points at which stability changes, come in between.

    Yields
    ------
    Point
        The motions in the order of the branch, the first one first.

    Raises
    ------
    SolverError
        When Newton's method does not come back to the branch, however short the step.
    """
    branch = _Branch(family, first.path)
    largest = arc = PARTS / points
    value, sense = family.ends[0], float(np.sign(family.ends[1] - family.ends[0]))
    point = Point(value, family.at(value), first, branch.vector(first.path, value), sense * branch.number)
    branch.measure(point)
    point = replace(branch.corrected(point.unknowns, branch.number, point), value=value)
    yield point
    while True:
        try:
            branch.measure(point)
            new, ended = branch.advanced(point, arc)
            special = branch.special(point, new)
        except MechanismError as error:
            arc /= 2
            if arc < SHORTEST * largest:
                raise SolverError(
                    f"the branch is lost beyond {point.value:.8g}: Newton's method does not come back to it after a "
                    f"step of {arc:.1e} ({error}). Give more sub_intervals or more damping"
                ) from error
            continue
        if special is not None:
            yield special
        yield new
        if ended:
            return
        arc = min(largest, arc * float(np.clip(TURN / max(branch.angle(point, new), 1e-3), 0.5, 2)))
        point = new


class _Branch:
    """Motion and number as one vector, and the branch in its space."""

    # The vector holds coordinates where steps begin, rates there and accelerations by shares of the period,
    # multipliers, and the number in parts of the range (unknowns,). Its length is that of the coordinates, weighed by
    # the root of the mass and relative to the motion of the last point, and of the number.

    def __init__(self, family: Family, first: Path) -> None:
        self.family, self.steps = family, first
        self.span = abs(family.ends[1] - family.ends[0]) / PARTS
        self.parts = np.cumsum([first.q0.size, first.v0.size])
        self.weights = np.zeros(self.parts[-1] + first.a.size + 1)
        self.number = np.append(self.weights[:-1], 1.0)  # the direction of the number alone
        self.weights[-1] = 1.0

    def vector(self, path: Path, value: float) -> Array:
        """Give motion and number, or a change of both, as a vector."""
        paced = path.paced(1.0)
        return np.concatenate([paced.q0.ravel(), paced.v0.ravel(), paced.a.ravel(), [value / self.span]])

    def path(self, unknowns: Array, period: float) -> Path:
        """Give the motion of a vector in a period (s)."""
        paced, parts = self.steps.paced(1.0), np.split(unknowns[:-1], self.parts)
        q0, v0, a = (x.reshape(of.shape) for x, of in zip(parts, (paced.q0, paced.v0, paced.a)))
        return replace(paced, q0=q0, v0=v0, a=a).paced(period)

    def measure(self, point: Point) -> None:
        """Measure lengths by the motion of a point."""
        machine, of_q = point.cycle.machine, point.unknowns[: self.parts[0]].reshape(self.steps.q0.shape)
        diagonal = machine.pattern.at(*(np.arange(machine.n)[:, None],) * 2)[:, 0, 0]
        mass = np.maximum(point.cycle.evaluation.M[:, diagonal].mean(axis=0), 0.0)
        weights = np.zeros_like(of_q)
        weights[:, : machine.n] = mass
        least = (LEAST * machine.extent) ** 2 * weights.sum()
        self.weights[: self.parts[0]] = weights.ravel() / max(float(np.sum(weights * of_q**2)), least)

    def inner(self, one: Array, other: Array) -> float:
        """Multiply two directions."""
        return float(one @ (self.weights * other))

    def length(self, change: Array) -> float:
        """Give the length of a change."""
        return float(np.sqrt(self.inner(change, change)))

    def angle(self, point: Point, new: Point) -> float:
        """Give the angle between the tangents of two points (rad)."""
        cosine = self.inner(point.tangent, new.tangent) / (self.length(point.tangent) * self.length(new.tangent))
        return float(np.arccos(np.clip(cosine, -1.0, 1.0)))

    def slope(self, point: Point) -> float:
        """Give the change of the number along the branch."""
        return float(point.tangent[-1]) / self.length(point.tangent)

    def advanced(self, point: Point, arc: float) -> tuple[Point, bool]:
        """Go a step along the branch, at most to an end of the range, and say whether it ends there."""
        low, high = sorted(self.family.ends)
        tangent = point.tangent / self.length(point.tangent)
        reached, new = point.value + arc * tangent[-1] * self.span, None
        if low < reached < high:
            new = self.corrected(point.unknowns + arc * tangent, tangent, point)
            reached = new.value
        ended = not low < reached < high
        if ended or new is None:
            end = float(np.clip(reached, low, high))
            arc *= (end - point.value) / (reached - point.value)
            guess = point.unknowns + arc * tangent
            guess[-1] = end / self.span
            new = replace(self.corrected(guess, self.number, point), value=end)
        far = self.length(new.unknowns - point.unknowns) * np.cos(2 * TURN) > arc  # a smooth branch is nearer
        if far or self.angle(point, new) > 2 * TURN:
            raise SolverError("the branch turns too sharply for the step")
        return new, ended

    def corrected(self, guess: Array, normal: Array, before: Point) -> Point:
        """Come back to the branch in the plane across `normal` through a guess that was made at a point of it."""
        known = before.cycle
        near = Iteration(known.machine, known.path)
        near.found = known.evaluation
        near.predict(self.path(guess - before.unknowns, known.path.period))
        y, stresses, tangent = guess, near.stresses, normal

        def step() -> float:
            nonlocal y, stresses, tangent
            driven = self.family.at(float(y[-1]) * self.span)
            iteration = Iteration(driven.machine, self.path(y, driven.period), stresses)
            linear = iteration.linearised()
            force, gaps = (
                iteration.found.force.reshape(iteration.path.a.shape),
                gaps_between(iteration.path, linear.blows),
            )
            change = self.vector(linear.change(-force, gaps), 0.0)
            along = self.vector(linear.change(*self.by_number(y, force, gaps)), self.span)
            dp = -self.inner(normal, y - guess + change) / self.inner(normal, along)
            iteration.predict(self.path(change + dp * along, driven.period))
            y, stresses, tangent = y + change + dp * along, iteration.stresses, along
            return self.length(change + dp * along)

        changes = newton(step, CLOSE, MOST, "a motion beside the last one")
        value = float(y[-1]) * self.span
        driven = self.family.at(value)
        path = self.path(y, driven.period)
        cycle = Cycle(driven.machine, path, changes)
        return Point(value, driven, cycle, y, np.copysign(1.0, self.inner(tangent, before.tangent)) * tangent)

    def by_number(self, y: Array, force: Array, gaps: Array) -> tuple[Array, Array]:
        """Give what a change of the number by a part of the range does: forces to be met, and gaps."""
        value, (first, last) = float(y[-1]) * self.span, self.family.ends
        step = DIFFERENCE * float(np.copysign(last - first, (first + last) / 2 - value))  # inside the range
        driven = self.family.at(value + step)
        path = self.path(y, driven.period)
        beside = Iteration(driven.machine, path).evaluated(tangents=False).force.reshape(force.shape)
        share = self.span / step
        return -share * (beside - force), share * (gaps_between(path, blows_of(driven.machine, path)) - gaps)

    def special(self, point: Point, new: Point) -> Point | None:
        """Find the fold between two points, or else where stability changes; None where neither is."""
        if point.tangent[-1] * new.tangent[-1] < 0:
            return replace(self.located(point, new, self.slope, ZERO), kind=FOLD)
        if point.stable == new.stable:
            return None
        found = self.located(point, new, lambda at: abs(at.leading) - 1 - ZERO / 2, ZERO / 2)
        leading = found.leading
        kind = TURNS if abs(leading.imag) > REAL else DOUBLES if leading.real < 0 else DIVIDES
        return replace(found, kind=kind)

    def located(self, point: Point, new: Point, measure: Callable[[Point], float], near: float) -> Point:
        """Find the point between two at which a measure of them is 0, by the Illinois method."""
        # Source: Dowell and Jarratt, BIT 11 (1971) 168.
        tangent = point.tangent / self.length(point.tangent)
        low, high = (0.0, measure(point)), (self.inner(tangent, new.unknowns - point.unknowns), measure(new))
        for _ in range(TRIALS):
            arc = (low[0] * high[1] - high[0] * low[1]) / (high[1] - low[1])
            found = self.corrected(point.unknowns + arc * tangent, tangent, point)
            size = measure(found)
            if abs(size) < near:
                return found
            low = high if size * high[1] < 0 else (low[0], low[1] / 2)
            high = (arc, size)
        raise SolverError(f"the point beyond {point.value:.8g} where stability changes is not found. Give more points")
