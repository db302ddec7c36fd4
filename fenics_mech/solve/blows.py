"""Impulses in a cycle: rates jump at an instant, and so does what rows transmit.

With the mass M at the poses of that instant, the rows' gradients G and an impulse P of the coordinates,

    M dv + G^T L = P,    G dv = 0,

by Lagrange's equations integrated over the instant (Goldsmith, Impact (1960), ch. 2).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.machine import Machine
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
    n, kept, pattern, zero = machine.n, machine.n + machine.held, machine.pattern, np.zeros_like(q)
    time, blocks = np.full(len(q), t), blocks_of(pattern, 1)
    found = machine.residual(time, q, zero, zero, loads=0.0, moving=False)
    rows = np.repeat(np.arange(pattern.size), np.diff(pattern.indptr))
    of_gaps, of_modes = (rows >= n) & (pattern.indices < n), (rows >= kept) != (pattern.indices >= kept)
    values = np.where(of_modes, 0.0, np.where(of_gaps, found.K, found.M))
    impulses = np.zeros((len(q), pattern.size, len(numbers)))
    for column, number in enumerate(numbers):
        load = machine.blows[number][1]
        group = Group.of(machine.geometry, machine.places, load)
        measured = group.measure(found.at, None)
        stress = load.respond(time, measured.x, measured.rate).stress
        force, none = np.zeros_like(q), np.zeros_like(found.M)
        group.spread(measured.with_response(Response(stress)), None, pattern, False, (force, none, none, none))
        impulses[:, :, column] = -force
    solved = [Factors(blocks, x[:, None, None], "an impulse").solve(y) for x, y in zip(values, impulses)]
    return np.swapaxes(np.array(solved), 1, 2)
