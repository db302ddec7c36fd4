"""Periodic motions along a branch, through its folds: pseudo-arc-length continuation in one number of the scene.

The number is an unknown beside the motion, and a step goes along the tangent of the branch and back to it in the plane
across the tangent. Where the branch turns back in the number, which no search at a given number can follow, nothing
is special there. Motions are functions of the drive angle, so that a speed changes the equation and not the unknowns.
The number and the arc length gone are two more states beside those of the motion: then the block-cyclic system that
closes the cycle is the whole bordered system of Keller, which is regular at folds.

Source: Keller, Applications of Bifurcation Theory (1977) 359; Seydel, Practical Bifurcation and Stability Analysis,
ch. 4; Nayfeh and Balachandran, Applied Nonlinear Dynamics, ch. 6.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._guard import guarded
from fenics_mech.errors import MechanismError, SolverError
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.response.periodic.cyclic import BlockCyclic
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.newton import Orbit, orbit_of, settled
from fenics_mech.response.periodic.tableau import Tableau


@dataclass(frozen=True)
class BranchLimits:
    """Limits of the steps along a branch."""

    shortest: float = 1e-4  # of the largest step, before the branch is given up
    sharpest: float = 1.0  # angle (rad) by which the tangent may turn in a step
    reach: float = 2.0  # of a step's length: how far its end may be from its start
    difference: float = 1e-4  # of the range, over which the residual's change with the number is taken
    fold: float = 1e-4  # slope of the number along the branch that counts as none, where 1 is along the number alone
    most_trials: int = 30  # for a fold
    iterations: int = 5  # that a step of the right length takes
    turn: float = 0.5  # angle (rad) by which the tangent turns in a step of the right length
    most_iterations: int = 10  # before a point of the branch counts as not found
    parts: int = 4  # of the range: one counts as much as the size of the motion
    negligible: float = 1e-12  # of a matrix: rounding of a power of the rate that it does not have


BRANCH = BranchLimits()


@dataclass(frozen=True)
class Family:
    """The equation of motion as a function of a number of the scene.

    Parameters
    ----------
    at
        Gives the equation at the collocation points of a cycle.
    rate
        Gives the magnitude of the drive's rate (rad/s).
    ends
        The range of the number, in the order in which it is followed.
    tableau, step
        The points, and the drive angle of each step (rad).
    options
        PETSc options with the prefix "periodic_".
    """

    at: Callable[[float], Equation]
    rate: Callable[[float], float]
    ends: tuple[float, float]
    tableau: Tableau
    step: float | Array
    options: Mapping[str, Any]


@dataclass(frozen=True)
class Point:
    """A periodic motion at a value of the number.

    Parameters
    ----------
    value
        The number.
    orbit
        The motion, with derivatives by the drive angle (rad) in place of time.
    tension
        Axial force of each element (N), ``(points, elements)``, where the equation is not linear.
    fold
        Whether the branch turns back in the number here.
    iterations
        Of Newton's method.
    """

    value: float
    orbit: Orbit
    tension: Array
    fold: bool = False
    iterations: int = 0


@dataclass(frozen=True)
class _Direction:
    """A change of the motion with one of the number."""

    orbit: Orbit
    value: float

    def times(self, factor: float) -> _Direction:
        return _Direction(_combined(factor, self.orbit), factor * self.value)


@dataclass(frozen=True)
class _Metric:
    """Makes motions and numbers comparable: both count relative to their own size."""

    weight: Array  # of the displacement at the starts of the steps: root of the mass
    size: float
    span: float

    def inner(self, one: _Direction, other: _Direction) -> float:
        return float(np.sum(self.by_start(one) * other.orbit.start)) + one.value * other.value / self.span**2

    def by_start(self, direction: _Direction) -> Array:
        """What the displacement at the starts is multiplied by in the inner product with a direction."""
        return (self.weight / self.size) ** 2 * direction.orbit.start

    def length(self, direction: _Direction) -> float:
        return float(np.sqrt(self.inner(direction, direction)))


def paced(orbit: Orbit, rate: float) -> Orbit:
    """Give a motion that goes through the same states at another pace: derivatives are multiplied by the rate.

    Parameters
    ----------
    orbit
        The motion.
    rate
        Factor of the pace.
    """
    return replace(
        orbit,
        velocity=rate * orbit.velocity,
        acceleration=rate**2 * orbit.acceleration,
        start_velocity=rate * orbit.start_velocity,
    )


def continued(family: Family, first: Point, points: int) -> Iterator[Point]:
    """Follow a branch from a motion at the start of the range until it leaves the range.

    Parameters
    ----------
    family
        The equation over the number.
    first
        A motion at the start of the range, or close to one.
    points
        Smallest number of points over the range; folds come in between.

    Yields
    ------
    Point
        The motions in the order of the branch, the first one first.

    Raises
    ------
    SolverError
        When Newton's method does not come back to the branch, however short the step.
    """
    weight = np.sqrt(family.at(first.value).linear.mass.diagonal[:: len(family.tableau.points)])
    largest = BRANCH.parts / points
    metric, arc = _metric(family, weight, first), largest
    point, tangent = _corrected(family, metric, first, _Direction(_combined(0.0, first.orbit), 1.0))
    if tangent.value * (family.ends[1] - family.ends[0]) < 0:
        tangent = tangent.times(-1.0)
    yield point
    while True:
        metric = _metric(family, weight, point)
        tangent = tangent.times(1 / metric.length(tangent))
        try:
            with guarded():
                new, ahead, ended = _advanced(family, metric, point, tangent, arc)
                turns = tangent.value * ahead.value < 0
                fold = _fold(family, metric, point, tangent, new, ahead) if turns else None
        except MechanismError as error:
            arc /= 2
            if arc < BRANCH.shortest * largest:
                raise SolverError(
                    f"the branch is lost beyond {point.value:.8g}: Newton's method does not come back to it after a "
                    f"step of {arc:.1e} ({error}). Give more sub_intervals or more damping"
                ) from error
            continue
        if fold is not None:
            yield fold
        yield new
        if ended:
            return
        turn = float(np.arccos(min(1.0, metric.inner(tangent, ahead))))
        factor = min(BRANCH.iterations / new.iterations, BRANCH.turn / max(turn, 1e-3))
        arc = min(largest, arc * float(np.clip(factor, 0.5, 2)))
        point, tangent = new, ahead


def _metric(family: Family, weight: Array, point: Point) -> _Metric:
    size = float(np.linalg.norm(weight * point.orbit.start))
    return _Metric(weight, size or 1.0, abs(family.ends[1] - family.ends[0]) / BRANCH.parts)


def _advanced(
    family: Family, metric: _Metric, point: Point, tangent: _Direction, arc: float
) -> tuple[Point, _Direction, bool]:
    """Go a step along the branch, at most to an end of the range: give point and tangent there, and whether it ends."""
    low, high = sorted(family.ends)
    reached, new = point.value + arc * tangent.value, None
    if low < reached < high:
        new, turned = _corrected(family, metric, _moved(family, point, tangent.times(arc)), tangent)
        reached = new.value
    ended = not low < reached < high
    if ended or new is None:
        end = float(np.clip(reached, low, high))
        arc *= (end - point.value) / (reached - point.value)
        guess = replace(_moved(family, point, tangent.times(arc)), value=end)
        new, turned = _corrected(family, metric, guess, _Direction(_combined(0.0, tangent.orbit), 1.0))
    turned = turned.times(1 / metric.length(turned))
    cosine = metric.inner(turned, tangent)
    if abs(cosine) < np.cos(BRANCH.sharpest) or metric.length(_change(point, new)) > BRANCH.reach * arc:
        raise SolverError("the branch turns too sharply for the step")
    return new, turned.times(float(np.sign(cosine))), ended


def _fold(family: Family, metric: _Metric, point: Point, tangent: _Direction, new: Point, ahead: _Direction) -> Point:
    """Find the point between two where the number does not change along the branch, by the Illinois method.

    The number is good to about ``BRANCH.fold^2/2`` of the range, as it is stationary there.
    """
    near, last = (0.0, tangent.value), (metric.inner(tangent, _change(point, new)), ahead.value)
    for _ in range(BRANCH.most_trials):
        arc = (near[0] * last[1] - last[0] * near[1]) / (last[1] - near[1])
        found, turned = _corrected(family, metric, _moved(family, point, tangent.times(arc)), tangent)
        slope = turned.value / metric.length(turned) * float(np.sign(metric.inner(turned, tangent)))
        if abs(slope) < BRANCH.fold * metric.span:
            return replace(found, fold=True)
        near = last if slope * last[1] < 0 else (near[0], near[1] / 2)
        last = (arc, slope)
    raise SolverError(f"the fold beyond {point.value:.8g} is not found. Give more points")


def _corrected(family: Family, metric: _Metric, guess: Point, normal: _Direction) -> tuple[Point, _Direction]:
    """Come back to the branch in the plane across `normal` through a guess: give point and tangent, of any length."""
    point, tangent, changes = guess, normal, list[float]()
    while not settled(changes):
        if len(changes) == BRANCH.most_iterations or (len(changes) > 2 and changes[-1] > min(changes[:-1])):
            raise SolverError(f"Newton's method stopped after {len(changes)} iterations, changing by {changes[-1]:.1e}")
        off = metric.inner(normal, _change(guess, point))
        change, tangent = _solved(family, metric, point, normal, off)
        point = _moved(family, point, change)
        changes.append(metric.length(change))
    return replace(point, iterations=len(changes)), tangent


def _solved(
    family: Family, metric: _Metric, point: Point, normal: _Direction, off: float
) -> tuple[_Direction, _Direction]:
    """Solve for Newton's change of motion and number, and for the tangent, whose product with `normal` is 1.

    The states are ``(q, step q', number, arc length)``. In the last step the change of the arc length over the cycle
    closes the number, so that it has to be what is asked for.
    """
    flow = _bordered_flow(family, point)
    steps, n = len(flow.duration), flow.size
    whole = np.zeros((steps, 2 * n + 2, 2 * n + 2))
    whole[:, : 2 * n, : 2 * n] = flow.transitions
    whole[:, : 2 * n, 2 * n] = metric.span * flow.added[..., 1]  # the number counts in parts of the range
    whole[:, 2 * n :, 2 * n :] = np.eye(2)
    whole[:, 2 * n + 1, :n] = metric.by_start(normal)
    whole[-1, 2 * n + 1, 2 * n] = normal.value / metric.span
    whole[-1, 2 * n] += whole[-1, 2 * n + 1]
    whole[-1, 2 * n + 1] = 0

    right = np.zeros((steps, 2 * n + 2, 2))
    right[:, : 2 * n, 0] = flow.added[..., 0]
    right[-1, 2 * n] = off, -1.0
    states = np.moveaxis(BlockCyclic(whole, family.options).solve(right), -1, 0)

    def direction(state: Array, left_over: float) -> _Direction:
        value = metric.span * float(state[0, 2 * n])
        return _Direction(orbit_of(flow, state[:, : 2 * n], flow.matrices.load @ np.array([left_over, value])), value)

    return direction(states[0], 1.0), direction(states[1], 0.0)


def _bordered_flow(family: Family, point: Point) -> Flow:
    """Give the steps of the equation linearised about a motion: its loads are the residual, and that of the number."""
    equation, rate = family.at(point.value), family.rate(point.value)
    now = paced(point.orbit, rate)
    tangents = equation.linearised(now.displacement, now.velocity, point.tension, second=now.acceleration)
    left_over = tangents.load - tangents.left(now.displacement, now.velocity, now.acceleration)
    first, last = family.ends
    step = BRANCH.difference * float(np.copysign(last - first, (first + last) / 2 - point.value))  # inside the range
    later = paced(point.orbit, family.rate(point.value + step))
    change = family.at(point.value + step).residual(later.displacement, later.velocity, later.acceleration)
    change -= equation.residual(now.displacement, now.velocity, now.acceleration)
    columns = np.stack([left_over, -change / step], axis=-1)
    modal = None if tangents.modal is None else tangents.modal.paced(rate)
    matrices = Matrices(rate**2 * tangents.mass, rate * tangents.damping, tangents.stiffness, columns, modal)
    return Flow(matrices, family.tableau, family.step)


def _moved(family: Family, point: Point, change: _Direction) -> Point:
    """Change a motion and its number; the tensions follow the strain linearised about the old motion."""
    equation, value = family.at(point.value), point.value + change.value
    orbit, tension = _combined(1.0, point.orbit, 1.0, change.orbit), point.tension
    if (law := equation.system.terms.law) is not None:
        rates = family.rate(point.value) * point.orbit.velocity, family.rate(value) * orbit.velocity
        near = law.about(*equation.in_links(point.orbit.displacement, rates[0]), tension)[1]
        tension = near.at(*equation.in_links(orbit.displacement, rates[1]))
    return Point(value, orbit, tension)


def _change(start: Point, end: Point) -> _Direction:
    return _Direction(_combined(1.0, end.orbit, -1.0, start.orbit), end.value - start.value)


def _combined(factor: float, one: Orbit, second: float = 0.0, other: Orbit | None = None) -> Orbit:
    """Give ``factor * one + second * other``."""
    parts = {field.name: factor * getattr(one, field.name) for field in fields(one) if field.name != "flow"}
    if other is not None:
        parts = {name: part + second * getattr(other, name) for name, part in parts.items()}
    return Orbit(**parts)
