"""A quick look at a mechanism before the run: the numbers by which effects say how large they are."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fenics_mech.effects.effect import Survey
from fenics_mech.mechanism import System
from fenics_mech.modes import Modes
from fenics_mech.response.damping import damping_ratios
from fenics_mech.scene import Scene

Array = NDArray[np.float64]
LEAST_DAMPING = 0.005  # ratio that a real machine has at least: it bounds the estimates at a resonance


def survey(scene: Scene, system: System, modes: Modes, tension: Array, bow: Array) -> Survey:
    """Measure a mechanism.

    Parameters
    ----------
    scene, system
        The scene, and its mechanism without any effect but loads, at a few equal steps of the cycle.
    modes
        Its lowest modes there.
    tension
        Axial force of each element from loads and rigid motion (N), ``(angles, elements)``.
    bow
        Bow of each member over its length in the quasi-static response, ``(members,)``.
    """
    answer, sensitivity = _vibration(scene, system, modes)
    labels, mesh = list(scene.members()), system.beams.mesh
    length = mesh.member_length
    euler, slenderness = np.empty(len(labels)), np.empty(len(labels))
    for i, label in enumerate(labels):
        rigidity = scene.rigidity(label, np.linspace(0, 1, 21))
        euler[i] = math.pi**2 * rigidity.bending.min() / length[i] ** 2
        slenderness[i] = math.sqrt((rigidity.bending / rigidity.axial).max()) / length[i]
    largest = np.abs(tension).max(axis=0)
    return Survey(
        scene=scene,
        vibration=answer,
        sensitivity=sensitivity,
        turning=float(np.abs(system.motion.omega).max() / modes.omega.min()),
        tension=float((largest / euler[mesh.cell_member]).max()),
        bow=float(bow.max()),
        slenderness=float(slenderness.max()),
    )


def _vibration(scene: Scene, system: System, modes: Modes) -> tuple[float, float]:
    """Estimate how far the response is from the quasi-static one, and how it changes with the stiffness.

    Every mode is an oscillator with its mean frequency under the harmonics of its load. Harmonic n is answered
    ``H = 1/(1 - r^2 + 2 i zeta r)`` times, r being n times the drive's rate over the mode's frequency. The sensitivity
    is the relative change of the response with the square of the frequency, H itself.

    Returns
    -------
    tuple
        Largest difference from the quasi-static response over the largest quasi-static response, and the sensitivity.
    """
    harmonics = np.fft.rfft(np.einsum("kmi,ki->km", modes.shapes, system.load), axis=0)
    omega = modes.omega.mean(axis=0)
    ratio = np.maximum(damping_ratios(scene, modes.omega)[0], LEAST_DAMPING) + scene.damping.material * omega / 2
    r = np.arange(len(harmonics))[:, None] * abs(scene.cycle_rate) / omega
    answer = 1 / (1 - r**2 + 2j * ratio * r)
    static = np.abs(harmonics) / omega  # times omega: the square root of the strain energy
    total = np.sqrt(np.sum(static.sum(axis=0) ** 2))
    if total == 0:
        return 0.0, 1.0
    moving = static * np.abs(answer - 1)
    dynamic = static * np.abs(answer)
    difference = math.sqrt(np.sum(moving.sum(axis=0) ** 2)) / total
    changed = np.sqrt(np.sum((dynamic * np.abs(answer)).sum(axis=0) ** 2))
    return difference, float(max(1.0, changed / np.sqrt(np.sum(dynamic.sum(axis=0) ** 2))))
