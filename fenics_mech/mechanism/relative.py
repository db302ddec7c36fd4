"""Displacements relative to a base node, for members along which a pin travels that cannot give way.

Such a pin takes a freedom from the member, at every angle from another element. A nodal dof is felt in the elements
beside its node only, so that none of them can be solved for at all angles. Written as the rigid motion of a base node
and the displacements z relative to it, ``v = B z``, the base's own dofs are felt all along the member. Since any of its
nodes then moves with all of them, P is dense over that member.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_matrix, identity

from fenics_mech.mechanism.contact import Contact


def relative_to_base(contacts: Sequence[Contact], size: int) -> csr_matrix:
    """Give B, ``(size, size)``: the nodes of these contacts' members follow a base node of their link.

    Parameters
    ----------
    contacts
        The contacts; their members must be of one mesh.
    size
        Number of nodal dofs and joints' own coordinates; all others stay as they are.
    """
    mesh = contacts[0].mesh
    nodes = np.unique(np.concatenate([contact.dofs for contact in contacts]) // 3)
    _, first, link = np.unique(mesh.node_link[nodes], return_index=True, return_inverse=True)
    base = nodes[first][link]
    nodes, base = nodes[nodes != base], base[nodes != base]
    x, y = (mesh.node_xy[nodes] - mesh.node_xy[base]).T
    one = np.ones(len(nodes))
    places = ((0, 0, one), (1, 1, one), (2, 2, one), (0, 2, -y), (1, 2, x))  # u_b + phi_b x arm, phi_b
    rows, columns, values = (
        np.concatenate(part) for part in zip(*((3 * nodes + i, 3 * base + j, value) for i, j, value in places))
    )
    followed = values != 0  # the arms along the link's axes
    carried = csr_matrix((values[followed], (rows[followed], columns[followed])), shape=(size, size))
    return (identity(size, format="csr") + carried).tocsr()
