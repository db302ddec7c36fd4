"""Rotary inertia: the sections of a beam have a moment of inertia about the neutral line."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from fenics_mech.beams.distributions import along_elements
from fenics_mech.effects.effect import Effect
from fenics_mech.scene import Scene

if TYPE_CHECKING:
    from fenics_mech.beams.element_matrices import Beams


def beams(scene: Scene, links: Beams) -> Beams:
    """Add ``int rho I phi psi dx`` to the mass, phi the rotation of the sections.

    A section turns by the rigid angle of its link and by phi, with the kinetic energy ``rho I (omega + phi')^2/2`` per
    length. So the mass also acts on the link's angular acceleration, the slope of the rigid acceleration. It has no
    part in the gyroscopic matrix, and none in the centrifugal forces.
    """
    (rotary,) = along_elements(
        links.layout, lambda label, s: scene.rigidity(label, s).rotary_inertia[None], links.rigidity.varies
    )
    return replace(links, inertia=replace(links.inertia, rotary=rotary))


EFFECT = Effect(
    name="rotary-inertia",
    meaning="inertia of the rotation of the beams' sections",
    source="Rayleigh, The Theory of Sound, section 162",
    beams=beams,
    size=lambda survey: (math.pi * survey.slenderness) ** 2 * survey.sensitivity * min(survey.vibration, 1.0),
    estimate="(pi r/length)^2 x sensitivity x vibration",
)
