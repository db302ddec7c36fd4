"""Damping by the material (Kelvin and Voigt) and by the surroundings."""

from fenics_mech.effects.effect import Effect
from fenics_mech.effects.terms import Terms

EFFECT = Effect(
    name="damping",
    meaning="stress that goes with the strain's rate, and drag in proportion to the mass",
    source="Clough and Penzien, Dynamics of Structures, sections 17-3 and 12-5",
    terms=lambda situation: Terms(material=situation.scene.damping.material, external=situation.scene.damping.external),
    stated=lambda scene: bool(scene.damping.material or scene.damping.external),
    stated_by="`material` or `external` in [damping]",
)
