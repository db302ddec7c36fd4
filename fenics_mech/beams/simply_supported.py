"""Frequencies of the members as simply supported beams."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.linalg import eigh

from fenics_mech._arrays import Array
from fenics_mech.scene import Scene
from fenics_mech.scene.sections import Rigidity
from fenics_mech.scene.sections.rigidity import SECTION

SPARE = 20  # sines beside the frequencies wanted


def simply_supported_frequencies(scene: Scene, count: int = 1) -> dict[str, np.ndarray]:
    """Give the frequencies of each member as a beam on two pins."""
    # A uniform beam has those of eq. (7.6). For a section that varies, its modes are the functions by which Ritz'
    # method gives them.
    frequencies = {}
    for label, (_, member) in scene.members().items():
        length = math.dist(*scene.member_ends(label))
        if scene.sections[member.section].constant:
            here = scene.rigidity(label, np.zeros(1))
            wave_speed = np.sqrt(here.bending / here.line_density)
            omega = np.arange(1, count + 1) ** 2 * np.pi**2 / length**2 * wave_speed  # (7.6), with m the whole mass
        else:
            omega = _of_sines(partial(scene.rigidity, label), count + SPARE)[:count] / length**2
        frequencies[label] = omega / (2 * np.pi)
    return frequencies


def _of_sines(rigidity: Callable[[Array], Rigidity], sines: int) -> np.ndarray:
    """Circular frequencies (rad/s) times length^2 (m^2) by Ritz' method, ascending."""
    x, weight = np.polynomial.legendre.leggauss(SECTION.gauss_points)
    s, weight = (1 + x) / 2, weight / 2
    section = rigidity(s)
    wave = np.pi * np.arange(1, sines + 1)
    shapes = np.sin(wave[:, None] * s)
    curvatures = wave[:, None] ** 2 * shapes
    stiffness, mass = (
        (f * weight * density) @ f.T for f, density in ((curvatures, section.bending), (shapes, section.line_density))
    )
    return np.sqrt(eigh(stiffness, mass, eigvals_only=True))
