"""Impulses in a cycle: rates jump at an instant, and so does what rows transmit.

With the mass M at the poses of that instant, the rows' gradients G and an impulse P of the coordinates,

    M dv + G^T L = P,    G dv = 0,

by Lagrange's equations integrated over the instant (Goldsmith, Impact (1960), ch. 2).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.machine import Machine
from fenics_mech.machine.groups import Group
from fenics_mech.solve.compiled_steps import accelerated
from fenics_mech.solve.path import SAME, Path
from fenics_mech.terms import Response

STEP = 1e-6  # of the extent: of central differences, whose error is its square, and rounding over it


@dataclass(frozen=True)
class Blows:
    """Impulses that act together at the end of a step."""

    numbers: list[int]  # of the impulses among those of the machine
    jumps: Array  # what each adds to the rates, and the impulses of the multipliers (impulses, size)
    by_q: Array  # derivatives of their sum by the coordinates (n, n) (1/s)
    works: Array  # energy that each gives (J)


def blows_of(machine: Machine, path: Path) -> dict[int, Blows]:
    """Give the impulses of a machine by the step at whose end they act."""
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


def gaps_between(path: Path, blows: dict[int, Blows]) -> Array:
    """Give by how much steps miss the next one: coordinates, and rates times the mean step ``(steps, 2 n)``."""
    n, (_, q, v, _) = path.n, path.at(np.ones(1))
    end_q, end_v = q[:, 0, :n], v[:, 0, :n]
    for k, struck in blows.items():
        end_v[k] += struck.jumps[:, :n].sum(axis=0)
    q, v = end_q - np.roll(path.q0, -1, axis=0)[:, :n], end_v - np.roll(path.v0, -1, axis=0)[:, :n]
    return np.concatenate([q, path.period / len(path.starts) * v], axis=1)


def _struck(machine: Machine, numbers: list[int], t: float, q: Array, v: Array) -> Blows:
    n, step = machine.n, STEP * machine.extent
    beside = step * np.eye(n, machine.size)
    around = jumps(machine, numbers, t, np.concatenate([q[None], q + beside, q - beside]))
    by_q = (around[1 : 1 + n] - around[1 + n :]).sum(axis=1)[:, :n].T / (2 * step)
    return Blows(numbers, around[0], by_q, _works(machine, numbers, t, q, v, around[0]))


def struck(machine: Machine, numbers: list[int], t: float, v: Array) -> tuple[Array, Array]:
    """Give what impulses of a machine, by their numbers, do at the poses of its chart, which rests."""
    # v (size,)
    still = np.zeros(machine.size)
    added = jumps(machine, numbers, t, still[None])[0]
    return added, _works(machine, numbers, t, still, v, added)


def _works(machine: Machine, numbers: list[int], t: float, q: Array, v: Array, added: Array) -> Array:
    """Give the energy that impulses give, by the mean of the rates before and after ``(impulses,)`` (J)."""
    after = v + np.where(np.arange(machine.size) < machine.n, added.sum(axis=0), 0.0)
    zero, works = np.zeros((2, machine.size)), []
    moved = machine.moved(np.full(2, t), np.stack([q, q]), np.stack([v, after]), zero)
    for number in numbers:
        load = machine.blows[number][1]
        found = Group.of(machine.geometry, machine.places, load).measure(moved, None)
        stress = load.respond(np.full(2, t), found.x, found.rate).stress
        works.append(-float(np.sum(stress * found.rate, axis=(1, 2)).mean()))
    return np.array(works)


def jumps(machine: Machine, numbers: list[int], t: float, q: Array) -> Array:
    """Give jumps of rates and impulses of multipliers ``(places, impulses, size)``."""
    # q (places, size)
    zero, time, found_of_all = np.zeros_like(q), np.full(len(q), t), []
    found = machine.residual(time, q, zero, zero, loads=0.0, moving=False)
    for number in numbers:
        load = machine.blows[number][1]
        group = Group.of(machine.geometry, machine.places, load)
        measured = group.measure(found.at, None)
        stress = load.respond(time, measured.x, measured.rate).stress
        force, none = np.zeros_like(q), np.zeros_like(found.M)
        group.spread(
            replace(measured, response=Response(stress)), None, found.pattern, False, (force, none, none, none)
        )
        found_of_all.append(accelerated(machine, found, -force))
    return np.stack(found_of_all, axis=1)


def with_rows(machine: Machine, t: float, v: Array) -> Array:
    """Give rates that fulfil the rows of joints, by an impulse of these, where steps have left them off ``(size,)``."""
    # v (size,)
    # Those of drives stay. Rates beside a row, which a step corrects, would be accelerations as large as it is short.
    zero, rows, n = np.zeros((1, machine.size)), len(machine.rows), machine.n
    found = machine.residual(np.array([t]), zero, zero, zero, loads=0.0, moving=False)
    off = machine.pattern.times(found.K, v[None])
    off[:, :n], off[:, n + machine.held :] = 0.0, 0.0
    off[:, n : n + rows][:, [row.leads for row in machine.rows]] = 0.0
    jump = accelerated(machine, found, -off)[0]
    jump[n:] = 0.0
    return np.asarray(v + jump)
