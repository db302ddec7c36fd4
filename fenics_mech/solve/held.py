"""What rows hold in a motion that is known: their multipliers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, solved
from fenics_mech.machine import Machine


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
    n, pattern, still = machine.n, machine.pattern, np.zeros((len(t), machine.size))
    if machine.size != 2 * n:
        raise ValueError(f"{machine.size - n} rows do not hold {n} coordinates")
    found = machine.residual(t, still, still, still, angles=angles, moving=moving)
    row, column = np.repeat(np.arange(pattern.size), np.diff(pattern.indptr)), pattern.indices
    on = (row < n) & (column >= n)
    gradients = np.zeros((len(t), n, n))
    gradients[:, row[on], column[on] - n] = found.M[:, on]
    return Held(machine, solved(gradients, -found.force[:, :n]), gradients)
