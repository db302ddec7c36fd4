"""Equilibrium, also in a frame that turns."""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.machine import Machine
from fenics_mech.solve.newton import newton, predicted
from fenics_mech.solve.sparse import Factors, blocks_of


def equilibrium(
    machine: Machine,
    t: float = 0.0,
    q: Array | None = None,
    *,
    loads: float = 1.0,
    moving: bool = True,
    tolerance: float = 1e-11,
    most: int = 40,
    what: str = "equilibrium",
) -> tuple[Array, Array]:
    """Find coordinates and multipliers without rates and accelerations beside the chart.

    In a chart that turns evenly it is the relative equilibrium; with `moving` off it is the static one at that instant.

    Parameters
    ----------
    machine
        The machine.
    t
        Instant (s).
    q
        Where to begin ``(size,)``; None for the chart.
    loads
        Share of the loads and of gravity; 0 gives the rigid motion.
    moving
        Whether the chart's motion counts.
    tolerance, most
        Of Newton's method.
    what
        What is sought, for the message.

    Returns
    -------
    tuple
        Coordinates ``(size,)``, and accelerations that hold the multipliers ``(size,)``.

    Raises
    ------
    SolverError
        When there is none near by.
    """
    n, size = machine.n, machine.size
    q = np.zeros(size) if q is None else q.copy()
    a, zero, time = np.zeros(size), np.zeros((1, size)), np.array([t])
    blocks, stresses = blocks_of(machine.pattern, 1), None
    is_multiplier = machine.pattern.indices >= n

    def step() -> float:
        nonlocal stresses
        found = machine.residual(time, q[None], zero, a[None], predicted=stresses, loads=loads, moving=moving)
        values = np.where(is_multiplier, found.M[0], found.K[0])
        x = Factors(blocks, values[:, None, None], what).solve(-found.force[0])
        change = np.concatenate([x[:n], np.zeros(size - n)])
        stresses = predicted(machine, found, change[None], zero, x[None])
        q[:] += change
        a[n:] += x[n:]
        return float(np.abs(x[:n]).max(initial=0.0) / max(np.abs(q).max(initial=0.0), 1.0))

    newton(step, tolerance, most, what)
    return q, a
