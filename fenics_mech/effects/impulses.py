"""Impulses, which change velocities in an instant, ``M (q'_after - q'_before) = P^T J``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.beams.attachment import QUARTER, Attachment
from fenics_mech.effects.effect import Effect
from fenics_mech.effects.terms import in_links
from fenics_mech.kinematics import Motion
from fenics_mech.scene import Impulse, Link
from fenics_mech.scene.joints import Joint

if TYPE_CHECKING:
    from fenics_mech.beams.element_matrices import Beams


def nodal_impulses(
    impulses: Iterable[Impulse], links: Mapping[str, Link], joints: Mapping[str, Joint], beams: Beams, motion: Motion
) -> tuple[Array, Array]:
    """Give impulses on the nodal dofs in link axes (N s, N m s), ``(impulses, nodal dofs)`` each.

    Parameters
    ----------
    impulses
        The impulses.
    links, joints
        The linkage, by name.
    beams
        The links' matrices.
    motion
        The rigid motion at the impulses' angles, one for each.

    Returns
    -------
    tuple
        The impulses, and the same turned by a quarter clockwise: their work on v as a link turns by 1 rad.
    """
    acting, turned = np.zeros((2, len(motion.theta), 3 * len(beams.mesh.node_link)))
    for i, impulse in enumerate(impulses):
        point = Attachment.of(links, joints, beams.mesh, impulse.at)
        in_link = in_links(motion, np.array(impulse.impulse))[i, point.link]
        acting[i, point.dofs] = in_link @ point.shift + [0.0, 0.0, impulse.angular_impulse]
        turned[i, point.dofs] = in_link @ QUARTER @ point.shift
    return acting, turned


EFFECT = Effect(
    name="impulses",
    meaning="impulses at points of the links, at given drive angles",
    source="Lagrange's equations integrated over an instant; Goldsmith, Impact (1960), ch. 2",
    stated=lambda scene: bool(scene.impulses),
    stated_by="[impulses]",
)
