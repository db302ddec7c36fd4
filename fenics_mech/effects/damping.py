"""Damping by the material (Kelvin and Voigt) and by the surroundings."""

from fenics_mech.effects.effect import Effect
from fenics_mech.effects.terms import ProportionalDamping, Situation, Terms


def _terms(situation: Situation) -> Terms:
    damping = situation.scene.damping
    return Terms(damping=ProportionalDamping(damping.external, damping.relative, damping.material))


EFFECT = Effect(
    name="damping",
    meaning="stress that goes with the strain's rate, and drag in proportion to the mass",
    source="Clough and Penzien, Dynamics of Structures, sections 17-3 and 12-5",
    terms=_terms,
    stated=lambda scene: bool(scene.damping.material or scene.damping.external or scene.damping.relative),
    stated_by="[damping] with material, external or relative",
)
