"""Resonances that steps hide, as they change a vibration by themselves more than its damping does.

In a step of length h a vibration becomes ``R(i omega h)`` times as large instead of ``exp(i omega h)``: weaker
(dissipation) and late or early (dispersion). Source: Hairer and Wanner, Solving Ordinary Differential Equations II,
section IV.3. Where that outweighs the damping, neither a better method nor the mesh's error, which is found with the
same steps, tells how large the vibration may be; its load and its damping do.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fenics_mech.mechanism.equation import Equation
from fenics_mech.modes import Modes
from fenics_mech.response.feedback import LEAST_LOSS
from fenics_mech.response.periodic import superposed
from fenics_mech.response.tableau import Tableau

Array = NDArray[np.float64]
NEAR = 0.2  # of a natural frequency, up to which the mesh may put it beside a harmonic
STEPS, BETTER = 3.0, 0.3  # times the damping ratio: change by the steps, and by better ones, from which they hide it
UNDAMPED = 1e-6  # loss factor, below which `LEAST_LOSS` is taken


def hidden_resonances(
    equation: Equation, modes: Modes, tableaus: tuple[Tableau, Tableau], step: float, rate: float
) -> tuple[Array, Array]:
    """Give the largest vibration that the steps may hide, as q and q', ``(angles, coordinates)`` each.

    It is that of the modes which a harmonic of their load may meet: its static answer over the loss factor, and over
    the share by which the frequency varies over the cycle.

    Parameters
    ----------
    equation
        The equation at the starts of the sub-intervals.
    modes
        Modes there.
    tableaus
        The steps' collocation points, and those that tell their error.
    step
        Duration of the longest step (s).
    rate
        Circular frequency of the cycle (rad/s).
    """
    matrices, omega, count = equation.linear, modes.omega, len(modes.theta)
    harmonics = rate * np.arange(count // 2 + 1)
    least, mean, most = omega.min(axis=0), omega.mean(axis=0), omega.max(axis=0)
    work = np.einsum("kmi,kij,kmj->km", modes.shapes, matrices.damping, modes.shapes)
    loss = (work / omega).mean(axis=0)
    width = np.where(loss > UNDAMPED, loss, LEAST_LOSS) + (most - least) / mean
    near = (harmonics[:, None] > (1 - NEAR) * least) & (harmonics[:, None] < (1 + NEAR) * most)
    by_steps, by_better = (tableau.change(harmonics * step)[:, None] for tableau in tableaus)
    hidden = near & ((by_steps > STEPS * width / 2) | (by_better > BETTER * width / 2))
    load = np.einsum("kmi,ki->km", modes.shapes, matrices.load)
    resonant = -1j * np.where(hidden, np.fft.rfft(load, axis=0), 0.0) / (mean**2 * width)
    y, y_rate = (np.fft.irfft(part, count, axis=0) for part in (resonant, 1j * harmonics[:, None] * resonant))
    return superposed(modes, y), superposed(modes, y_rate)
