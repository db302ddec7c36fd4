"""Where joints, loads and springs take hold of the links: points of bodies, and the nodal dofs that move them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.scene import Link
from fenics_mech.scene.joints import Joint
from fenics_mech.scene.numbering import GROUND

if TYPE_CHECKING:
    from fenics_mech.beams.mesh import BeamMesh

QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])  # a quarter turn


@dataclass(frozen=True)
class Attachment:
    """A point of a body: its displacement in link axes is `shift` times its node's three dofs, its rotation the third.

    Parameters
    ----------
    body
        Name of the link, or "ground".
    link
        Index of the link, or `GROUND`.
    dofs
        The three dofs of its node; empty for the ground.
    shift
        ``(2, 3)``: a beam's node as it is; for a rigid link also its rotation times the arm from its centre.
    """

    body: str
    link: int
    dofs: Index
    shift: Array

    @classmethod
    def of(cls, links: Mapping[str, Link], joints: Mapping[str, Joint], mesh: BeamMesh, name: str) -> Attachment:
        """Find the attachment of a point "body.point", of a joint's pin, or of a place "member@0.3" that has a node.

        Parameters
        ----------
        links, joints
            The linkage, by name.
        mesh
            The mesh of its members.
        name
            The point, joint or place.
        """
        if "@" in name:
            label, s = name.split("@")
            node, link = mesh.node(f"{label}@{float(s):.12g}"), int(mesh.member_link[mesh.members.index(label)])
            return cls(list(links)[link], link, 3 * node + np.arange(3), np.eye(2, 3))
        if "." not in name:
            name = next(point for point in joints[name].connect if not point.startswith("ground."))
        body, point = name.split(".")
        if body == "ground":
            return cls(body, GROUND, np.zeros(0, dtype=np.int64), np.zeros((2, 0)))
        rigid = links[body].rigid
        node = mesh.node(name if rigid is None else f"{body}.centre")
        arm = np.zeros(2) if rigid is None else np.subtract(links[body].points[point], rigid.centre)
        shift = np.column_stack([np.eye(2), QUARTER @ arm])
        return cls(body, list(links).index(body), 3 * node + np.arange(3), shift)
