"""What a scene states, and does not state, of the shear stiffness of its members."""

from __future__ import annotations

import numpy as np

from fenics_mech.beams.timoshenko import refuse_travelling
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene
from fenics_mech.scene.bodies import POISSON


def assumed(scene: Scene) -> tuple[str, ...]:
    """Say of which materials Poisson's ratio is assumed: those that state none, and of which members consist."""
    found, middle = [], np.array([0.5])
    for name, material in scene.materials.items():
        stated = scene.changed({f"materials.{name}.shear_modulus": material.rigidity / 2})
        softer = (
            stated.shear_stiffness(label, middle) < scene.shear_stiffness(label, middle) for label in scene.members()
        )
        if material.shear_unstated and any(softer):
            found.append(
                f"materials.{name} states neither `poisson` nor `shear_modulus`: shear takes a Poisson's ratio of "
                f"{POISSON}, as of metals. Wood and composites need `shear_modulus`"
            )
    return tuple(found)


def missing_data(scene: Scene) -> str:
    """Say which member does not state its shear factor, or which pin travels along one; else nothing."""
    try:
        for label in scene.members():
            scene.shear_stiffness(label, np.zeros(1))
        refuse_travelling(scene.joints)
    except SceneError as error:
        return str(error)
    return ""
