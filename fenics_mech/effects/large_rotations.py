"""Large rotations: only its stretch makes an axis longer, and axial forces act on the bent axis."""

from __future__ import annotations

import math
from dataclasses import replace

from fenics_mech.beams.element_dofs import element_dofs
from fenics_mech.effects.effect import Effect, Survey
from fenics_mech.effects.given_axial_forces import AxialStiffness
from fenics_mech.effects.nonlinear_law import ArcLength
from fenics_mech.effects.section_spin import SectionSpin
from fenics_mech.effects.terms import Situation, Terms


def terms(situation: Situation) -> Terms:
    """Give the law of the elements, and what axial forces of loads and rigid motion change along each."""
    beams, material = situation.beams, situation.scene.damping.material
    axis, stretching = beams.bent_axis, beams.stretching
    length = beams.mesh.cell_length
    rigidity = beams.rigidity.axial.mean / length
    has_motor = any(drive.motor is not None for drive in situation.scene.drives)  # it may turn the links otherwise
    spin = None if has_motor else SectionSpin.of(beams)
    of_nodes = ArcLength(axis, stretching, element_dofs(beams.mesh), rigidity, length, material)
    uneven = (AxialStiffness.uneven(beams, situation.uneven()),)
    if beams.reduction is None:
        return Terms(law=replace(of_nodes, spin=spin), uneven=uneven)
    coordinates, shape = beams.reduction.of_elements
    law = ArcLength(axis.by(shape), stretching.by(shape), coordinates, rigidity, length, material, of_nodes, spin)
    return Terms(law=law, uneven=uneven)


def size(survey: Survey) -> float:
    """Estimate what the elastic motion adds to axial forces, and how far bending shortens members.

    A half-wave of a sine of height a over a chord L is longer than the chord by ``(pi a)^2/(4 L)``. That is the share
    ``pi^2 a/(4 L)`` of the deflection a. Near buckling only the shortening holds the members.
    """
    near = survey.tension if survey.tension > 0.8 else 0.0  # of a mode's stiffness
    bow = survey.bow * (1 + survey.vibration)
    return max(survey.tension * survey.vibration, math.pi**2 / 4 * bow, near) * survey.sensitivity


EFFECT = Effect(
    name="large-rotations",
    meaning="exact strains: bending shortens a member, axial forces act on its bent axis",
    source="Reissner (1972); Simo and Vu-Quoc, J. Appl. Mech. 53 (1986) 849",
    terms=terms,
    stress_stiffening=True,
    nonlinear=True,
    replaces="geometric-stiffness",
    refuses=("geometric-stiffness",),
    size=size,
    estimate="change of stiffness x vibration, or (pi^2/4) bow/length",
    loads_at_nodes=True,
)
