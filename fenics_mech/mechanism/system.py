"""System matrices and load of the mechanism at every drive angle (4.47)-(4.66)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from petsc4py import PETSc

from fenics_mech._petsc import to_scipy
from fenics_mech.beams import Beams
from fenics_mech.beams.attachment import GROUND, Attachment
from fenics_mech.kinematics import Motion
from fenics_mech.mechanism.transformation import Transformation, build_transformation
from fenics_mech.scene import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True)
class System:
    """The equation of motion (4.66) at a set of drive angles.

    Parameters
    ----------
    beams
        Matrices of the links in their own axes.
    motion
        Rigid-body motion at the drive angles.
    transformation
        P(theta).
    applied
        Forces and moments on the nodal dofs from outside, in link axes, ``(angles, nodal dofs)``.
    """

    beams: Beams
    motion: Motion
    transformation: Transformation
    applied: Array

    @property
    def size(self) -> int:
        """Number of coordinates q."""
        return self.transformation.shape[1]

    @cached_property
    def values(self) -> Array:
        """Nonzeros of P at all angles, ``(angles, nonzeros)``."""
        return self.transformation.values(self.motion)

    @cached_property
    def link_mass(self) -> sp.csr_matrix:
        """Mass matrix m of all links in link axes, for products with many vectors at once."""
        return to_scipy(self.beams.mass)

    @cached_property
    def link_stiffness(self) -> sp.csr_matrix:
        """Stiffness matrix k of all links in link axes."""
        return to_scipy(self.beams.stiffness)

    @cached_property
    def rigid_acceleration(self) -> Array:
        """Acceleration of the rigid motion in nodal dofs and link axes, ``(angles, nodal dofs)``; eq. (4.17)."""
        mesh, motion = self.beams.mesh, self.motion
        phi, omega, alpha = (array[:, mesh.node_link] for array in (motion.angle, motion.omega, motion.alpha))
        origin = motion.acceleration[:, mesh.node_link]
        c, s, (x, y) = np.cos(phi), np.sin(phi), mesh.node_xy.T
        along_x = c * origin[..., 0] + s * origin[..., 1] - alpha * y - omega**2 * x
        along_y = c * origin[..., 1] - s * origin[..., 0] + alpha * x - omega**2 * y
        return np.stack([along_x, along_y, alpha], axis=-1).reshape(len(phi), -1)

    @cached_property
    def load(self) -> Array:
        """Loads and inertia of the rigid motion, the right-hand side of (5.1), ``(angles, coordinates)``."""
        inertia = (self.link_mass @ self.rigid_acceleration.T).T
        return self.transformation.backward(self.values, self.applied - inertia)

    def to_links(self, q: Array) -> Array:
        """Nodal dofs in link axes of coordinates at all angles (4.41), ``(angles, nodal dofs)``."""
        return self.transformation.forward(self.values, q)

    def mass_times(self, vectors: Array, shift: int = 0) -> Array:
        """``M vectors`` at all angles, M being that of the angle `shift` further on.

        Parameters
        ----------
        vectors
            Coordinates, ``(angles, vectors, coordinates)``.
        shift
            How many angles further on M is taken; after the last angle comes the first.
        """
        values = np.roll(self.values, -shift, axis=0)[:, None]
        nodal = self.transformation.forward(values, vectors)
        momenta = (self.link_mass @ nodal.reshape(-1, nodal.shape[-1]).T).T
        return self.transformation.backward(values, momenta.reshape(nodal.shape))

    def positions(self) -> Iterator[tuple[int, PETSc.Mat, PETSc.Mat]]:
        """Walk over the angles: yields index, M (4.57) and K (4.58).

        The two PETSc matrices are used again at the next angle: copy what has to last.
        """
        p = _csr(self.transformation, self.values[0])
        pointers, columns, _ = p.getValuesCSR()
        mass, stiffness = (matrix.PtAP(p) for matrix in (self.beams.mass, self.beams.stiffness))
        for k, values in enumerate(self.values):
            if k:
                p.setValuesCSR(pointers, columns, values)
                p.assemble()
                self.beams.mass.PtAP(p, result=mass)  # (4.47)
                self.beams.stiffness.PtAP(p, result=stiffness)  # (4.48)
            yield k, mass, stiffness
        for matrix in (p, mass, stiffness):
            matrix.destroy()

    def coupling(self, k: int) -> dict[str, PETSc.Mat]:
        """Matrices that couple rigid and elastic motion at angle number `k`, which (5.1) leaves out.

        Returns
        -------
        dict
            "Md", "Mv", "Mdd", "Mdv" and "Ma" of (4.59)-(4.63), as new PETSc matrices.
        """
        p = _csr(self.transformation, self.values[k])
        here = self.motion.part(slice(k, k + 1))
        rate, second = (_csr(self.transformation, d[0]) for d in self.transformation.derivatives(here))
        m = self.beams.mass
        link_of_row = np.repeat(self.beams.mesh.node_link, 3)
        omega, alpha = (array[k, link_of_row] for array in (self.motion.omega, self.motion.alpha))
        m_v = _scaled(self.beams.gyroscopic, omega)  # (4.29)
        m_a = _scaled(self.beams.gyroscopic, alpha)  # (4.30)
        m_a.axpy(-1.0, _scaled(m, omega**2), PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        return {
            "Md": p.transposeMatMult(m.matMult(rate)),  # (4.52)
            "Mv": p.transposeMatMult(m_v.matMult(p)),  # (4.53)
            "Mdd": p.transposeMatMult(m.matMult(second)),  # (4.49)
            "Mdv": p.transposeMatMult(m_v.matMult(rate)),  # (4.50)
            "Ma": p.transposeMatMult(m_a.matMult(p)),  # (4.51)
        }


def build_system(scene: Scene, beams: Beams, motion: Motion) -> System:
    """Join the links of a scene to a mechanism that moves as given.

    Raises
    ------
    AssemblyError
        When the joints' equations cannot be solved at some angle.
    """
    transformation = build_transformation(scene, beams.mesh, motion)
    return System(beams, motion, transformation, applied_forces(scene, beams, motion))


def applied_forces(scene: Scene, beams: Beams, motion: Motion) -> Array:
    """Loads of a scene on the nodal dofs in link axes, ``(angles, nodal dofs)``, {Qex} of (4.39)."""
    forces = np.zeros((len(motion.theta), 3 * len(beams.mesh.node_name)))
    for load in scene.loads.values():
        point = Attachment.of(scene, beams.mesh, load.at)
        if point.link == GROUND:
            continue
        angle = motion.angle[:, point.link]
        c, s, (x, y) = np.cos(angle), np.sin(angle), load.force
        in_link = np.stack([c * x + s * y, c * y - s * x], axis=-1)  # transpose of (7.3)
        forces[:, point.dofs] += in_link @ point.shift + load.moment * np.array([0.0, 0.0, 1.0])
    return forces


def _csr(transformation: Transformation, values: Array) -> PETSc.Mat:
    """PETSc matrix of P, or of one of its derivatives, from its nonzeros at one angle."""
    height = transformation.height
    pointers = np.searchsorted(transformation.rows, np.arange(height + 1)).astype(PETSc.IntType)
    csr = (pointers, transformation.columns.astype(PETSc.IntType), values)
    return PETSc.Mat().createAIJ(transformation.shape, csr=csr, comm=PETSc.COMM_SELF)


def _scaled(matrix: PETSc.Mat, rows: Array) -> PETSc.Mat:
    """Copy of a matrix with scaled rows."""
    copy = matrix.copy()
    copy.diagonalScale(PETSc.Vec().createWithArray(np.ascontiguousarray(rows), comm=PETSc.COMM_SELF))
    return copy
