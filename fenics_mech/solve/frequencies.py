"""Frequencies about an equilibrium: held in a position, or in a frame that turns."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from fenics_mech._arrays import Array
from fenics_mech.machine import Machine


def tangents_at(
    machine: Machine, q: Array, a: Array, t: float = 0.0, *, moving: bool = True
) -> tuple[Array, Array, Array]:
    """Give M, C and K of the free coordinates about an equilibrium, rows of joints and modes of stress eliminated.

    Parameters
    ----------
    machine
        The machine.
    q, a
        Coordinates, and accelerations with the multipliers ``(size,)``.
    t
        Instant (s).
    moving
        Whether the chart's motion counts; in a chart that turns evenly these are the tangents in the turning frame.
    """
    n = machine.n
    zero = np.zeros((1, machine.size))
    found = machine.residual(np.array([t]), q[None], zero, a[None], moving=moving)
    M, C, K = (machine.pattern.matrix(x[0]).toarray() for x in (found.M, found.C, found.K))
    rows, modes = slice(n, n + len(machine.rows)), slice(n + len(machine.rows), None)
    free = scipy.linalg.null_space(K[rows, :n], rcond=1e-10) if machine.rows else np.eye(n)
    C, K = (X[:n, :n] + M[:n, modes] @ X[modes, :n] for X in (C, K))
    return tuple(free.T @ X @ free for X in (M[:n, :n], C, K))  # type: ignore[return-value]


def frequencies(M: Array, C: Array, K: Array, count: int) -> Array:
    """Give eigenvalues of M x'' + C x' + K x = 0 with positive imaginary part, the slowest first (1/s).

    Parameters
    ----------
    M, C, K
        Dense matrices.
    count
        How many.
    """
    n = len(M)
    first = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, np.hstack([K, C]))]])
    values = np.linalg.eigvals(first)
    values = values[values.imag > 1e-9 * np.abs(values).max()]
    return values[np.argsort(values.imag)][:count]
