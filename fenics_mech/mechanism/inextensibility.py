"""Members that cannot stretch: fewer coordinates, with no penalty stiffness and no equation per element.

Along such a member all nodes have one displacement along its axis. That is the same at all angles in link axes, so it
is solved once, by a constant matrix B in ``v = B z``. z holds some displacements of each link's points, and the others
follow from them. The multipliers of these equations are the axial forces.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.linalg import qr
from scipy.sparse.linalg import splu

from fenics_mech._arrays import Array, Index
from fenics_mech.beams.element_dofs import element_dofs
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.effects.inextensible import EFFECT as INEXTENSIBLE
from fenics_mech.errors import SceneError


@dataclass(frozen=True)
class EliminationLimits:
    """Limits by which the unknowns to solve for are chosen."""

    leverage: float = 1e8  # largest factor of an unknown that is kept in one that is solved for
    travelling_leverage: float = 30.0  # the same where a pin travels, rotations times its member's length
    condition: float = 1e14  # of the equations by the unknowns solved for: beyond it they count as singular
    pivot: float = 1e-6  # smallest pivot, relative to its column
    nodal_pivot: float = 0.1  # of a relative nodal dof, below which a joint's own coordinate is solved for instead
    positions: int = 96  # at which unknowns are chosen where members cannot stretch
    independent: float = 1e-9  # independence of a member's equation from those of the others in its link


ELIMINATION = EliminationLimits()


@dataclass(frozen=True)
class Inextensible:
    """The members that cannot stretch.

    Parameters
    ----------
    mesh
        The mesh.
    members
        Their indices.
    """

    mesh: BeamMesh
    members: Index

    @classmethod
    def of(cls, mesh: BeamMesh, axial_rigidity: Array) -> Inextensible | None:
        """Find the members whose EA is infinite; None where there is none.

        Parameters
        ----------
        mesh
            The mesh.
        axial_rigidity
            EA of each element (N), ``(elements,)``.
        """
        members = np.unique(mesh.cell_member[np.isinf(axial_rigidity)])
        return cls(mesh, members) if members.size else None

    def base(self, size: int) -> sp.csr_matrix:
        """Give B, ``(size, size)``; the columns of dofs that follow from others are empty.

        Parameters
        ----------
        size
            Number of unknowns: nodal dofs, and the joints' own coordinates.

        Raises
        ------
        SceneError
            When members of a link brace each other: their axial forces would be undetermined.
        """
        ends = sp.identity(size, format="csr")
        for link in np.unique(self.mesh.member_link[self.members]):
            ends = ends + self._of_points(self.members[self.mesh.member_link[self.members] == link], size)
        base = (self._of_inner_nodes(size) @ ends).tocsr()
        base.eliminate_zeros()
        return base

    def _of_points(self, members: Index, size: int) -> sp.csr_matrix:
        """Let some displacements of a link's points follow from the others; as a change of the identity."""
        first, last = np.array([self._nodes(member)[[0, -1]] for member in members]).T
        points = np.unique([first, last])
        place = np.stack([2 * np.searchsorted(points, node) for node in (first, last)])
        rows = np.zeros((len(members), 2 * len(points)))
        for i, axis in enumerate(self._axes(members)):
            rows[np.arange(len(members)), place[0] + i] = -axis
            rows[np.arange(len(members)), place[1] + i] = axis
        _, triangle, order = qr(rows, mode="economic", pivoting=True)
        rank = int(np.sum(np.abs(np.diag(triangle)) > ELIMINATION.independent))
        if rank < len(members):
            label = self.mesh.members[members[0]]
            raise SceneError(
                f"the members of link {label.split('.')[0]} brace each other: {len(members) - rank} more than hold its "
                "points in place, so that the axial forces of members that cannot stretch are not determined",
                place="effects",
                hint=f"Leave {INEXTENSIBLE.name!r} out, or take out members",
            )
        dofs = (3 * points[:, None] + np.arange(2)).ravel()
        held, free = dofs[order[:rank]], dofs[order[rank:]]
        follow = -np.linalg.solve(triangle[:, :rank], triangle[:, rank:])
        follow[np.abs(follow) < ELIMINATION.independent] = 0.0
        change = sp.lil_matrix((size, size))
        change[held, held] = -1.0
        change[np.ix_(held, free)] = follow
        return change.tocsr()

    def _of_inner_nodes(self, size: int) -> sp.csr_matrix:
        """Let the nodes inside members follow their first points along the axis."""
        rows, columns, values = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)], [np.zeros(0)]
        for member, axis in zip(self.members, self._axes(self.members).T):
            nodes = self._nodes(member)
            inner, lead = 3 * nodes[1:-1], int(np.argmax(np.abs(axis)))
            share = axis / axis[lead]  # the component along `lead` is solved for
            for column, value in ((inner + lead, -1.0), (inner + 1 - lead, -share[1 - lead])):
                rows.append(inner + lead)
                columns.append(column)
                values.append(np.full(len(inner), value))
            for i in range(2):
                rows.append(inner + lead)
                columns.append(np.full(len(inner), 3 * nodes[0] + i))
                values.append(np.full(len(inner), share[i]))
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        change = sp.csr_matrix(entries, shape=(size, size))
        change.data[np.abs(change.data) < ELIMINATION.independent] = 0.0
        return sp.identity(size, format="csr") + change

    def forces(self, nodal: Array) -> Array:
        """Axial force of each element that gives the nodes these forces (N), ``(angles, elements)``.

        Parameters
        ----------
        nodal
            Forces of the elements' tension on the nodes, in link axes, ``(angles, nodal dofs)``.
        """
        cells, equations, factors = self._equations
        tension = np.zeros((len(nodal), len(self.mesh.cell)))
        tension[:, cells] = factors.solve(np.asarray(equations @ nodal.T)).T
        return tension

    @cached_property
    def _equations(self) -> tuple[Index, sp.csr_matrix, Any]:
        """Elements that cannot stretch, C of their equations ``C v = 0``, and the factors of C C^T."""
        mesh = self.mesh
        cells = np.flatnonzero(np.isin(mesh.cell_member, self.members))
        axis = self._axes(mesh.cell_member[cells]).T
        columns = element_dofs(mesh)[cells][:, [0, 1, 3, 4]]
        values = np.concatenate([-axis, axis], axis=1)
        pointers = 4 * np.arange(len(cells) + 1)
        shape = (len(cells), 3 * len(mesh.node_name))
        matrix = sp.csr_matrix((values.ravel(), columns.ravel(), pointers), shape=shape)
        return cells, matrix, splu((matrix @ matrix.T).tocsc())

    def _nodes(self, member: int) -> Index:
        """Nodes along a member."""
        cells = self.mesh.cell_nodes[self.mesh.cell_member == member]
        return np.append(cells[:, 0], cells[-1, 1])

    def _axes(self, members: Index) -> Array:
        """Directions of members in link axes, ``(2, members)``."""
        angle = self.mesh.member_angle[members]
        return np.stack([np.cos(angle), np.sin(angle)])
