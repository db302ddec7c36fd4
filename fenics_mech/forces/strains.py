"""Strains of the outer fibres from the forces in sections."""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.scene import Scene


def stress_over_modulus(scene: Scene, s: Array, axial_force: Array, moment: Array) -> tuple[Array, Array]:
    """Give what stress over modulus an axial force and a moment make: the strain where the material does not damp.

    Parameters
    ----------
    scene
        Gives the members' sections and materials.
    s
        Stations 0..1 along the members, ``(stations,)``.
    axial_force, moment
        N (N) and M (N m), ``(angles, members, stations)``.

    Returns
    -------
    tuple
        By the axial force N/EA, ``(angles, members, stations)``, and by the moment in both outer fibres, - M e/EI with
        e the fibre's place on the normal's side, ``(angles, members, stations, 2)``. Their sum is (6.38).
    """
    found = [scene.rigidity(label, s) for label in scene.members()]
    axial, bending, fibre = (np.stack([getattr(r, part) for r in found]) for part in ("axial", "bending", "fibre"))
    return axial_force / axial, -moment[..., None] * fibre / bending[..., None]


def young_modulus(scene: Scene, s: Array) -> Array:
    """Young's modulus (Pa) at both outer fibres, ``(members, stations, 2)``; `s` are stations 0..1.

    Parameters
    ----------
    scene
        The scene.
    s
        Stations along every member, ``(stations,)``.
    """
    return np.stack([scene.rigidity(label, s).modulus for label in scene.members()])
