"""A quick look at a mechanism before the run: the numbers by which effects say how large they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.beams.element_dofs import in_member_axes
from fenics_mech.effects import AxialStiffness, Entries, Terms
from fenics_mech.effects.effect import Survey
from fenics_mech.eigenmodes import Modes
from fenics_mech.mechanism import System
from fenics_mech.response.modal_damping import damping_ratios
from fenics_mech.response.static.quasi_static import solve_static
from fenics_mech.scene import Scene

LEAST_DAMPING = 0.005  # ratio that a real machine has at least: it bounds the estimates at a resonance


def survey(scene: Scene, system: System, modes: Modes, still: Array, tension: Array, bow: Array) -> Survey:
    """Measure a mechanism.

    Parameters
    ----------
    scene, system
        The scene, and its mechanism without any effect but loads, at a few equal steps of the cycle.
    modes
        Its lowest modes there.
    still
        The quasi-static response, ``(angles, coordinates)``.
    tension
        Axial force of each element from loads and rigid motion (N), ``(angles, elements)``.
    bow
        Bow of each member over its length in the quasi-static response, ``(members,)``.
    """
    moving, vibration, sensitivity = _vibration(scene, system, modes, still)
    return Survey(
        needs_vibration=_needs_vibration(scene),
        vibration=vibration,
        sensitivity=sensitivity,
        turning=float(np.abs(system.motion.omega).max() / modes.omega.min()),
        tension=_stiffening(system, modes, tension),
        bow=float(bow.max()),
        slenderness=_slenderness(scene, system, moving),
        gravity=_gravity(scene, system, still),
    )


def _needs_vibration(scene: Scene) -> bool:
    """Whether something acts that is nothing without vibration: impulses, a motor, a motion in time."""
    motor = any(drive.motor for drive in scene.drives)
    return bool(scene.impulses) or scene.analysis.method == "transient" or motor


def _gravity(scene: Scene, system: System, still: Array) -> float:
    """Largest share of gravity in a member's quasi-static response, by the root of the strain energy."""
    if not any(scene.gravity):
        return 0.0
    weight = replace(system, motion=system.motion.held(), terms=Terms(acceleration=system.terms.acceleration))
    alone = solve_static(weight).displacement
    return float(np.sqrt((_member_energy(system, alone) / _member_energy(system, still)).max()))


def _stiffening(system: System, modes: Modes, tension: Array) -> float:
    """Largest share by which axial forces change the stiffness of a mode: Rayleigh's quotient."""
    blocks = Entries.of_elements(system.beams.mesh, AxialStiffness.even(system.beams, tension).blocks)
    shares = []
    for mode in range(modes.omega.shape[1]):
        v = system.to_links(modes.shapes[:, mode])
        shares.append(np.abs(np.sum(v * blocks.times(v), axis=1)) / modes.omega[:, mode] ** 2)
    return float(np.max(shares))


def _vibration(scene: Scene, system: System, modes: Modes, still: Array) -> tuple[Array, float, float]:
    """Estimate how far the response is from the quasi-static one, and how it changes with the stiffness.

    Every mode is an oscillator with its mean frequency under the harmonics of its load. Harmonic n is answered
    ``H = 1/(1 - r^2 + 2 i zeta r)`` times, r being n times the drive's rate over the mode's frequency. Given are

    - the vibration on top of the quasi-static response, ``(angles, coordinates)``,
    - twice its largest ratio to that response of the same member, by the root of the energy, for curves at their peaks,
    - the relative change of the response over a relative change of stiffness.
    """
    if not scene.drives:
        return np.zeros_like(still), 0.0, 1.0
    harmonics = np.fft.rfft(np.einsum("kmi,ki->km", modes.shapes, system.load), axis=0)
    omega = modes.omega.mean(axis=0)
    ratio = (
        np.maximum(damping_ratios(scene.damping.ratio, modes.omega)[0], LEAST_DAMPING)
        + scene.damping.material * omega / 2
    )
    r = np.arange(len(harmonics))[:, None] * abs(scene.cycle_rate) / omega
    answer = 1 / (1 - r**2 + 2j * ratio * r)

    def displacement(factor: Array) -> Array:
        return np.einsum("kmi,km->ki", modes.shapes, np.fft.irfft(harmonics / omega**2 * factor, n=len(still), axis=0))

    moving = displacement(answer - 1)
    ratios = _member_energy(system, moving) / _member_energy(system, still)
    change, whole = displacement(answer**2), displacement(answer)
    changed = _member_energy(system, change) / np.maximum(_member_energy(system, whole), 1e-300)
    return moving, 2 * float(np.sqrt(ratios.max())), float(max(1.0, np.sqrt(changed.max())))


def _slenderness(scene: Scene, system: System, moving: Array) -> float:
    """Root of the mean square of radius of gyration over length, weighted by the members' energy as they vibrate."""
    ratios = []
    for label, length in zip(scene.members(), system.beams.mesh.member_length):
        rigidity = scene.rigidity(label, np.linspace(0, 1, 21))
        ratios.append(float((rigidity.bending / rigidity.axial).max()) / length**2)
    energy = _energies(system, moving).sum(axis=0)
    return float(np.sqrt(energy @ ratios / max(energy.sum(), 1e-300)))


def _member_energy(system: System, q: Array) -> Array:
    """Largest strain energy of each member over the angles, at least a millionth of that of all, ``(members,)``."""
    largest = _energies(system, q).max(axis=0)
    return np.maximum(largest, max(1e-6 * largest.max(), 1e-300))


def _energies(system: System, q: Array) -> Array:
    """Strain energy of each member, ``(angles, members)``."""
    mesh = system.beams.mesh
    v = in_member_axes(mesh, system.to_links(q))
    by_element = np.einsum("tei,eij,tej->te", v, system.beams.element_stiffness, v)
    return np.stack([by_element[:, mesh.cell_member == i].sum(axis=1) for i in range(len(mesh.members))], axis=1)
