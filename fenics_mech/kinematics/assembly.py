"""Following an assembly branch over the drive angle, from a first position on."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import AssemblyError, SceneError
from fenics_mech.kinematics.conditioning import (
    CONDITION,
    REMEDY,
    links_moved,
    locks,
    refuse_singular,
    singular_values,
    smallest_value,
)
from fenics_mech.kinematics.freedom import describe, free_motions
from fenics_mech.kinematics.loops import Loops
from fenics_mech.kinematics.motion import rates_by_drives


@dataclass(frozen=True)
class AssemblyLimits:
    """Limits of putting a linkage together, and of following its branch in coarse steps."""

    closed: float = 1e-13  # of the open loops, relative to the linkage's size
    closed_coarsely: float = 1e-9  # the same at the points of the branch, from which positions are computed
    largest_step: float = np.pi / 8  # of the drive angle: several points in each swing of a link
    smallest_step: float = 1e-12  # of the drive angle: below it the step is rounding
    most_steps: int = 10_000  # in a cycle: linkages take 16 to 60, a law's 100th harmonic 2,600, a minute 10,000
    farthest_from_guess: float = np.pi / 2  # of an assembled link (rad): beyond it another branch was meant
    farthest_from_held: float = np.pi / 4  # of a rough angle (rad) from the one at which a weld holds its link
    largest_correction: float = 0.05  # of a predicted link angle (rad): beyond it the step may have left the branch
    largest_turn: float = 0.1  # of a link's rate over the largest: beyond it the step may have jumped over a corner
    at_rest: float = 1e-9  # rate of a link's angle that counts as none: in a dwell rates are rounding


ASSEMBLY = AssemblyLimits()


@dataclass(frozen=True)
class AssemblyBranch:
    """Points of the assembly branch."""

    theta: Array  # drive coordinate (rad), ascending, (points,)
    q: Array  # coordinates and their first two derivatives by the drive coordinate, (points, 3 links)
    rate: Array
    curvature: Array
    # sign of the loop Jacobian's determinant, which is the same all along a branch and another one on its neighbour
    side: float


def coordinates_at(loops: Loops, theta: Array, branch: AssemblyBranch) -> Array:
    """Solve for the coordinates at drive angles by Newton's method, from between the points of a branch."""
    # theta (angles,) (rad)
    ahead = (theta - branch.theta[0])[:, None]
    guess = branch.q[0] + branch.rate[0] * ahead + branch.curvature[0] * ahead**2 / 2
    if len(branch.theta) > 1:
        guess = _between(branch, theta)
    q, converged = newton(loops, guess, loops.drive(theta).value)
    if not converged.all():
        i = int(np.flatnonzero(~converged)[0])
        raise AssemblyError(
            f"the linkage cannot be assembled at drive angle {degrees(theta[i])}: {open_loop(loops, q[i])}"
        )
    if (strays := side(loops, q) != branch.side).any():
        where = degrees(theta[int(np.argmax(strays))])
        raise AssemblyError(f"the linkage is at a change point at drive angle {where}: its motion is not unique there")
    return q


def _between(branch: AssemblyBranch, theta: Array) -> Array:
    """Coordinates at drive angles by cubics between the points of a branch, ``(angles, 3 links)``."""
    i = np.clip(np.searchsorted(branch.theta, theta, side="right") - 1, 0, len(branch.theta) - 2)
    step, ahead = (branch.theta[i + 1] - branch.theta[i])[:, None], (theta - branch.theta[i])[:, None]
    slope, rate = (branch.q[i + 1] - branch.q[i]) / step, branch.rate[i]
    bend = (rate + branch.rate[i + 1] - 2 * slope) / step
    square, cubic = (slope - rate) / step - bend, bend / step
    return branch.q[i] + rate * ahead + square * ahead**2 + cubic * (ahead**2 * ahead)


def side(loops: Loops, q: Array) -> Array:
    """Sign of the loop Jacobian's determinant, ``(positions,)``, of coordinates ``(positions, 3 links)``."""
    return np.linalg.slogdet(loops.jacobian(q))[0]


def newton(
    loops: Loops,
    guess: Array,
    drive: Array,
    *,
    iterations: int = 12,
    damped: bool = False,
    tolerance: float = ASSEMBLY.closed,
) -> tuple[Array, np.ndarray]:
    """Newton's method on the loop equations of all positions at once."""
    # guess (positions, 3 links); drive (positions, drives)
    q = guess.copy()
    turns = 1 + np.abs(drive).max(axis=1, initial=0.0)[:, None]  # angles of many turns have fewer digits
    unit = loops.scale * turns
    for _ in range(iterations):
        residual = loops.residual(q, drive)
        closed = (np.abs(residual) < tolerance * unit).all(axis=1)
        jacobian = loops.jacobian(q)
        if damped:  # least squares and short steps, as the guess may be far away or the Jacobian singular
            without_units = zip(jacobian * loops.unit / loops.scale[:, None], residual / loops.scale)
            step = -loops.unit * np.stack([np.linalg.lstsq(j, r, rcond=1e-9)[0] for j, r in without_units])
            step *= np.minimum(1, 0.5 / np.maximum(np.abs(step[:, 2::3]).max(axis=1), 1e-300))[:, None]
        else:
            try:
                step = -np.linalg.solve(jacobian, residual[..., None])[..., 0]
            except np.linalg.LinAlgError:
                return q, closed
        if closed.all():  # a last step takes off what the tolerance leaves, where it can
            last = loops.residual(q + step, drive)
            improves = np.abs(last / unit).max(axis=1, initial=0.0) < np.abs(residual / unit).max(axis=1, initial=0.0)
            return np.where(improves[:, None], q + step, q), closed
        q = q + step
    residual = loops.residual(q, drive)
    return q, (np.abs(residual) < 10 * tolerance * unit).all(axis=1)


def follow_branch(loops: Loops, start: Array, theta: Array, to_the_end: bool = False) -> AssemblyBranch:
    """Follow the assembly branch from theta = 0 over the drive angles, in coarse steps that the branch allows."""
    # start (3 links,); theta (rad)
    _refuse_free(loops, start)
    refuse_singular(loops, np.zeros(1), start[None])
    points = [(0.0, start, *_derivatives_at(loops, start, 0.0))]
    ours = float(side(loops, start[None])[0])
    for sign, end in ((1.0, theta.max(initial=0.0)), (-1.0, -theta.min(initial=0.0))):
        here, q, rate, curvature = points[0]
        step, tried = ASSEMBLY.largest_step, 0
        while sign * here < end:
            ahead, tried = sign * step, tried + 1
            if tried > ASSEMBLY.most_steps * max(1.0, end / (2 * math.pi)):
                raise _too_rough(loops, here, rate, tried - 1)
            found = _stepped(loops, (here, q, rate, curvature), ahead)
            if found is not None and side(loops, found[0][None])[0] == ours:
                here, (q, rate, curvature) = here + ahead, found
                points.append((here, q, rate, curvature))
                step = min(1.5 * step, ASSEMBLY.largest_step)
                stuck = sign * here < end and smallest_value(loops, q) < CONDITION.singular
            else:
                step /= 2
                stuck = step < ASSEMBLY.smallest_step
            if stuck:
                if to_the_end:
                    break
                raise _stuck(loops, here, q, rate)
    points.sort(key=lambda point: point[0])
    knots, poses, rates, curvatures = (np.array(part) for part in zip(*points))
    return AssemblyBranch(knots, poses, rates, curvatures, ours)


def _stepped(loops: Loops, point: tuple[float, Array, Array, Array], ahead: float) -> tuple[Array, Array, Array] | None:
    """Give coordinates and their derivatives a step ahead, or None where the step may have left the branch."""
    here, q, rate, curvature = point
    guess = q + rate * ahead + curvature * ahead**2 / 2
    found, closed = newton(
        loops, guess[None], loops.drive(np.array([here + ahead])).value, tolerance=ASSEMBLY.closed_coarsely
    )
    if not closed[0] or np.abs((found[0] - guess)[2::3]).max() > ASSEMBLY.largest_correction:
        return None
    new_rate, new_curvature = _derivatives_at(loops, found[0], here + ahead)
    turn = np.abs((new_rate - rate - curvature * ahead)[2::3]).max()
    if turn > ASSEMBLY.largest_turn * max(ASSEMBLY.at_rest, *(np.abs(part[2::3]).max() for part in (rate, new_rate))):
        return None
    return found[0], new_rate, new_curvature


def _too_rough(loops: Loops, here: float, rate: Array, tried: int) -> AssemblyError:
    """Say that a motion changes too fast to be followed."""
    return AssemblyError(
        f"the motion cannot be followed over the cycle: after {tried} steps the drive is at {degrees(here)} only, "
        f"where link {loops.links[_fastest(rate)]} turns fastest. Give a drive law that changes less often in a cycle"
    )


def _stuck(loops: Loops, here: float, q: Array, rate: Array) -> AssemblyError:
    """Say what keeps a branch from going on."""
    if locks(loops, q, rate):
        return AssemblyError(
            f"the drive cannot turn beyond {degrees(here)}: the linkage locks there "
            f"({loops.links[_fastest(rate)]} turns {np.abs(rate[2::3]).max():.3g} times as fast as the drive)"
        )
    moved = ", ".join(links_moved(loops, singular_values(loops, q[None])[1][0, -1]))
    return AssemblyError(
        f"the linkage is at a change point at drive angle {degrees(here)}: its motion is not unique there, as {moved} "
        f"can go on in two ways. {REMEDY}"
    )


def _refuse_free(loops: Loops, q: Array) -> None:
    """Raise where there are fewer equations than coordinates, and name what can move while the drives stand still."""
    if len(loops.names) >= len(q):
        return
    left = describe(loops.scene.links, loops.scene.joints, q, free_motions(loops, q))
    drives, freedoms = ("1 drive" if loops.drives == 1 else f"{loops.drives} drives"), "freedom" + "s" * (len(left) > 1)
    raise SceneError(
        f"the linkage is under-driven: with its {drives} held it has {len(left)} {freedoms} left: {'; '.join(left)}",
        place="drive",
        hint="Add a drive or a joint. A spring does not say where a driven linkage is",
    )


def derivatives(loops: Loops, q: Array, theta: Array) -> tuple[Array, Array]:
    """First and second derivative of the coordinates by the drive coordinate, each ``(positions, 3 links)``."""
    # q (positions, 3 links); theta (positions,) (rad)
    jet = loops.drive(theta)
    try:
        return rates_by_drives(loops, q, jet.first, jet.second)
    except np.linalg.LinAlgError as error:
        where = f" at drive angle {degrees(theta[0])}" if len(theta) == 1 else ""
        raise AssemblyError(
            f"the linkage is at a dead centre{where}: its velocities are not determined there"
        ) from error


def _derivatives_at(loops: Loops, q: Array, theta: float) -> tuple[Array, Array]:
    """Both derivatives at one position, ``(3 links,)`` each."""
    rate, curvature = derivatives(loops, q[None], np.array([theta]))
    return rate[0], curvature[0]


def _fastest(rate: Array) -> int:
    return int(np.abs(rate[2::3]).argmax())


def open_loop(loops: Loops, q: Array) -> str:
    """Say which joint stays open most, and by how much."""
    gaps = loops.gaps(q)
    worst = max(gaps, key=gaps.__getitem__)
    return f"joint {worst} stays open by {gaps[worst]:.3g} m"


def degrees(angle: float) -> str:
    """Write an angle (rad) in degrees."""
    return f"{np.degrees(angle):.6g} deg"
