"""Mass beside the members' axes: what the rigid motion of the axes does not know of its acceleration."""

from __future__ import annotations

import numpy as np

from fenics_mech.effects.terms import Loads, Situation, Terms


def terms(situation: Situation) -> Terms:
    """Give the centrifugal force ``rho A b omega^2`` along the normal of mass that is b beside its member's axis.

    All else of its acceleration is in the nodes': along the axis it is ``-alpha b``, by their rotation. As
    everywhere on an arm, products of the offset and of elastic rotations are left out.
    """
    beams, offsets = situation.beams, situation.beams.layout.offsets
    assert offsets is not None
    omega = situation.motion.omega[:, beams.mesh.member_link[beams.mesh.cell_member]]
    line = np.zeros((*omega.shape, 4))
    line[..., 2:] = (omega**2 * beams.inertia.density.mean * (offsets.neutral + offsets.mass))[..., None]
    return Terms(loads=Loads(line=line))
