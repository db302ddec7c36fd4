"""Loads at points of the links."""

from __future__ import annotations

import numpy as np

from fenics_mech.beams.attachment import GROUND, Attachment
from fenics_mech.effects.effect import Effect
from fenics_mech.effects.terms import Situation, Terms


def terms(situation: Situation) -> Terms:
    """Give the loads on the nodal dofs in link axes, {Qex} of (4.39)."""
    scene, beams, motion = situation.scene, situation.beams, situation.motion
    forces = np.zeros((len(motion.theta), 3 * len(beams.mesh.node_name)))
    for load in scene.loads.values():
        point = Attachment.of(scene, beams.mesh, load.at)
        if point.link == GROUND:
            continue
        angle = motion.angle[:, point.link]
        c, s, (x, y) = np.cos(angle), np.sin(angle), load.force
        in_link = np.stack([c * x + s * y, c * y - s * x], axis=-1)  # transpose of (7.3)
        forces[:, point.dofs] += in_link @ point.shift + load.moment * np.array([0.0, 0.0, 1.0])
    return Terms(force=forces)


EFFECT = Effect(
    name="loads",
    meaning="forces and moments at points of the links",
    source="(4.39)",
    terms=terms,
    stated=lambda scene: bool(scene.loads),
)
