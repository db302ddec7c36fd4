"""Geometric stiffness: tension in a link holds it straight, compression bends it further."""

from fenics_mech.effects.effect import Effect
from fenics_mech.effects.terms import Situation, StressStiffening, Terms


def terms(situation: Situation) -> Terms:
    """Give ``int N w' z' dx`` with the mean axial force N of each element, of loads and rigid motion."""
    return Terms(stiffening=StressStiffening.of(situation.beams, situation.tension()))


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
