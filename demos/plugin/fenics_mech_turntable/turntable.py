"""Centrifugal forces of a machine whose ground turns about the origin."""

import numpy as np

from fenics_mech.effects.effect import Effect
from fenics_mech.effects.terms import Situation, Terms


def terms(situation: Situation) -> Terms:
    """Give minus the centrifugal acceleration, in link axes."""
    mesh, motion = situation.beams.mesh, situation.motion
    speed = situation.scene.plugins["turntable"].speed
    c, s, (x, y) = np.cos(motion.angle), np.sin(motion.angle), np.moveaxis(motion.position, -1, 0)
    frames = np.stack([c * x + s * y, c * y - s * x], axis=-1)  # places of the links' origins, in their own axes
    of_dofs = np.zeros((len(motion.theta), len(mesh.node_link), 3))
    of_dofs[..., :2] = -(speed**2) * (frames[:, mesh.node_link] + mesh.node_xy)
    return Terms(acceleration=of_dofs.reshape(len(of_dofs), -1))


EFFECT = Effect(
    name="turntable",
    meaning="centrifugal force of a ground that turns about the origin",
    source="Goldstein, Classical Mechanics, chapter 4",
    terms=terms,
    stated=lambda scene: "turntable" in scene.plugins,
    stated_by="[plugins.turntable]",
    without={"plugins.turntable": None},
)
