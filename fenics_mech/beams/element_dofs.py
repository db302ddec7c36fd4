"""Nodal dofs of the elements, and how they turn from the axes of the links into those of the members."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array, Index, each

if TYPE_CHECKING:
    from fenics_mech.beams.mesh import BeamMesh


def member_rotation(mesh: BeamMesh) -> Array:
    """Turn an element's nodal dofs from link axes into its member's axes, ``(elements, 6, 6)``."""
    angle = mesh.member_angle[mesh.cell_member]
    rotation = np.zeros((len(angle), 6, 6))
    for first in (0, 3):
        rotation[:, first, first] = rotation[:, first + 1, first + 1] = np.cos(angle)
        rotation[:, first, first + 1] = np.sin(angle)
        rotation[:, first + 1, first] = -np.sin(angle)
        rotation[:, first + 2, first + 2] = 1.0
    return rotation


def element_dofs(mesh: BeamMesh) -> Index:
    """Nodal dofs of each element, ``(elements, 6)``."""
    return (3 * mesh.cell_nodes[:, :, None] + np.arange(3)).reshape(-1, 6)


def in_member_axes(mesh: BeamMesh, nodal: Array) -> Array:
    """Nodal values in link axes as those of each element in its member's axes, ``(angles, elements, 6)``."""
    # nodal (angles, nodal dofs)
    return each(member_rotation(mesh), nodal[:, element_dofs(mesh)])
