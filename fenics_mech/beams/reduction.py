"""Reduction of the links: the displacement of all their nodes by that of a few, and by a few modes of each member.

``v = T z`` (Craig and Bampton, AIAA J. 6, 1968, p. 1313): between its ends, which are nodes of joints, a member takes
the shape that statics gives it, and vibrates in its lowest modes with both ends clamped. The links' matrices do not
depend on the drive angle in the links' own axes, nor does T: it is found once.

Where the strain is nonlinear, bending shortens members, which no mode along the axis can follow. There the displacement
of all inner nodes along the axis is kept, in place of those modes: every element then stretches by itself.

The modes and the matrices over z come from the mesh as it is, however fine. What happens at every drive angle needs a
few of its nodes only: a coarser mesh with the same members, on which strains are recovered.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fenics_mech._arrays import Array, Index
from fenics_mech.beams.element_dofs import element_dofs, member_rotation
from fenics_mech.beams.element_matrices import Beams
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.beams.span import REDUCTION, Span, outside


@dataclass(frozen=True, eq=False)
class Reduction:
    """The links' coordinates z, and what the nodal dofs are by them.

    Parameters
    ----------
    fine
        The links on the mesh that the modes are from.
    mesh
        The mesh whose nodal dofs are meant: some of the same nodes.
    kept
        Nodal dofs that are coordinates themselves, ascending: the first of z.
    spans
        The members whose inner nodes are not.
    cutoff
        Frequency up to which their modes are kept (rad/s).
    mode_member
        Member of each mode, and then of each displacement along the axis that is kept: they follow the nodal dofs in z.
    mode_omega
        Frequency of each mode (rad/s).
    shape, fine_shape
        T, ``(nodal dofs, coordinates)``, on both meshes.
    stiffness
        ``T^T k T``, which has no entries between nodal dofs and what follows.
    """

    fine: Beams
    mesh: BeamMesh
    kept: Index
    spans: tuple[Span, ...]
    cutoff: float
    mode_member: Index
    mode_omega: Array
    shape: sp.csr_matrix
    fine_shape: sp.csr_matrix
    stiffness: sp.csr_matrix

    @classmethod
    def of(
        cls, fine: Beams, seen: Beams, members: Sequence[int], cutoff: float | None = None, stretched: bool = False
    ) -> Reduction:
        """Reduce the links.

        Parameters
        ----------
        fine
            The links.
        seen
            The same on a mesh that has some of their nodes.
        members
            Those members that are to be reduced.
        cutoff
            Frequency up to which their modes with clamped ends are kept (rad/s); None means `REDUCTION.cutoff` times
            the lowest of them all, below which the mechanism's own lowest mode is.
        stretched
            Whether the displacement along the axis of the inner nodes that are seen is kept.
        """
        height = 3 * len(fine.mesh.node_name)
        mass = fine.mass
        spans = [Span.of(fine, mass, member) for member in members]
        if cutoff is None:
            cutoff = REDUCTION.cutoff * min((span.lowest for span in spans), default=0.0)
        kept = _without(height, spans)
        static = sp.csr_matrix((np.ones(len(kept)), (kept, np.arange(len(kept)))), shape=(height, len(kept)))
        parts, omegas = [static], [np.zeros(0)]
        for span in spans:
            inner = span.inner.ravel()
            parts[0] = parts[0] + _placed(span.carried(), inner, np.searchsorted(kept, span.ends), static.shape)
            omega, shapes = span.modes(cutoff, bending=stretched)
            omegas.append(omega)
            parts.append(_placed(shapes.T, inner, np.arange(len(shapes)), (height, len(shapes))))
        shape, omega = sp.hstack(parts, format="csr"), np.concatenate(omegas)
        inside = sp.diags(omega**2 * (shape.T @ mass @ shape).diagonal()[len(kept) :])
        on_seen = spans if seen is fine else [Span.of(seen, seen.mass, member) for member in members]
        within = [span.member for span, part in zip(spans, omegas[1:]) for _ in part]
        if stretched:
            axial = _along(spans, on_seen, height)
            between = sp.diags(omega**2) @ shape[:, len(kept) :].T @ mass @ axial  # 0 on the neutral line
            inside = sp.bmat([[inside, between], [between.T, _axial_stiffness(seen, on_seen)]])
            shape = sp.hstack([shape, axial], format="csr")
            within += [span.member for span in on_seen for _ in span.inner]
        rows = (3 * np.array([fine.mesh.node(name) for name in seen.mesh.node_name])[:, None] + np.arange(3)).ravel()
        return cls(
            fine=fine,
            mesh=seen.mesh,
            kept=_without(len(rows), on_seen),
            spans=tuple(on_seen),
            cutoff=cutoff,
            mode_member=np.array(within, dtype=np.int64),
            mode_omega=omega,
            shape=shape[rows],
            fine_shape=shape,
            stiffness=sp.block_diag([_stiffness(fine, spans, kept), inside], format="csr"),
        )

    @property
    def fineness(self) -> float:
        """How many times as long as that of the modes the longest element of a member is in the mesh, at least."""

        def longest(mesh: BeamMesh, member: int) -> float:
            return float(mesh.cell_length[mesh.cell_member == member].max())

        return min((longest(self.mesh, s.member) / longest(self.fine.mesh, s.member) for s in self.spans), default=1.0)

    @cached_property
    def mass(self) -> sp.csr_matrix:
        """``T^T m T``."""
        return self._carried(self.fine.mass)

    @cached_property
    def rotary_mass(self) -> sp.csr_matrix:
        """The share of it that the rotation of sections and point masses has."""
        return self._carried(self.fine.rotary_mass)

    @cached_property
    def gyroscopic(self) -> sp.csr_matrix:
        """``T^T s T``."""
        return self._carried(self.fine.gyroscopic)

    def _carried(self, matrix: sp.csr_matrix) -> sp.csr_matrix:
        return (self.fine_shape.T @ matrix @ self.fine_shape).tocsr()

    @cached_property
    def place(self) -> Index:
        """Coordinate of each nodal dof, -1 for those that are none."""
        place = np.full(self.shape.shape[0], -1)
        place[self.kept] = np.arange(len(self.kept))
        return place

    @cached_property
    def of_elements(self) -> tuple[Index, Array]:
        """Coordinates that move each element, ``(elements, n)``, and its nodal dofs by them, ``(elements, 6, n)``."""
        return self.moving(element_dofs(self.mesh))

    def moving(self, groups: Index) -> tuple[Index, Array]:
        """Coordinates that move each group of nodal dofs, ``(groups, n)``, and the dofs by them, ``(groups, dofs, n)``.

        Those of a group with fewer are filled up with its first, by which then nothing moves.

        Parameters
        ----------
        groups
            Nodal dofs of each group, ``(groups, dofs)``.
        """
        parts = [self.shape[dofs].tocsc() for dofs in groups]
        moving = [np.flatnonzero(np.diff(part.indptr)) for part in parts]
        most = max(map(len, moving))
        shape = np.zeros((*groups.shape, most))
        for block, part, mine in zip(shape, parts, moving):
            block[:, : len(mine)] = part[:, mine].toarray()
        return np.array([np.append(mine, np.full(most - len(mine), mine[0])) for mine in moving]), shape

    def pairs(self, rows: Index, columns: Index) -> tuple[Index, Index, sp.csr_matrix]:
        """Say what entries of a matrix over the nodal dofs add to which entries over the coordinates.

        Parameters
        ----------
        rows, columns
            Nodal dofs of each entry, ``(entries,)``.

        Returns
        -------
        tuple
            Rows and columns over the coordinates, and the share that each of the entries has in each of those,
            ``(entries, pairs)``.
        """
        size = self.shape.shape[1]
        left, right = self.shape[rows].tocoo(), self.shape[columns]
        count = np.diff(right.indptr)[left.row]  # nonzeros of the column's dof, beside each of the row's
        entry = np.repeat(left.row, count)
        within = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        other = right.indptr[entry] + within
        values = np.repeat(left.data, count) * right.data[other]
        place = np.repeat(left.col.astype(np.int64), count) * size + right.indices[other]
        pairs, which = np.unique(place, return_inverse=True)
        weights = sp.csr_matrix((values, (entry, which)), shape=(len(rows), len(pairs)))
        return pairs // size, pairs % size, weights


def _without(height: int, spans: Sequence[Span]) -> Index:
    """Nodal dofs that are not inside spans."""
    return np.setdiff1d(np.arange(height), np.concatenate([[-1], *(span.inner.ravel() for span in spans)]))


def _placed(block: Array, rows: Index, columns: Index, shape: tuple[int, int]) -> sp.csr_matrix:
    """Put a dense block into an empty matrix."""
    r, c = np.meshgrid(rows, columns, indexing="ij")
    return sp.csr_matrix((block.ravel(), (r.ravel(), c.ravel())), shape=shape)


def _stiffness(beams: Beams, spans: Sequence[Span], kept: Index) -> sp.csr_matrix:
    """Stiffness over the nodal dofs that are kept: of the elements of members that are not reduced, and of spans."""
    mesh = beams.mesh
    whole = outside(mesh, spans)
    turn = member_rotation(mesh)[whole]
    blocks = [
        turn.transpose(0, 2, 1) @ beams.element_stiffness[whole] @ turn,
        *(span.stiffness[None] for span in spans),
    ]
    dofs = np.searchsorted(kept, np.concatenate([element_dofs(mesh)[whole], *(span.ends[None] for span in spans)]))
    rows, columns = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
    values = np.concatenate(blocks).ravel()
    return sp.csr_matrix((values, (rows.ravel(), columns.ravel())), shape=(len(kept), len(kept)))


def _along(spans: Sequence[Span], on_seen: Sequence[Span], height: int) -> sp.csr_matrix:
    """Nodal dofs as one inner node that is seen after the other moves along its member, ``(nodal dofs, nodes)``."""
    parts = [sp.csr_matrix((height, 0))]
    for span, coarse in zip(spans, on_seen):
        moved = span.along(np.cumsum(coarse.chain.length)[:-1])
        parts.append(_placed(moved.T, span.inner.ravel(), np.arange(len(moved)), (height, len(moved))))
    found = sp.hstack(parts, format="csr")
    found.eliminate_zeros()
    return found


def _axial_stiffness(seen: Beams, spans: Sequence[Span]) -> sp.csr_matrix:
    """Stiffness of the elements that are seen, over the displacements of the spans' inner nodes along the axis."""
    rigidity = seen.rigidity.axial.mean / seen.mesh.cell_length
    parts = [sp.csr_matrix((0, 0))]
    for span in spans:
        count = len(span.cells)
        longer = sp.eye(count, count - 1) - sp.eye(count, count - 1, -1)
        parts.append(longer.T @ sp.diags(rigidity[span.cells]) @ longer)
    return sp.block_diag(parts, format="csr")
