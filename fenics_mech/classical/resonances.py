"""Vibrations that a mesh may miss, as it has frequencies wrong, and those of modes that are left out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.accuracy.frequency_errors import FREQUENCY, highest_felt
from fenics_mech.accuracy.missed_resonances import RESONANCES, Resonances, width_of
from fenics_mech.beams.element_dofs import in_member_axes
from fenics_mech.classical.mechanism import Mechanism
from fenics_mech.classical.modes import Modes, slowest
from fenics_mech.classical.response import SubIntervals, ratios_of


@dataclass(frozen=True)
class Vibration:
    """Modal coordinates of a vibration, ``(positions, modes)``; none where all are 0."""

    modes: Modes
    y: Array

    def any(self) -> bool:
        """Say whether there is one."""
        return bool(self.y.any())


def missed_vibrations(by: SubIntervals) -> tuple[Vibration, Vibration]:
    """Give the largest vibrations that the mesh may miss: of the modes kept, and of those left out.

    Parameters
    ----------
    by
        Sub-intervals of a cycle.
    """
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
    found = Resonances(modes, rate, by.load, losses, frequency_error(mechanism, modes))  # type: ignore[arg-type]
    left_out = np.arange(modes.omega.shape[1]) >= kept
    unseen = (found.by_mesh | (found.met & found.shifted)) & left_out
    return tuple(  # type: ignore[return-value]
        Vibration(modes, found.vibration(missed)[0] if missed.any() else np.zeros_like(modes.omega))
        for missed in (found.by_mesh & ~left_out, unseen)
    )


def slower_than(mechanism: Mechanism, omega: float) -> int:
    """Count the modes that are slower somewhere than an angular frequency (rad/s), by Sylvester's law of inertia."""
    pivots = (mechanism.stiffness + mechanism.mass * -float(omega**2)).factors.pivots
    return int((pivots < 0).sum(axis=1).max())


def frequency_error(mechanism: Mechanism, modes: Modes) -> Array:
    """Give the share by which elements have natural frequencies wrong, ``(modes,)``, to `FREQUENCY.largest_known`.

    In bending that is ``omega^2 rho A h^4 / (1440 EI)``, along the axis ``omega^2 rho A h^2 / (24 EA)``, weighted with
    the elements' kinetic energy.

    Source: Belytschko and Mullen, On dispersive properties of finite element solutions (1978).
    """
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
