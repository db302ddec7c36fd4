"""Gravity, in any direction: it acts on every mass as an acceleration of the frame against it would."""

from __future__ import annotations

import numpy as np

from fenics_mech.effects.effect import Effect
from fenics_mech.effects.terms import Situation, Terms, in_links


def terms(situation: Situation) -> Terms:
    """Give minus the acceleration of gravity, in link axes; so the links carry their weight where their mass is."""
    of_dofs = np.zeros((len(situation.motion.theta), len(situation.beams.mesh.node_link), 3))
    of_dofs[..., :2] = -in_links(situation.motion, np.array(situation.scene.gravity))[:, situation.beams.mesh.node_link]
    return Terms(acceleration=of_dofs.reshape(len(of_dofs), -1))


EFFECT = Effect(
    name="gravity",
    meaning="weight of links, bodies and point masses",
    source="d'Alembert's principle; (4.17) less g",
    terms=terms,
    stated=lambda scene: any(scene.gravity),
    stated_by="gravity = [...]",
    size=lambda survey: survey.gravity,
    estimate="strains by gravity alone over all quasi-static ones",
    without={"gravity": (0.0, 0.0)},
)
