"""The rigid motion: the equilibrium without loads and inertia at each position."""

from __future__ import annotations

import numpy as np

from fenics_mech.geometry import Fourier
from fenics_mech.machine import Machine
from fenics_mech.solve.statics import equilibrium


def rigid_cycle(machine: Machine, period: float, positions: int = 64) -> Fourier:
    """Give the periodic motion of the machine whose members do not bend, as a chart.

    Parameters
    ----------
    machine
        The machine, in its drawn position.
    period
        s.
    positions
        Even positions; harmonics up to half of them are kept.

    Raises
    ------
    SolverError
        When the machine cannot be assembled at a position, which is named.
    """
    places, rotations = [], []
    machine.chart = None
    for k in range(positions):
        t = period * k / positions
        q, _ = equilibrium(
            machine,
            t,
            loads=0.0,
            moving=False,
            tolerance=1e-12,
            most=20,
            what=f"rigid position at {360 * k / positions:.4g} degrees",
        )
        machine.rebase(q, 0 * q, 0 * q)
        now = machine.known.at(np.array([t]))
        places.append(now.r[0])
        rotations.append(now.R[0])
    machine.chart = None
    return Fourier(machine.geometry, period, np.array(places), np.array(rotations))
