"""Shear flexibility: sections do not stay normal to the axis (Timoshenko's beam)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.beams.distributions import along_elements
from fenics_mech.beams.shapes import NORMAL
from fenics_mech.effects.effect import Effect
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene
from fenics_mech.scene.bodies import POISSON
from fenics_mech.scene.joints import Joint

if TYPE_CHECKING:
    from fenics_mech.beams.element_matrices import Beams


def beams(scene: Scene, links: Beams) -> Beams:
    """Add the stiffness of shear, with an angle of shear gamma in each element that its equilibrium gives.

    The axis w is cubic, its slope at a node gamma more than the rotation phi of the section there. Gamma, constant in
    the element, makes its energy of bending and shear stationary. So the element is exact under forces at its ends,
    however thin it is: nothing locks.

    Raises
    ------
    SceneError
        When a section does not say what is needed, or a pin travels along a member that bends.
    """
    _refuse_travelling(scene.joints)
    (stiffness,) = along_elements(
        links.layout, lambda label, s: scene.shear_stiffness(label, s)[None], links.rigidity.varies
    )
    angle = _angle(links, stiffness.mean * links.mesh.cell_length)
    return replace(links, layout=links.layout.sheared(angle), rigidity=replace(links.rigidity, shear=stiffness))


def _angle(links: Beams, stiffness: Array) -> Array:
    """Angle of shear by w and phi of both nodes, ``(elements, 4)``; `stiffness` is the integral of G A_s (N m)."""
    from fenics_mech import _fenicsx  # noqa: PLC0415  (dolfinx is slow to import, and few scenes have shear)
    from fenics_mech.beams.forms import bending  # noqa: PLC0415

    layout = links.layout
    broken = _fenicsx.assemble_matrix(bending(layout.space, links.rigidity.bending.coefficient))
    moments = layout.of_elements(broken)[:, NORMAL][..., [2, 5]].sum(axis=-1)  # of both ends, by w and w'
    return -moments / (moments[:, [1, 3]].sum(axis=-1) + stiffness)[:, None]


def assumed(scene: Scene) -> tuple[str, ...]:
    """Say of which materials Poisson's ratio is assumed: those that state none, and of which members consist.

    Parameters
    ----------
    scene
        A scene with this effect.
    """
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
        _refuse_travelling(scene.joints)
    except SceneError as error:
        return str(error)
    return ""


def _refuse_travelling(joints: Mapping[str, Joint]) -> None:
    """Raise `SceneError` where the pin of a joint travels along a member."""
    for name, joint in joints.items():
        if joint.member is not None:
            raise SceneError(
                f"the effect {EFFECT.name!r} is not available where pins travel along members",
                place=f"joints.{name}.member",
                hint=f"Leave {EFFECT.name!r} out of the effects",
            )


EFFECT = Effect(
    name="shear",
    meaning="shear flexibility of the beams",
    source="Timoshenko (1921); Friedman and Kosmatka, Comput. Struct. 47 (1993) 473",
    beams=beams,
    missing_data=missing_data,
    size=lambda survey: 3 * (math.pi * survey.slenderness) ** 2 * survey.sensitivity * min(survey.vibration, 1.0),
    estimate="3 (pi r/length)^2 x sensitivity x vibration",
    loads_at_nodes=True,
)
