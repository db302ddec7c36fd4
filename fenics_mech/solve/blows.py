"""Impulses in a cycle: rates jump at an instant, and so does what rows transmit.

With the mass M at the poses of that instant, the rows' gradients G and an impulse P of the coordinates,

    M dv + G^T L = P,    G dv = 0,

by Lagrange's equations integrated over the instant (Goldsmith, Impact (1960), ch. 2).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech.machine import Evaluation, Machine
from fenics_mech.machine.groups import Group
from fenics_mech.solve.sparse import Factors, blocks_of
from fenics_mech.terms import Response

if TYPE_CHECKING:
    from fenics_mech.solve.periodic import Path

STEP = 1e-6  # of the extent: of central differences, whose error is its square, and rounding over it


@dataclass(frozen=True)
class Blows:
    """Impulses that act together at the end of a step.

    Parameters
    ----------
    numbers
        Of the impulses among those of the machine.
    jumps
        What each adds to the rates, and the impulses of the multipliers ``(impulses, size)``.
    by_q
        Derivatives of their sum by the coordinates ``(n, n)`` (1/s).
    works
        Energy that each gives (J).
    """

    numbers: list[int]
    jumps: Array
    by_q: Array
    works: Array


def blows_of(machine: Machine, path: Path) -> dict[int, Blows]:
    """Give the impulses of a machine by the step at whose end they act.

    Parameters
    ----------
    machine
        The machine.
    path
        A motion, whose steps begin where impulses act.
    """
    at_step: dict[int, list[int]] = {}
    for number, (t, _) in enumerate(machine.blows):
        away = np.abs(np.mod(path.starts - t + path.period / 2, path.period) - path.period / 2)
        k = int(np.argmin(away))
        if away[k] > SAME * path.period:
            raise ValueError(f"an impulse acts at {t:.6g} s, where no step begins")
        at_step.setdefault((k - 1) % len(path.starts), []).append(number)
    if not at_step:
        return {}
    ends, q, v, _ = (x[:, 0] for x in path.at(np.ones(1)))
    return {k: _struck(machine, numbers, float(ends[k]), q[k], v[k]) for k, numbers in at_step.items()}


SAME = 1e-9  # of a period between instants that are one


def _struck(machine: Machine, numbers: list[int], t: float, q: Array, v: Array) -> Blows:
    n, step = machine.n, STEP * machine.extent
    beside = step * np.eye(n, machine.size)
    jumps = _jumps(machine, numbers, t, np.concatenate([q[None], q + beside, q - beside]))
    by_q = (jumps[1 : 1 + n] - jumps[1 + n :]).sum(axis=1)[:, :n].T / (2 * step)
    after = v + np.where(np.arange(machine.size) < n, jumps[0].sum(axis=0), 0.0)
    zero, works = np.zeros((2, machine.size)), []
    moved = machine.moved(np.full(2, t), np.stack([q, q]), np.stack([v, after]), zero)
    for number in numbers:
        load = machine.blows[number][1]
        found = Group.of(machine.geometry, machine.places, load).measure(moved, None)
        stress = load.respond(np.full(2, t), found.x, found.rate).stress
        works.append(-float(np.sum(stress * found.rate, axis=(1, 2)).mean()))
    return Blows(numbers, jumps[0], by_q, np.array(works))


def _jumps(machine: Machine, numbers: list[int], t: float, q: Array) -> Array:
    """Give jumps of rates and impulses of multipliers at some coordinates ``(places, impulses, size)``."""
    pattern, blocks, time = machine.pattern, blocks_of(machine.pattern, 1), np.full(len(q), t)
    found, values, _ = _momentum(machine, time, q)
    impulses = np.zeros((len(q), pattern.size, len(numbers)))
    for column, number in enumerate(numbers):
        load = machine.blows[number][1]
        group = Group.of(machine.geometry, machine.places, load)
        measured = group.measure(found.at, None)
        stress = load.respond(time, measured.x, measured.rate).stress
        force, none = np.zeros_like(q), np.zeros_like(values)
        group.spread(measured.with_response(Response(stress)), None, pattern, False, (force, none, none, none))
        impulses[:, :, column] = -force
    solved = [Factors(blocks, x[:, None, None], "an impulse").solve(y) for x, y in zip(values, impulses)]
    return np.swapaxes(np.array(solved), 1, 2)


def _momentum(machine: Machine, t: Array, q: Array) -> tuple[Evaluation, Array, NDArray[np.bool_]]:
    """Give M and G at coordinates, as entries of one matrix ``(places, entries)``, and which of them are G."""
    n, kept, pattern, zero = machine.n, machine.n + machine.held, machine.pattern, np.zeros_like(q)
    found = machine.residual(t, q, zero, zero, loads=0.0, moving=False)
    rows = np.repeat(np.arange(pattern.size), np.diff(pattern.indptr))
    of_gaps, of_modes = (rows >= n) & (pattern.indices < n), (rows >= kept) != (pattern.indices >= kept)
    return found, np.where(of_modes, 0.0, np.where(of_gaps, found.K, found.M)), of_gaps


def with_rows(machine: Machine, t: float, v: Array) -> Array:
    """Give rates that fulfil the rows of joints, by an impulse of these, where steps have left them off ``(size,)``.

    Those of drives stay. Rates beside a row, which a step corrects, would be accelerations as large as it is short.

    Parameters
    ----------
    machine
        The machine, whose chart rests.
    t
        Instant (s).
    v
        Rates ``(size,)``.
    """
    _, (values,), of_gaps = _momentum(machine, np.array([t]), np.zeros((1, machine.size)))
    off = machine.pattern.times(np.where(of_gaps, values, 0.0)[None], v[None])[0]
    off[machine.n : machine.n + len(machine.rows)][[row.leads for row in machine.rows]] = 0.0
    jump = Factors(blocks_of(machine.pattern, 1), values[:, None, None], "rates").solve(-off)
    jump[machine.n :] = 0.0
    return np.asarray(v + jump)
