"""Mobility: how a machine can move if its members do not bend, what no drive leads, and which rows say nothing new."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.joints import Riding, Row
from fenics_mech.machine.machine import Machine
from fenics_mech.terms import Beams, Look, Measure

NOUGHT = 1e-8  # of the largest singular value: places are exact to 1e-12, and errors of making are above 1e-6
STEP = 0.1  # rad, or share of the machine's size: out of a drawn position that is a special one
CORRECTIONS = 8  # of Newton's method, which then has converged but where there is no motion
SLACK = 1e-9  # m/N: a bearing of steel has ten times as much


@dataclass(frozen=True)
class Mobility:
    """How a machine can move near the position in which it is drawn.

    Parameters
    ----------
    freedoms
        Degrees of freedom that are left if no drive acts.
    at
        Coordinates of the position, beside the drawn one, where the others hold ``(size,)``.
    idle
        Motions that are left there with all drives at rest ``(motions, size)``.
    redundant
        Numbers of the rows that depend on each other.
    surplus
        How many of them say nothing new.
    """

    freedoms: int
    at: Array
    idle: Array
    redundant: list[int]
    surplus: int


def mobility(machine: Machine, t: float = 0.0) -> Mobility:
    """Count freedoms: coordinates less the rank of all rows and of the strains of members.

    A drawn position may be a special one. So the machine is moved, and what has the larger rank counts.

    Parameters
    ----------
    machine
        The machine.
    t
        Instant of its drives (s).
    """
    n, q = machine.n, np.zeros(machine.size)
    units = np.full(n, machine.extent)  # of coordinates that count as equal: this way (m), and 1 rad
    turns = machine.places[:, machine.geometry.d :]
    units[turns[turns >= 0]] = 1.0
    undriven = np.ones(machine.size - n, dtype=bool)
    undriven[: len(machine.rows)] = [not row.leads for row in machine.rows]

    drawn = _left(conditions(machine, t, q, undriven)[0] * units)
    if len(drawn):
        way = drawn.sum(axis=0)
        q[:n] = STEP * units * way / np.abs(way).max()
        for _ in range(CORRECTIONS):
            J, gaps = conditions(machine, t, q, undriven)
            q[:n] -= units * np.linalg.lstsq(J * units, gaps, rcond=NOUGHT)[0]
    moved = _left(conditions(machine, t, q, undriven)[0] * units)
    idle = _left(conditions(machine, t, q, undriven | True)[0] * units) * units
    dependent = _left((conditions(machine, t, q, undriven | True, members=False)[0] * units).T)
    redundant = np.nonzero(np.abs(dependent).max(axis=0, initial=0.0) > NOUGHT)[0].tolist()
    return Mobility(
        min(len(drawn), len(moved)), q, np.pad(idle, ((0, 0), (0, machine.size - n))), redundant, len(dependent)
    )


def loosen(machine: Machine, redundant: list[int]) -> None:
    """Give slack to rows that depend on each other, so that their forces are those of equal bearings.

    Parameters
    ----------
    machine
        The machine.
    redundant
        Numbers of the rows.
    """
    rows = len(machine.rows)
    for k in redundant:
        if k >= rows:
            turned = machine.rides[k - rows].look == Riding.TURNED
            machine.rides[k - rows] = replace(
                machine.rides[k - rows], slack=SLACK / machine.extent**2 if turned else SLACK
            )
            continue
        turns = machine.rows[k].measure.look in {Look.ALIGNED, Look.ANGLE}
        machine.rows[k] = replace(machine.rows[k], slack=SLACK / machine.extent**2 if turns else SLACK)


def hold_idle(machine: Machine, found: Mobility) -> list[int]:
    """Hold each idle turn by a row, whose multiplier tells the moment that it takes; give the numbers of these rows.

    A direction of the pose that turns fastest stays normal to one of the fixed frame.

    Parameters
    ----------
    machine
        The machine.
    found
        Its mobility.
    """
    g = machine.geometry
    first = len(machine.rows)
    for motion in found.idle:
        rates = np.append(motion, 0.0)[machine.places][:, g.d :]
        pose = int(np.argmax(np.linalg.norm(rates, axis=1)))
        across = g.axes(rates[pose])[:, 1] if g.d == 3 else np.array([1.0, 0.0])
        fixed = g.skew(rates[pose]) @ across
        ends = machine.at_ground(axes=g.axes(fixed)), machine.end(pose, axes=g.axes(across))
        machine.rows.append(Row(ends, Measure(Look.ALIGNED, 0, 0), name="idle"))
    machine.forget_plan()
    return list(range(first, len(machine.rows)))


def conditions(machine: Machine, t: float, q: Array, kept: np.ndarray, *, members: bool = True) -> tuple[Array, Array]:
    """Give derivatives by coordinates of the kept rows, and of all strains of members; and what each misses."""
    n, size = machine.n, machine.size
    zero = np.zeros((1, size))
    found = machine.residual(np.array([t]), q[None], zero, zero, loads=0.0, moving=False)
    derivatives = [machine.pattern.matrix(found.K[0])[n:, :n].toarray()[kept]]
    gaps = [found.force[0, n:][kept]]
    for term, group, measured in zip(machine.terms, machine.groups, found.terms):
        if members and isinstance(term, Beams):
            by = np.einsum("emj,cej->emc", measured.gradient[0], group.variables(np.eye(size)))
            derivatives.append(by.reshape(-1, size)[:, :n])
            gaps.append(measured.x[0].ravel())
    J = np.concatenate(derivatives)
    if not np.isfinite(J).all():
        bad = ~np.isfinite(derivatives[0]).all(axis=1)
        names = [row.name for row, here in zip(machine.rows, kept) if here] + [ride.name for ride in machine.rides]
        where = f"row of joint {names[int(np.argmax(bad))]!r}" if bad.any() else "beam element"
        raise ValueError(
            f"a {where} cannot be measured where it is drawn: a place, an axis or a length is no number, or its ends "
            "are at one place and their distance has no direction"
        )
    return J, np.concatenate(gaps)


def _left(J: Array) -> Array:
    """Give unit vectors that a matrix takes to nothing, its rows brought to one size ``(vectors, columns)``."""
    sizes = np.linalg.norm(J, axis=1, keepdims=True)
    values, vectors = np.linalg.svd(J / np.where(sizes > 0, sizes, 1.0))[1:]
    return np.asarray(vectors[int(np.sum(values > NOUGHT * values.max(initial=0.0))) :])
