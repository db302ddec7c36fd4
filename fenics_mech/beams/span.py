"""A member between its ends: the shape that statics gives it, and its modes with both ends clamped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index
from fenics_mech._petsc import PETSc, SLEPc, configured, name_of, to_petsc
from fenics_mech.beams.chain import Chain
from fenics_mech.beams.element_dofs import member_rotation
from fenics_mech.beams.element_matrices import Beams
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.errors import SolverError


@dataclass(frozen=True)
class ReductionLimits:
    """Limits of the reduction of members to their ends and lowest modes."""

    small: int = 60  # inner dofs of a member, up to which all its modes are found at once
    tolerance: float = 1e-12  # of the modes, relative
    cutoff: float = 20.0  # over the lowest frequency; measured on the seed: strains to 4e-5, 10 to 2e-4, 5 to 2e-3
    recovered: int = 10  # elements of a member on which strains are recovered: 5e-6 of them off those on 64
    recovered_stiffened: int = 32  # the same, where given axial forces act on the bent axis: they are as good as these


REDUCTION = ReductionLimits()


def outside(mesh: BeamMesh, spans: Sequence[Span]) -> NDArray[np.bool_]:
    """Which elements are of no span, ``(elements,)``.

    Parameters
    ----------
    mesh
        The mesh.
    spans
        Some of its members.
    """
    return ~np.isin(mesh.cell_member, [span.member for span in spans])


@dataclass(frozen=True, eq=False)
class Span:
    """A member between its ends.

    Parameters
    ----------
    member
        Its index.
    cells
        Its elements, from its first end to its last.
    ends, inner
        Nodal dofs of both ends, ``(6,)``, and of the nodes between, ``(elements - 1, 3)``.
    rotation
        Turns three dofs of a node from link axes into the member's, ``(3, 3)``.
    chain
        Its elements.
    mass
        Mass matrix of the inner dofs in member axes.
    """

    member: int
    cells: Index
    ends: Index
    inner: Index
    rotation: Array
    chain: Chain
    mass: sp.csr_matrix

    @classmethod
    def of(cls, beams: Beams, nodal_mass: sp.csr_matrix, member: int) -> Span:
        """Take a member of the links, whose mass matrix over the nodal dofs is given.

        Parameters
        ----------
        beams
            The links' matrices.
        nodal_mass
            Mass matrix over the nodal dofs (kg ...).
        member
            Index of the member in the mesh.
        """
        cells = np.flatnonzero(beams.mesh.cell_member == member)
        nodes = np.append(beams.mesh.cell_nodes[cells, 0], beams.mesh.cell_nodes[cells[-1], 1])
        dofs = 3 * nodes[:, None] + np.arange(3)
        chain = Chain.of(beams.mesh.cell_length[cells], beams.element_stiffness[cells])
        rotation = member_rotation(beams.mesh)[cells[0], :3, :3]
        turn = sp.kron(sp.identity(len(cells) - 1), rotation)
        inner = dofs[1:-1].ravel()
        mass = (turn @ nodal_mass[inner][:, inner] @ turn.T).tocsr()
        return cls(member, cells, dofs[[0, -1]].ravel(), dofs[1:-1], rotation, chain, mass)

    @cached_property
    def stiffness(self) -> Array:
        """Forces on the ends by their displacements, in link axes, ``(6, 6)``."""
        turn = np.kron(np.eye(2), self.rotation)
        return turn.T @ self.chain.stiffness @ turn

    def carried(self) -> Array:
        """Displacements of the inner dofs by those of the ends, in link axes, ``(inner dofs, 6)``."""
        moved = self.chain.carried(np.kron(np.eye(2), self.rotation).T.astype(np.float64))[0]
        return (moved @ self.rotation).reshape(6, -1).T

    @property
    def lowest(self) -> float:
        """Lowest frequency with clamped ends (rad/s)."""
        return float(np.sqrt(self._lowest(1)[0].min(initial=np.inf)))

    def along(self, places: Array) -> Array:
        """Displacements of the inner dofs in link axes as one place after the other moves along the axis by 1.

        Parameters
        ----------
        places
            Distances from the first end (m), ascending.

        Returns
        -------
        numpy.ndarray
            Linear between the places and the ends, which are held, ``(places, inner dofs)``.
        """
        ends = np.cumsum(self.chain.length)
        held = np.concatenate([[0.0], places, ends[-1:]])
        shares = np.array([np.interp(ends[:-1], held, unit) for unit in np.eye(len(held))[1:-1]])
        return (shares[..., None] * self.rotation[0]).reshape(len(places), -1)

    def modes(self, cutoff: float, bending: bool = False) -> tuple[Array, Array]:
        """Modes with clamped ends, up to a frequency (rad/s): all, or those across the axis.

        Parameters
        ----------
        cutoff
            Largest angular frequency (rad/s).
        bending
            Whether only modes across the axis are asked for.

        Returns
        -------
        tuple
            Frequencies (rad/s), ascending, and displacements of the inner dofs in link axes, of the size 1 where they
            are largest, ``(modes, inner dofs)``.

        Raises
        ------
        SolverError
            When SLEPc does not converge.
        """
        count, size = min(6, self.inner.size), self.inner.size
        while True:
            squares, shapes = self._lowest(count)
            inside = squares <= cutoff**2
            if not inside.all() or len(squares) < count or count == size:
                break
            count = min(2 * count, size)
        squares, shapes = squares[inside], shapes[inside].reshape(-1, *self.inner.shape)
        unit = np.array([1.0, 1.0, self.chain.length.mean()])  # of rotations, beside those of displacements
        if bending:
            largest = np.abs(shapes * unit).max(axis=1)
            bent = largest[:, 0] < largest[:, 1:].max(axis=1)
            squares, shapes = squares[bent], shapes[bent]
        shapes = np.array([shape / max((shape * unit).flat, key=abs) for shape in shapes]).reshape(shapes.shape)
        return np.sqrt(squares), (shapes @ self.rotation).reshape(-1, self.inner.size)

    def _lowest(self, count: int) -> tuple[Array, Array]:
        """Give squares of frequencies, ascending, and shapes in member axes, ``(modes, inner dofs)``.

        The eigenproblem is ``m G m x = m x/omega^2`` with the compliance G of the clamped member, which statics gives.
        """
        size = len(self._heavy)
        count = min(count, size)
        if not count:
            return np.zeros(0), np.zeros((0, self.inner.size))
        dense = size <= REDUCTION.small
        mass, operator = to_petsc(self._scaled_mass), PETSc.Mat()
        if dense:
            flexible = self._operated(np.eye(size))
            operator.createDense((size, size), array=(flexible + flexible.T) / 2, comm=PETSc.COMM_SELF)
            operator.assemble()
        else:
            operator.createPython((size, size), context=self, comm=PETSc.COMM_SELF).setUp()
        eps = SLEPc.EPS().create(comm=PETSc.COMM_SELF)
        eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
        eps.setDimensions(count)
        eps.setTolerances(REDUCTION.tolerance, 1000)
        eps.setOperators(operator, mass)
        vector = mass.createVecRight()
        with configured(eps, "links_", {"eps_type": "lapack" if dense else "krylovschur"}, {}):
            eps.setInitialSpace([_steady_start(vector)])
            eps.solve()
            if eps.getConverged() < count:
                reason = name_of(SLEPc.EPS.ConvergedReason, eps.getConvergedReason())
                raise SolverError(f"{eps.getConverged()} of {count} modes of a member converged (SLEPc says {reason})")
            values, found = np.empty(count), np.empty((count, size))
            for i in range(count):
                values[i] = eps.getEigenpair(i, vector).real
                found[i] = vector.array_r
        for thing in (mass, operator, vector):
            thing.destroy()
        known = values > 0  # the fastest, of very short elements, are lost to rounding
        return 1 / values[known], self._bent(found[known]) / values[known, None]

    @cached_property
    def _heavy(self) -> Index:
        """Inner dofs that have a mass: with lumped masses rotations have none."""
        return np.flatnonzero(self.mass.diagonal() > 0)

    @cached_property
    def _scale(self) -> Array:
        """Unit of each of those, in which its mass is 1."""
        return np.asarray(1 / np.sqrt(self.mass.diagonal()[self._heavy]))

    @cached_property
    def _scaled_mass(self) -> sp.csr_matrix:
        unit = sp.diags(self._scale)
        return (unit @ self.mass[self._heavy][:, self._heavy] @ unit).tocsr()

    def _bent(self, shapes: Array) -> Array:
        """Displacements ``G m x`` of the inner dofs, ``(vectors, inner dofs)``, of x in those units."""
        loads = (shapes * self._scale) @ self.mass[self._heavy]
        return self.chain.clamped(loads.reshape(-1, *self.inner.shape))[0].reshape(loads.shape)

    def _operated(self, shapes: Array) -> Array:
        """Give ``m G m x``, both ``(vectors, heavy dofs)`` in those units."""
        return np.asarray((self._bent(shapes) @ self.mass)[:, self._heavy] * self._scale)

    def mult(self, matrix: PETSc.Mat, x: PETSc.Vec, y: PETSc.Vec) -> None:
        """Multiply by ``m G m``, for PETSc.

        Parameters
        ----------
        matrix
            The shell matrix that PETSc calls this for.
        x, y
            The vector, and the one that the product is written into.
        """
        y.array[:] = self._operated(x.array_r[None])[0]


def _steady_start(vector: PETSc.Vec) -> PETSc.Vec:
    """Give the same first vector in every run."""
    start = vector.duplicate()
    start.array[:] = np.random.default_rng(0).normal(size=vector.size)
    return start
