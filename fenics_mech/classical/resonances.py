"""Vibrations that a mesh may miss, as it has frequencies wrong, and those of modes that are left out."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index
from fenics_mech.beams.element_dofs import in_member_axes
from fenics_mech.classical.mechanism import Mechanism
from fenics_mech.classical.modes import Modes, slowest
from fenics_mech.classical.response import SubIntervals, ratios_of
from fenics_mech.estimate.frequencies import FREQUENCY, highest_felt

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class ResonanceLimits:
    """When a harmonic of a load counts as one that may meet a mode."""

    near: float = 0.02  # of a natural frequency, up to which a harmonic beside it is on it
    mesh_safety: float = 2.0  # on the error of a frequency by the mesh: with one element it is 1.6
    finer: float = 0.3  # times the damping ratio: change by more accurate steps or a mesh that conceals a resonance
    coarse: float = 0.05  # of a natural frequency by the mesh, from which its first order says too little
    felt: float = 1e-3  # of the largest static answer, as a root of energy, that a vibration is to count
    farthest: float = 1.25  # times its frequency, up to which the mesh may put a mode that a harmonic meets
    undamped: float = 1e-6  # loss factor, below which `least_loss` is taken
    least_loss: float = 1e-3  # loss factor that is taken where there is less
    even: float = 1e-6  # difference of steps of a phase, relative to them, that counts as none
    looked_at: int = 360  # positions of the cycle, for the harmonic with the largest vibration
    at_a_time: int = 4_000_000  # numbers: positions times harmonics


RESONANCES = ResonanceLimits()


@dataclass(frozen=True)
class Resonances:
    """Modes and the harmonics of their loads that may meet them."""

    modes: Modes  # elastic modes at equal steps of time
    rate: float  # circular frequency of the cycle (rad/s)
    load: Array  # load on the coordinates, (angles, coordinates): where modes cross, modal loads may have corners
    loss: Array  # loss factors, twice the damping ratios, (modes,)
    off: Array  # by which share about the mesh has the natural frequencies wrong, (modes,); see `frequency_error`

    @cached_property
    def harmonics(self) -> Array:
        """Circular frequencies of the harmonics that the angles show (rad/s)."""
        return self.rate * np.arange(len(self.load) // 2 + 1, dtype=float)

    @cached_property
    def width(self) -> Array:
        """Relative width of the modes' resonances: their loss factors, ``(modes,)``."""
        return np.array([width_of(loss) for loss in self.loss])

    @cached_property
    def met(self) -> Mask:
        """Which harmonics a mode of the linkage may meet by its mean frequency, ``(harmonics, modes)``."""
        # Between modes that a mesh is too coarse for, and beyond the last of them, the linkage has others.
        omega, beside = self.modes.omega.mean(axis=0), RESONANCES.near + RESONANCES.mesh_safety * self.off
        least, most = (1 - beside) * omega, (1 + beside) * omega
        most = np.where(self.off > RESONANCES.coarse, np.maximum(most, np.append(least[1:], np.inf)), most)
        return (self.harmonics[:, None] > least) & (self.harmonics[:, None] < most)

    @property
    def shifted(self) -> Mask:
        """Which modes the mesh shifts by a share of their width, or more, ``(modes,)``."""
        return self.off > RESONANCES.finer * self.width / 2

    @property
    def by_mesh(self) -> Mask:
        """Those that the mesh may miss."""
        return self.met & (self.off > RESONANCES.coarse)

    def vibration(self, missed: Mask) -> tuple[Array, Array]:
        """Give modal coordinates and their rates, ``(angles, modes)`` each, of the largest missed vibration."""
        # missed (harmonics, modes)
        # It is the static answer to the load over the width of the resonance, of the harmonic with the largest one.
        # Where a frequency varies slowly, harmonics are those over the phase of the mode's own vibration (WKB).
        modes, count = self.modes, len(self.load)
        y, y_rate = np.zeros((2, *modes.omega.shape))
        for m in np.flatnonzero(missed.any(axis=0)):
            pace = modes.omega[:, m] / modes.omega[:, m].mean()
            numbers, phase = np.flatnonzero(missed[:, m]), 2 * np.pi / count * np.cumsum(pace)
            loads = self._harmonics_of_load(phase, numbers)
            worst = int(np.abs(modes.shapes[:: max(1, count // RESONANCES.looked_at), m] @ loads).max(axis=0).argmax())
            found = -1j * (modes.shapes[:, m] @ loads[:, worst]) * np.exp(1j * numbers[worst] * phase)
            found /= modes.omega[:, m].mean() ** 2 * self.width[m]
            y[:, m], y_rate[:, m] = found.real, (1j * numbers[worst] * found).real * self.rate * pace
        return y, y_rate

    def _harmonics_of_load(self, phase: Array, numbers: Index) -> NDArray[np.complex128]:
        """Give harmonics of the load over a phase that grows by a turn in the cycle, ``(coordinates, numbers)``."""
        count = len(phase)
        if np.ptp(np.diff(phase, prepend=0.0)) < RESONANCES.even / count:
            return (np.fft.rfft(self.load, axis=0)[numbers] * np.exp(-1j * numbers * phase[0])[:, None]).T * (2 / count)
        parts = np.array_split(numbers, -(-count * len(numbers) // RESONANCES.at_a_time))
        turns = (np.exp(-1j * phase[:, None] * part) for part in parts)
        found = np.concatenate([self.load.T @ turn for turn in turns], axis=1, dtype=np.complex128)
        return found * (2 / count)


def width_of(loss: float) -> float:
    """Give the relative width of the resonance of a mode with a loss factor."""
    return loss if loss > RESONANCES.undamped else RESONANCES.least_loss


@dataclass(frozen=True)
class Vibration:
    """Modal coordinates of a vibration, ``(positions, modes)``; none where all are 0."""

    modes: Modes
    y: Array

    def any(self) -> bool:
        """Say whether there is one."""
        return bool(self.y.any())


def missed_vibrations(by: SubIntervals) -> tuple[Vibration, Vibration]:
    """Give the largest vibrations that the mesh may miss: of the modes kept, and of those left out."""
    scene, kept, mechanism = by.scene, by.modes.omega.shape[1], by.mechanism
    rate, modes, size = 2 * np.pi / scene.period, by.modes, len(by.mechanism.P.kept)
    static = mechanism.stiffness.solve(by.load)
    whole = float(np.sqrt(np.abs(np.einsum("ki,ki->k", by.load, static)).max()))
    width = width_of(2 * float(by.zeta.min()))
    fastest = RESONANCES.farthest * rate * highest_felt(by.load, static, width, RESONANCES.felt * whole)
    if kept < size and modes.omega.min(axis=0).max() < fastest:
        wanted = min(slower_than(mechanism, fastest) + 1, size)
        modes = slowest(mechanism, wanted, scene.petsc) if wanted > kept else modes
    losses = 2 * ratios_of(scene, modes.omega).mean(axis=0)
    found = Resonances(modes, rate, by.load, losses, frequency_error(mechanism, modes))
    left_out = np.arange(modes.omega.shape[1]) >= kept
    unseen = (found.by_mesh | (found.met & found.shifted)) & left_out
    return tuple(  # type: ignore[return-value]
        Vibration(modes, found.vibration(missed)[0] if missed.any() else np.zeros_like(modes.omega))
        for missed in (found.by_mesh & ~left_out, unseen)
    )


def slower_than(mechanism: Mechanism, omega: float) -> int:
    """Count the modes that are slower somewhere than an angular frequency (rad/s), by Sylvester's law of inertia."""
    return max(mechanism.slower(k, omega) for k in range(len(mechanism.P.t)))


def frequency_error(mechanism: Mechanism, modes: Modes) -> Array:
    """Give the share by which elements have natural frequencies wrong, ``(modes,)``, to `FREQUENCY.largest_known`."""
    # In bending that is omega^2 rho A h^4 / (1440 EI), along the axis omega^2 rho A h^2 / (24 EA), weighted with the
    # elements' kinetic energy.
    # Source: Belytschko and Mullen, On dispersive properties of finite element solutions (1978).
    P, links = mechanism.P, mechanism.P.made.links
    assert links is not None
    h, stiff = links.mesh.cell_length, links.rigidity
    per_square = links.inertia.density.mean * (h**4 / (1440 * stiff.bending.mean) + h**2 / (24 * stiff.axial.mean))
    at = np.unique(np.linspace(0, len(P.t), FREQUENCY.positions, endpoint=False).astype(int))
    share = np.zeros(modes.omega.shape[1])
    for k in at:
        v = in_member_axes(links.mesh, P.part(slice(k, k + 1)).to_nodes(modes.shapes[k : k + 1])[0])
        energy = np.einsum("mei,eij,mej->me", v, links.element_mass, v, optimize=True)
        share += modes.omega[k] ** 2 * (energy @ per_square) / len(at)
    return np.minimum(share, FREQUENCY.largest_known)
