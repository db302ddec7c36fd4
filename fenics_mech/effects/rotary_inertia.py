"""Rotary inertia: the sections of a beam have a moment of inertia about the neutral line."""

from __future__ import annotations

import math

from fenics_mech.beams.timoshenko import with_rotary_inertia
from fenics_mech.effects.effect import Effect

EFFECT = Effect(
    name="rotary-inertia",
    meaning="inertia of the rotation of the beams' sections",
    source="Rayleigh, The Theory of Sound, section 162",
    beams=with_rotary_inertia,
    size=lambda survey: (math.pi * survey.slenderness) ** 2 * survey.sensitivity * min(survey.vibration, 1.0),
    estimate="(pi r/length)^2 x sensitivity x vibration",
)
