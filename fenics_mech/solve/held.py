"""What rows hold in a motion that is known: their multipliers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, solved
from fenics_mech.machine import Evaluation, Machine


@dataclass(frozen=True)
class Held:
    """What rows exert in a motion.

    Parameters
    ----------
    machine
        The machine.
    multipliers
        ``(instants, rows)``.
    gradients
        Derivatives of the rows by the coordinates ``(instants, coordinates, rows)``.
    """

    machine: Machine
    multipliers: Array
    gradients: Array

    @property
    def accelerations(self) -> Array:
        """Accelerations beside the motion, which are 0, and the multipliers behind them ``(instants, size)``."""
        none = np.zeros((len(self.multipliers), self.machine.n))
        return np.concatenate([none, self.multipliers], axis=1)

    def on_pose(self, pose: int, rows: Sequence[int]) -> Array:
        """Give force, and moment about its place, of some rows on a pose ``(instants, d + turns)`` (N, N m).

        Parameters
        ----------
        pose
            A pose of which nothing rests.
        rows
            Numbers of the rows.
        """
        on = self.gradients[:, self.machine.places[pose]][:, :, rows]
        return -np.asarray((on @ self.multipliers[:, rows, None])[..., 0])


def held(machine: Machine, t: Array, *, angles: Sequence[Array] | None = None, moving: bool = True) -> Held:
    """Give the multipliers that balance all forces in the motion of the chart.

    Parameters
    ----------
    machine
        A machine whose rows hold all coordinates and are as many; no link of it bends.
    t
        Instants ``(instants,)`` (s).
    angles
        Angles near those of every term, as the residual takes them; None where the terms know.
    moving
        Whether the chart moves; else only its places count.

    Raises
    ------
    ValueError
        When rows and coordinates are not as many.
    """
    return _balanced(machine, t, angles, moving)[0]


def freed(machine: Machine, t: Array, rows: Sequence[int], *, angles: Sequence[Array] | None = None) -> Array:
    """Give how much faster the values of some rows change than in the motion of the chart, where these rows are free.

    They need no force then: with ways W in which the coordinates go with the values of the rows, and their multipliers
    L in the chart's motion, W^T M W a = L.

    Parameters
    ----------
    machine, t, angles
        As of `held`.
    rows
        Numbers of the rows.

    Returns
    -------
    numpy.ndarray
        Accelerations a ``(instants, rows)``.

    Raises
    ------
    numpy.linalg.LinAlgError
        When nothing has mass that goes with the rows.
    """
    by_rows, found = _balanced(machine, t, angles, True)
    n, pattern = machine.n, machine.pattern
    row, column = np.repeat(np.arange(pattern.size), np.diff(pattern.indptr)), pattern.indices
    of = (row < n) & (column < n)
    mass = np.zeros((len(t), n, n))
    mass[:, row[of], column[of]] = found.M[:, of]
    unit = np.broadcast_to(np.eye(n)[:, list(rows)], (len(t), n, len(rows)))
    ways = np.linalg.solve(np.swapaxes(by_rows.gradients, 1, 2), unit)
    return solved(np.swapaxes(ways, 1, 2) @ mass @ ways, by_rows.multipliers[:, list(rows)])


def _balanced(machine: Machine, t: Array, angles: Sequence[Array] | None, moving: bool) -> tuple[Held, Evaluation]:
    n, pattern, still = machine.n, machine.pattern, np.zeros((len(t), machine.size))
    if machine.size != 2 * n:
        raise ValueError(f"{machine.size - n} rows do not hold {n} coordinates")
    found = machine.residual(t, still, still, still, angles=angles, moving=moving)
    row, column = np.repeat(np.arange(pattern.size), np.diff(pattern.indptr)), pattern.indices
    on = (row < n) & (column >= n)
    gradients = np.zeros((len(t), n, n))
    gradients[:, row[on], column[on] - n] = found.M[:, on]
    return Held(machine, solved(gradients, -found.force[:, :n]), gradients), found
