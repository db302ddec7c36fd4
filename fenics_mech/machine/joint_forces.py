"""Forces of joints: what the poses of a body need beside everything else that acts on them."""

from __future__ import annotations

from copy import copy

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.machine.machine import Machine


def reactions(machine: Machine, t: Array, q: Array, v: Array, a: Array, joint: str) -> Array:
    """Give what holds every pose, without rows of a joint, ``(instants, poses, d + turns)`` (N, N m).

    It is the residual of the same machine whose poses share nothing and rest nowhere. So where a pose shares its place
    with others, or rests, it is the reaction there.

    Parameters
    ----------
    machine
        The machine.
    t, q, v, a
        Instants and motion, as its residual takes them.
    joint
        Name of the rows that are left out.
    """
    apart = copy(machine)
    apart.forget_plan()
    size, count = machine.geometry.size, len(machine.r)
    numbers = np.arange(count * size).reshape(count, size)
    apart._places, apart._turns = (x.tolist() for x in np.split(numbers, [machine.geometry.d], axis=1))
    apart.n = numbers.size

    def spread(x: Array) -> Array:
        own = np.append(x[:, : machine.n], np.zeros((len(x), 1)), axis=1)[:, machine.places].reshape(len(x), -1)
        return np.concatenate([own, x[:, machine.n :]], axis=1)

    pulls = spread(a)
    for k, row in enumerate(machine.rows):
        if row.name == joint:
            pulls[:, apart.n + k] = 0.0
    found = apart.residual(t, spread(q), spread(v), pulls, tangents=False)
    return found.force[:, : apart.n].reshape(len(t), count, size)
