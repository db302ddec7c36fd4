"""Lumped mass: half of each element's mass at each of its nodes, instead of the consistent mass."""

from __future__ import annotations

from fenics_mech.beams.lumped import lumped
from fenics_mech.effects.effect import Effect

EFFECT = Effect(
    name="lumped-mass",
    meaning="half of each element's mass at each of its nodes",
    source="Sadler and Sandor (1973), Sandor and Zhuang (1985): refs. 37 and 39",
    beams=lumped,
)
