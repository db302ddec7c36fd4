"""Resonances that the steps or the mesh hide, as they shift or weaken a vibration more than its damping does.

In a step of length h a vibration becomes ``R(i omega h)`` times as large instead of ``exp(i omega h)``: weaker
(dissipation) and late or early (dispersion); elements put its frequency too high, and lumped mass too low. Where that
outweighs the damping, an estimate that starts from the motion found does not tell how large the vibration may be: its
load and its damping do.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_mech.accuracy.feedback import LEAST_LOSS
from fenics_mech.beams.layout import in_member_axes
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.modes import Modes, solve_modes
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.static.quasi_static import displacement_under

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
NEAR = 0.02  # of a natural frequency, up to which a harmonic beside it is on it
MOST_OFF, TWICE = 0.2, 2  # of a natural frequency by the mesh, and by which that is raised: with one element it is 1.6
STEPS, BETTER = 1.0, 0.3  # times the damping ratio: change by steps, and by better ones or a mesh, that hides it
COARSE = 0.05  # of a natural frequency by the mesh, from which its first order tells too little
FELT = 1e-3  # of the largest static answer, as a root of energy, that a vibration is to count
FARTHEST = 1.25  # times its frequency, up to which the mesh may put a mode that a harmonic meets
UNDAMPED = 1e-6  # loss factor, below which `LEAST_LOSS` is taken
LASTS = 4  # logarithm of what a cycle leaves of a vibration, up to which it lasts
POSITIONS = 8  # of the cycle, at which modes are looked at
LOOKED_AT = 360  # the same, for the harmonic with the largest vibration
EVEN = 1e-6  # difference of steps of a phase, relative to them, that counts as none
AT_A_TIME = 4_000_000  # numbers: positions times harmonics


@dataclass(frozen=True)
class Resonances:
    """Modes and the harmonics of their loads that may meet them.

    Parameters
    ----------
    modes
        Elastic modes at equal steps of time.
    rate
        Circular frequency of the cycle (rad/s).
    load
        Load on the coordinates, ``(angles, coordinates)``: where modes cross, modal loads may have corners.
    loss
        Loss factors, twice the damping ratios, ``(modes,)``.
    off
        By which share about the mesh has the natural frequencies wrong, ``(modes,)``; see `frequency_error`.
    """

    modes: Modes
    rate: float
    load: Array
    loss: Array
    off: Array

    @classmethod
    def of(cls, equation: Equation, modes: Modes, rate: float) -> Resonances:
        """Take load and losses from an equation at the modes' angles."""
        shapes, matrices = modes.shapes, equation.linear
        work = np.einsum("kmi,kij,kmj->km", shapes, matrices.damping, shapes, optimize=True)
        loss, off = (work / modes.omega).mean(axis=0), frequency_error(equation.system, modes)
        return cls(modes, rate, matrices.load, loss, off)

    @cached_property
    def harmonics(self) -> Array:
        """Circular frequencies of the harmonics that the angles show (rad/s)."""
        return self.rate * np.arange(len(self.load) // 2 + 1)

    @cached_property
    def least_loss(self) -> Array:
        """Loss factors; of modes that the mesh is too coarse for the least, as they stand for others above them."""
        return np.where(self.off > COARSE, np.minimum.accumulate(self.loss[::-1])[::-1], self.loss)

    @cached_property
    def remember(self) -> Mask:
        """Which modes' vibration lasts much of the cycle, so that it goes by their mean frequency, ``(modes,)``."""
        return np.pi * self.modes.omega.mean(axis=0) / self.rate * self.least_loss < LASTS

    @cached_property
    def width(self) -> Array:
        """Loss factor, and of other modes the share by which the frequency varies over the cycle, ``(modes,)``."""
        omega = self.modes.omega
        varies = np.where(self.remember, 0.0, np.ptp(omega, axis=0) / omega.mean(axis=0))
        return np.where(self.least_loss > UNDAMPED, self.least_loss, LEAST_LOSS) + varies

    @cached_property
    def met(self) -> Mask:
        """Which harmonics a mode of the linkage may meet, ``(harmonics, modes)``.

        Between modes that a mesh is too coarse for, and beyond the last of them, the linkage has others.
        """
        omega, beside = self.modes.omega, NEAR + TWICE * self.off
        lowest, highest = (np.where(self.remember, omega.mean(axis=0), edge) for edge in (omega.min(0), omega.max(0)))
        least, most = (1 - beside) * lowest, (1 + beside) * highest
        most = np.where(self.off > COARSE, np.maximum(most, np.append(least[1:], np.inf)), most)
        return (self.harmonics[:, None] > least) & (self.harmonics[:, None] < most)

    @property
    def shifted(self) -> Mask:
        """Which modes the mesh shifts by a share of their width, or more, ``(modes,)``."""
        return self.off > BETTER * self.width / 2

    @property
    def by_mesh(self) -> Mask:
        """Those that the mesh may hide."""
        return self.met & (self.off > COARSE)

    def by_steps(self, tableau: Tableau, better: Tableau, step: float) -> Mask:
        """Those that steps of such a duration (s) may hide, or better ones that tell their error."""
        change, beside = (points.change(self.harmonics * step)[:, None] for points in (tableau, better))
        return self.met & ((change > STEPS * self.width / 2) | (beside > BETTER * self.width / 2))

    def vibration(self, hidden: Mask) -> tuple[Array, Array]:
        """Give modal coordinates and their rates, ``(angles, modes)`` each, of the largest hidden vibration.

        It is the static answer to the load over the width of the resonance, of the harmonic with the largest one. Where
        a frequency varies slowly, harmonics are those over the phase of the mode's own vibration (WKB).
        """
        modes, count = self.modes, len(self.load)
        y, y_rate = np.zeros((2, *modes.omega.shape))
        for m in np.flatnonzero(hidden.any(axis=0)):
            pace = modes.omega[:, m] / modes.omega[:, m].mean() if self.remember[m] else np.ones(count)
            numbers, phase = np.flatnonzero(hidden[:, m]), 2 * np.pi / count * np.cumsum(pace)
            loads = self._harmonics_of_load(phase, numbers)
            worst = int(np.abs(modes.shapes[:: max(1, count // LOOKED_AT), m] @ loads).max(axis=0).argmax())
            found = -1j * (modes.shapes[:, m] @ loads[:, worst]) * np.exp(1j * numbers[worst] * phase)
            found /= modes.omega[:, m].mean() ** 2 * self.width[m]
            y[:, m], y_rate[:, m] = found.real, (1j * numbers[worst] * found).real * self.rate * pace
        return y, y_rate

    def _harmonics_of_load(self, phase: Array, numbers: NDArray[np.int64]) -> NDArray[np.complex128]:
        """Give harmonics of the load over a phase that grows by a turn in the cycle, ``(coordinates, numbers)``."""
        count = len(phase)
        if np.ptp(np.diff(phase, prepend=0.0)) < EVEN / count:
            return (np.fft.rfft(self.load, axis=0)[numbers] * np.exp(-1j * numbers * phase[0])[:, None]).T * (2 / count)
        parts = np.array_split(numbers, -(-count * len(numbers) // AT_A_TIME))
        turns = (np.exp(-1j * phase[:, None] * part) for part in parts)
        return np.concatenate([self.load.T @ turn for turn in turns], axis=1) * (2 / count)


def hidden_motion(equation: Equation, resonances: Resonances, hidden: Mask) -> tuple[Array, Array]:
    """Give q and q', ``(angles, coordinates)`` each, of the largest hidden vibration.

    The modes are those of the links' mass and stiffness alone. Under all that acts on the equation, what balances their
    inertia has other shares along stiff coordinates.
    """
    modes = resonances.modes
    momenta = equation.system.mass_times(modes.shapes)
    inertia = [np.einsum("kmi,km->ki", momenta, modes.omega**2 * part) for part in resonances.vibration(hidden)]
    q, rate = np.moveaxis(np.linalg.solve(equation.linear.stiffness, np.stack(inertia, axis=-1)), -1, 0)
    return q, rate


def enough_modes(
    system: System, modes: Modes, load: Array, rate: float, loss: float, options: Mapping[str, Any]
) -> Modes:
    """Give the elastic modes, with more where a harmonic of a load would be felt on one that is faster.

    Parameters
    ----------
    system, modes
        The mechanism, and modes of it.
    load
        The load, ``(angles, coordinates)``.
    rate
        Circular frequency of the cycle (rad/s).
    loss
        Least loss factor.
    options
        PETSc options for statics and eigenproblems.
    """
    static = displacement_under(system.slack, load, options)  # rough, and also where it buckles for a moment
    whole = float(np.sqrt(np.abs(np.einsum("ki,ki->k", load, static)).max()))
    fastest = FARTHEST * rate * highest_felt(load, static, loss if loss > UNDAMPED else LEAST_LOSS, FELT * whole)
    modes = modes.elastic
    while modes.omega.shape[1] < system.size and np.max(modes.omega.min(axis=0), initial=0.0) < fastest:
        modes = solve_modes(system, min(2 * modes.omega.shape[1] + 2, system.size), options).elastic
    return modes


def highest_felt(load: Array, static: Array, loss: float, enough: float) -> int:
    """Give the number of the highest harmonic of a load that would be felt on a mode; 0 where none would.

    Parameters
    ----------
    load, static
        The load and its static answer at equal steps of time, ``(angles, coordinates)`` each.
    loss
        Loss factor of the mode.
    enough
        Square root of an elastic energy, twice of it, that is felt.
    """
    spectrum = np.fft.rfft(np.stack([load, static]), axis=1) * (2 / len(load))
    harmonics = np.sqrt(np.abs(np.einsum("hi,hi->h", spectrum[0], spectrum[1].conj())))
    least = loss * enough + np.finfo(float).tiny
    return int(np.flatnonzero(harmonics > least).max(initial=0))


def frequency_error(system: System, modes: Modes) -> Array:
    """Give by which share about elements have natural frequencies wrong, ``(modes,)``, up to `MOST_OFF`.

    In bending that is ``omega^2 rho A h^4 / (1440 EI)``, along the axis ``omega^2 rho A h^2 / (24 EA)`` and in shear
    ``omega^2 rho A h^2 / (24 G A_s)``, weighted with the elements' kinetic energy. What lumps of mass add is told by
    Rayleigh's quotient with the mass along the elements.

    Source: Belytschko and Mullen, On dispersive properties of finite element solutions (1978), for the axis; in bending
    by the same expansion of the cubic element with consistent mass.
    """
    beams, count = system.beams.spread or system.beams, modes.omega.shape[1]
    h = beams.mesh.cell_length
    flexibility = h**4 / (1440 * beams.bending_rigidity) + h**2 / (24 * beams.axial_rigidity)
    if beams.shear_rigidity is not None:
        flexibility += h**2 / (24 * beams.shear_rigidity)
    per_square = beams.line_density * flexibility
    if (reduction := system.beams.reduction) is not None:
        per_square *= reduction.fineness**-4.0
    share = np.zeros(count)
    at = np.unique(np.linspace(0, len(modes.theta), POSITIONS, endpoint=False).astype(int))
    for k in at:
        values = np.repeat(system.values[k : k + 1], count, axis=0)
        v = in_member_axes(beams.mesh, system.on_nodes(system.transformation.forward(values, modes.shapes[k])))
        energy = np.einsum("mei,eij,mej->me", v, beams.element_mass, v, optimize=True)
        share += modes.omega[k] ** 2 * (energy @ per_square) / len(at)
    if system.beams.spread is not None:
        along = replace(system, beams=replace(beams, reduction=reduction))
        of_both = np.einsum("kmi,kmi->km", modes.shapes, along.mass_times(modes.shapes))
        share += np.abs(np.sqrt(of_both) - 1).mean(axis=0)
    return np.minimum(share, MOST_OFF)
