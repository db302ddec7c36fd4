"""Frequencies of the members as simply supported beams."""

from __future__ import annotations

import math

import numpy as np

from fenics_mech.scene import Scene


def simply_supported_frequencies(scene: Scene, count: int = 1) -> dict[str, np.ndarray]:
    """Frequencies (Hz) of each member as a uniform beam on two pins, by label; eq. (7.6)."""
    frequencies = {}
    orders = np.arange(1, count + 1)
    for label, (_, member) in scene.members().items():
        section, material = scene.sections[member.section], scene.materials[member.material]
        length = math.dist(*scene.member_ends(label))
        wave_speed = np.sqrt(material.modulus * section.inertia / (material.density * section.area))
        omega = orders**2 * np.pi**2 / length**2 * wave_speed  # (7.6), with m the member's whole mass
        frequencies[label] = omega / (2 * np.pi)
    return frequencies
