"""From values on a mesh to those on another mesh of the same members."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from fenics_mech._arrays import Array, Index
from fenics_mech.beams.element_dofs import element_dofs, member_rotation
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.beams.shapes import AXIAL, CUBIC, LINEAR, NORMAL, evaluate


def nodal_on(new: BeamMesh, old: BeamMesh) -> sp.csr_matrix:
    """Give the matrix that makes nodal dofs of a mesh of those of another, as the elements' shape functions do.

    Parameters
    ----------
    new, old
        Two meshes of the same members.

    Returns
    -------
    scipy.sparse.csr_matrix
        Shape ``(nodal dofs of the new mesh, those of the old one)``; dofs are in link axes.
    """
    node, first = np.unique(new.cell_nodes, return_index=True)
    cell, end = np.divmod(first, 2)
    member, place = new.cell_member[cell], new.cell_start[cell] + end * new.cell_length[cell]
    element = _before(old, old.cell_start, member, place)
    length = old.cell_length[element]
    xi = (place - old.cell_start[element]) / length
    shapes = np.zeros((len(node), 3, 6))
    shapes[:, 0, AXIAL] = evaluate(LINEAR, xi)
    shapes[:, 1, NORMAL] = evaluate(CUBIC, xi)
    shapes[:, 2, NORMAL] = evaluate(tuple(f.deriv() for f in CUBIC), xi) / length[:, None]
    shapes[:, :, [2, 5]] *= length[:, None, None]
    turn = member_rotation(old)[element]
    values = np.swapaxes(turn[:, :3, :3], 1, 2) @ shapes @ turn
    rows = 3 * node[:, None, None] + np.arange(3)[:, None]
    rows, columns = np.broadcast_arrays(rows, element_dofs(old)[element][:, None])
    lone = np.setdiff1d(np.arange(len(new.node_name)), node)  # centres of rigid links
    same = np.array([old.node(new.node_name[i]) for i in lone], dtype=np.int64)
    more, others = (np.ravel(3 * part[:, None] + np.arange(3)) for part in (lone, same))
    places = np.append(rows, more), np.append(columns, others)
    shape = 3 * len(new.node_name), 3 * len(old.node_name)
    return sp.csr_matrix((np.append(values, np.ones(len(more))), places), shape)


def elemental_on(new: BeamMesh, old: BeamMesh) -> sp.csr_matrix:
    """Give the matrix that makes values at the middles of elements of those of another mesh, linear between them.

    Parameters
    ----------
    new, old
        Two meshes of the same members.

    Returns
    -------
    scipy.sparse.csr_matrix
        Shape ``(elements of the new mesh, those of the old one)``.
    """
    middle, wanted = (mesh.cell_start + mesh.cell_length / 2 for mesh in (old, new))
    before = _before(old, middle, new.cell_member, wanted)
    last = np.searchsorted(old.cell_member, new.cell_member, side="right") - 1
    before = np.maximum(np.minimum(before, last - 1), np.searchsorted(old.cell_member, new.cell_member))
    after = np.minimum(before + 1, last)  # the same where the member has one element
    share = (wanted - middle[before]) / np.where(after > before, middle[after] - middle[before], 1.0)
    share = np.where(after > before, share, 0.0)
    rows, columns = np.tile(np.arange(len(wanted)), 2), np.append(before, after)
    return sp.csr_matrix((np.append(1 - share, share), (rows, columns)), (len(wanted), len(middle)))


def _before(old: BeamMesh, starts: Array, member: Index, place: Array) -> Index:
    """Give the last element of each member that starts before a place (m), or the member's first one."""
    offset = 2 * np.append(0.0, np.cumsum(old.member_length))
    found = np.searchsorted(offset[old.cell_member] + starts, offset[member] + place, side="right") - 1
    first, last = (np.searchsorted(old.cell_member, member, side=side) for side in ("left", "right"))
    return np.clip(found, first, last - 1)
