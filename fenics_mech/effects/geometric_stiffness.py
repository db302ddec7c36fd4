"""Geometric stiffness: tension in a link holds it straight, compression bends it further."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fenics_mech.effects.effect import Effect
from fenics_mech.effects.given_axial_forces import AxialForces, AxialStiffness
from fenics_mech.effects.terms import Situation, Terms

if TYPE_CHECKING:
    from fenics_mech.beams.element_matrices import Beams


def terms(situation: Situation) -> Terms:
    """Give ``int N w' z' dx`` with the axial force N of loads and rigid motion, linear along each element."""
    return of_forces(situation.beams, situation.tension())


def of_forces(beams: Beams, forces: AxialForces) -> Terms:
    """Give the stiffness of axial forces.

    Parameters
    ----------
    beams
        The links' matrices.
    forces
        The axial forces.
    """
    return Terms(
        stiffening=AxialStiffness.even(beams, forces.mean), uneven=(AxialStiffness.uneven(beams, forces.slope),)
    )


EFFECT = Effect(
    name="geometric-stiffness",
    meaning="bending stiffness from the axial force of loads and rigid motion",
    source="section 7.4; Przemieniecki (1968), ch. 15",
    terms=terms,
    stress_stiffening=True,
    refuses=("large-rotations",),
    size=lambda survey: survey.tension * survey.sensitivity,
    estimate="change of a mode's stiffness x sensitivity",
    loads_at_nodes=True,
)
