"""Coupling of rigid and elastic motion: Coriolis, centrifugal and Euler forces on the elastic displacement."""

from fenics_mech.effects.effect import Effect
from fenics_mech.effects.terms import Terms

EFFECT = Effect(
    name="coupling",
    meaning="Coriolis, centrifugal and Euler forces on the elastic displacement",
    source="(4.59)-(4.66), which (5.1) drops",
    terms=lambda situation: Terms(coupled=True),
    couples=True,
    needs=("vibration",),
    size=lambda survey: max(survey.turning**2 * survey.sensitivity, survey.vibration / 2),
    estimate="(link rate/frequency)^2 x sensitivity, or vibration/2",
)
