"""Geometric stiffness: tension in a link holds it straight, compression bends it further."""

from fenics_mech.effects.effect import Effect
from fenics_mech.effects.given_axial_forces import StressStiffening, UnevenTension
from fenics_mech.effects.terms import Situation, Terms


def terms(situation: Situation) -> Terms:
    """Give ``int N w' z' dx`` with the axial force N of loads and rigid motion, linear along each element."""
    beams, forces = situation.beams, situation.tension()
    return Terms(stiffening=StressStiffening.of(beams, forces.mean), uneven=(UnevenTension.of(beams, forces.slope),))


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
