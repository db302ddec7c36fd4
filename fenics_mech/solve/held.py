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


def freed(machine: Machine, t: Array, rows: Sequence[int], *, angles: Sequence[Array] | None = None) -> Array:
    """Give how much faster the values of some rows change than in the motion of the chart, where these rows are free.

    Parameters
    ----------
    machine, t, rows, angles
        As of `led_by`.

    Returns
    -------
    numpy.ndarray
        Accelerations a, with the mass m of the rows' values m a + f = 0 ``(instants, rows)``.

    Raises
    ------
    numpy.linalg.LinAlgError
        When nothing has mass that goes with the rows.
    """
    force, (mass, _, _) = led_by(machine, t, rows, angles=angles)
    return -solved(mass, force)


def led_by(
    machine: Machine, t: Array, rows: Sequence[int], *, angles: Sequence[Array] | None = None, moving: bool = True
) -> tuple[Array, tuple[Array, Array, Array]]:
    """Give the equation of motion in the values of some rows, which lead all of the machine with the others.

    The coordinates go with the values in ways W, at which the other rows stay. Then forces and tangents of the values
    are W^T F and W^T M W, and so on: their stiffness is that of the machine with the multipliers of all rows in it.

    Parameters
    ----------
    machine, t, angles, moving
        As of `held`.
    rows
        Numbers of the rows.

    Returns
    -------
    tuple
        What is left in the chart's motion, where no force acts in these rows ``(instants, rows)``, and its derivatives
        by second rates, rates and values ``(instants, rows, rows)`` each.
    """
    n, pattern, own = machine.n, machine.pattern, list(rows)
    by_rows = held(machine, t, angles=angles, moving=moving)
    still, unit = np.zeros((len(t), machine.size)), np.broadcast_to(np.eye(n)[:, own], (len(t), n, len(own)))
    found = machine.residual(t, still, still, by_rows.accelerations, angles=angles, moving=moving)
    row, column = np.repeat(np.arange(pattern.size), np.diff(pattern.indptr)), pattern.indices
    of = (row < n) & (column < n)
    ways = np.linalg.solve(np.swapaxes(by_rows.gradients, 1, 2), unit)

    def reduced(values: Array) -> Array:
        whole = np.zeros((len(t), n, n))
        whole[:, row[of], column[of]] = values[:, of]
        return np.asarray(np.swapaxes(ways, 1, 2) @ whole @ ways)

    return -by_rows.multipliers[:, own], (reduced(found.M), reduced(found.C), reduced(found.K))
