"""Equilibrium, also in a frame that turns."""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.machine import Evaluation, Machine
from fenics_mech.solve.newton import newton
from fenics_mech.solve.sparse import blocks_of, solutions


def stiffness(machine: Machine, found: Evaluation) -> Array:
    """Give the stiffness with the rows, by the tangents of a residual ``(instants, entries)``."""
    return np.where(machine.pattern.indices >= machine.n, found.M, found.K)


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
    start = np.zeros((1, machine.size)) if q is None else q[None]
    states = equilibria(
        machine, np.array([t]), start, loads=loads, moving=moving, tolerance=tolerance, most=most, what=what
    )
    return states[0][0], states[1][0]


def equilibria(
    machine: Machine,
    t: Array,
    q: Array,
    *,
    loads: float = 1.0,
    moving: bool = True,
    tolerance: float = 1e-11,
    most: int = 40,
    what: str = "equilibrium",
) -> tuple[Array, Array]:
    """Find what `equilibrium` finds at many instants together.

    Parameters
    ----------
    machine
        The machine.
    t
        Instants ``(instants,)`` (s).
    q
        Where to begin ``(instants, size)``.
    loads, moving, tolerance, most, what
        As of `equilibrium`.

    Raises
    ------
    SolverError
        When there is none near by at one of them.
    """
    n, q, a, zero = machine.n, q.copy(), np.zeros_like(q), np.zeros_like(q)
    blocks, stresses = blocks_of(machine.pattern, 1), None
    unit = machine.units  # rounding of places goes with the extent

    def step() -> float:
        nonlocal stresses
        found = machine.residual(t, q, zero, a, predicted=stresses, loads=loads, moving=moving)
        x = solutions(blocks, stiffness(machine, found)[..., None, None], -found.force, what)
        change = np.where(np.arange(machine.size) < n, x, 0.0)
        stresses = machine.predicted(found, change, zero, x)
        q[:] += change
        a[:, n:] += x[:, n:]
        most = np.abs(q / unit).max(initial=0.0)
        return float(np.abs(change / unit).max(initial=0.0) / max(most, 1.0))

    newton(step, tolerance, most, what)
    return q, a
