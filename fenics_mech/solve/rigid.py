"""The rigid motion: the equilibrium without loads and inertia at each position."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError
from fenics_mech.geometry import Fourier, Given
from fenics_mech.machine import Machine
from fenics_mech.solve.statics import equilibria, equilibrium

FEWEST, MOST = 64, 1024  # positions
FOUND = 1e-12  # Newton's change of coordinates (m, rad), where a position is found
LEFT_OUT = 1e-11  # of the machine's extent, that harmonics of the highest quarter may have: rounding is 1e-12


def rigid_cycle(machine: Machine, period: float, positions: int | None = None) -> Fourier:
    """Give the periodic motion of the machine whose members do not bend, as a chart.

    Parameters
    ----------
    machine
        The machine, in its drawn position.
    period
        s.
    positions
        Even positions; harmonics up to half of them are kept. None for as many as there are harmonics.

    Raises
    ------
    SolverError
        When the machine cannot be assembled at a position, which is named, or does not come back after the period.
    """
    if positions is None:
        chart = rigid_cycle(machine, period, FEWEST)
        while not enough(chart, machine, 0):
            chart = _doubled(machine, chart)
        return chart
    places, rotations = [], []
    machine.chart = None
    for k in range(positions + 1):
        t = period * k / positions
        what = f"rigid position at {360 * k / positions:.4g} degrees"
        q, a = equilibrium(machine, t, loads=0.0, moving=False, tolerance=FOUND, most=20, what=what)
        _refuse_gaps(machine, a, 360 * k / positions)
        machine.rebase(q, 0 * q, 0 * q)
        now = machine.known.at(np.array([t]))
        places.append(now.r[0])
        rotations.append(now.R[0])
    machine.chart = None
    off = max(np.abs(places[-1] - places[0]).max() / machine.extent, np.abs(rotations[-1] - rotations[0]).max())
    if off > CLOSED:
        raise SolverError(f"after {period:.6g} s the machine is not where it began: its drives have another period")
    return Fourier(machine.geometry, period, np.array(places[:-1]), np.array(rotations[:-1]))


def _doubled(machine: Machine, chart: Fourier) -> Fourier:
    """Give a rigid motion at twice as many positions: those between are near to its Fourier series."""
    count = len(chart.r)
    r, R = np.repeat(chart.r, 2, axis=0), np.repeat(chart.R, 2, axis=0)
    r[1::2], R[1::2] = _beside(machine, chart, chart.period / count * (np.arange(count) + 0.5))
    return Fourier(machine.geometry, chart.period, r, R)


def _beside(machine: Machine, chart: Fourier, t: Array) -> tuple[Array, Array]:
    """Give rigid places and rotations at some instants (s), near to a motion."""
    drawn = chart.at(t)  # between its positions, its rotations are not quite orthogonal: the nearest that are
    left, _, right = np.linalg.svd(drawn.R)
    machine.chart = Given(t, replace(drawn, R=left @ right))
    zero = np.zeros((len(t), machine.size))
    q, a = equilibria(machine, t, zero, loads=0.0, moving=False, tolerance=FOUND, most=20, what="rigid positions")
    for at, held in zip(t, a):
        _refuse_gaps(machine, held, 360 * at / chart.period)
    found = machine.moved(t, q, zero, zero, moving=False)
    machine.chart = None
    return found.r, found.R


def enough(chart: Fourier, machine: Machine, least: int) -> bool:
    """Say whether a rigid motion has enough positions, or as many as are taken at most."""
    size = np.abs(np.fft.rfft(chart.r, axis=0)) / len(chart.r)
    highest = size[-len(size) // 4 :].max()  # of any place (m), in the highest quarter of those that are kept
    return len(chart.r) >= least and (len(chart.r) >= MOST or bool(highest <= LEFT_OUT * machine.extent))


CLOSED = (
    1e-6  # of the machine's extent: rounding of positions is 1e-12, and slack of joints moves without loads by none
)


def _refuse_gaps(machine: Machine, a: Array, degrees: float) -> None:
    """Raise where rows with slack are not met: links that do not bend do not reach each other."""
    gaps = np.array([row.slack for row in machine.rows]) * a[machine.n : machine.n + len(machine.rows)]
    if len(gaps) and np.abs(gaps).max() > CLOSED * machine.extent:
        name = machine.rows[int(np.argmax(np.abs(gaps)))].name
        raise SolverError(
            f"rigid position at {degrees:.4g} degrees: joint {name!r} has a gap of {np.abs(gaps).max():.2g} m. "
            "Joints or drives contradict each other, or a length is wrong"
        )
