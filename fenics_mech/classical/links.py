"""The links on the broken space, and P(theta) that joins them: ``M = P^T m P`` (4.47), ``K = P^T k P`` (4.48)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fenics_mech import _fenicsx
from fenics_mech._arrays import Array, Index
from fenics_mech._petsc import PETSc, to_petsc, to_scipy
from fenics_mech.beams.forms import axial, bending, mass
from fenics_mech.beams.layout import Layout
from fenics_mech.beams.mesh import BeamMesh, mesh_scene
from fenics_mech.classical.linkage import IMAGINARY, QUARTER, JointRows, Motion, own_coordinates, turns
from fenics_mech.errors import AssemblyError
from fenics_mech.scene import Scene

PIVOT = 1e-6  # of a column of the joints' rows: what is left of it at its worst position, to be solved for


@dataclass(frozen=True)
class Links:
    """The links, each in its own axes. Nodal dofs are x, y and rotation of every node; rigid links have one.

    Parameters
    ----------
    scene
        The scene.
    layout
        The mesh by gmsh, and the broken space by dolfinx with what carries nodal dofs to it.
    mass, stiffness
        m and k over the dofs of the broken space.
    bodies
        Masses of points and rigid links over the nodal dofs, a diagonal matrix.
    axial, bending, density
        EA (N), EI (N m^2) and rho A (kg/m) of every element.
    """

    scene: Scene
    layout: Layout
    mass: PETSc.Mat
    stiffness: PETSc.Mat
    bodies: PETSc.Mat
    axial: Array
    bending: Array
    density: Array

    @classmethod
    def of(cls, scene: Scene) -> Links:
        """Mesh the members of a scene and assemble their matrices.

        Parameters
        ----------
        scene
            The scene.
        """
        mesh = mesh_scene(scene)  # gmsh
        layout = Layout.of(mesh)  # DG1 x DG3
        sections = [section for section in scene.rigidities(np.zeros(1))]
        ea, ei, rho = (
            np.array([float(getattr(section, part)[0]) for section in sections])[mesh.cell_member]
            for part in ("axial", "bending", "line_density")
        )
        space, coefficient = layout.space, layout.coefficient
        stiffness = axial(space, coefficient(ea)) + bending(space, coefficient(ei))  # (4.26), (7.2)
        k, m = map(_fenicsx.assemble_matrix, (stiffness, mass(space, coefficient(rho))))  # (4.28), (7.1)
        bodies = np.zeros((len(mesh.node_name), 3))
        for point in scene.masses.values():
            bodies[mesh.node(point.at)] += point.mass, point.mass, point.inertia
        for name, link in scene.links.items():
            if link.rigid is not None:
                bodies[mesh.node(f"{name}.centre")] += link.rigid.mass, link.rigid.mass, link.rigid.inertia
        diagonal = sp.diags(bodies.ravel(), format="csr")
        return cls(scene, layout, to_petsc(m), to_petsc(k), to_petsc(diagonal), ea, ei, rho)

    @property
    def mesh(self) -> BeamMesh:
        """The mesh."""
        return self.layout.mesh

    def rigid_acceleration(self, motion: Motion) -> Array:
        """Acceleration of the rigid motion less gravity's, in link axes (4.17), ``(positions, nodal dofs)``.

        Parameters
        ----------
        motion
            The rigid motion.
        """
        link, (x, y) = self.mesh.node_link, self.mesh.node_xy.T
        back = turns(-motion.pose[:, link, 2])
        origin = (back @ (motion.second[:, link, :2] - np.array(self.scene.gravity))[..., None])[..., 0]
        omega, alpha = motion.rate[:, link, 2], motion.second[:, link, 2]
        along = origin[..., 0] - alpha * y - omega**2 * x
        across = origin[..., 1] + alpha * x - omega**2 * y
        return np.stack([along, across, alpha], axis=-1).reshape(len(alpha), -1)


@dataclass(frozen=True)
class Transformation:
    """P(theta) at some positions. Its columns are the coordinates q.

    These are nodal dofs in link axes, displacements X, Y of pins in the fixed frame, and slides in guides: what is left
    when the joints' rows are solved for as many unknowns.

    Parameters
    ----------
    links
        The links.
    motion
        The rigid motion at the positions.
    dependent, independent
        Unknowns of the joints that are solved for, and the others; q are all but the dependent ones.
    """

    links: Links
    motion: Motion
    dependent: Index
    independent: Index

    @classmethod
    def of(cls, links: Links, motion: Motion, others: Motion) -> Transformation:
        """Choose the coordinates, the same at all positions.

        Parameters
        ----------
        links
            The links.
        motion
            The rigid motion at the positions.
        others
            That at other positions where the coordinates are to serve, too.

        Raises
        ------
        AssemblyError
            When joints hold the links more than once, or do so at some position.
        """
        rows = _elastic_rows(links, np.concatenate([motion.pose, others.pose]))
        joined = np.flatnonzero(np.abs(rows).max(axis=(0, 1)) > 0)
        rigid = np.repeat([name.endswith(".centre") for name in links.mesh.node_name], 3)
        of_nodes = np.where(rigid, 3, np.tile([0, 0, 1], len(rigid) // 3))
        turn = np.append(of_nodes, np.full(rows.shape[2] - len(rigid), 2))[joined]
        left, dependent = rows[..., joined] / np.abs(rows[..., joined]).max(axis=(0, 1)), []
        for column in np.argsort(turn, kind="stable"):  # beams' places, their rotations, joints' own, rigid links
            size = np.linalg.norm(left[..., column], axis=1)
            if size.min() > PIVOT:
                unit = left[..., column] / size[:, None]
                left = left - unit[..., None] * (unit[:, None, :] @ left)
                dependent.append(joined[column])
        if len(dependent) < rows.shape[1]:
            raise AssemblyError("the joints hold the links more than once, or rigid links are in line at some position")
        return cls(links, motion, np.array(dependent), np.setdiff1d(joined, dependent))

    @cached_property
    def kept(self) -> Index:
        """The unknowns that are coordinates, of nodal dofs and the joints' own."""
        own = len(own_coordinates(self.links.scene)) - len(self.links.scene.drives)
        return np.setdiff1d(np.arange(3 * len(self.links.mesh.node_name) + own), self.dependent)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        nodes = [f"{name}.{part}" for name in self.links.mesh.node_name for part in ("x", "y", "rotation")]
        names = nodes + own_coordinates(self.links.scene)
        return tuple(names[i] for i in self.kept)

    def at(self, motion: Motion) -> Transformation:
        """Give P with the same coordinates at other positions."""
        return Transformation(self.links, motion, self.dependent, self.independent)

    @cached_property
    def nodal(self) -> list[sp.csr_matrix]:
        """Nodal dofs by coordinates (4.41) at each position."""
        rows = _elastic_rows(self.links, self.motion.pose)
        return self._sparse(-np.linalg.solve(rows[..., self.dependent], rows[..., self.independent]), 1.0)

    @cached_property
    def nodal_rate(self) -> list[sp.csr_matrix]:
        """Time derivative of `nodal`."""
        rows = _elastic_rows(self.links, self.motion.pose + 1j * IMAGINARY * self.motion.rate)
        solution = -np.linalg.solve(rows[..., self.dependent], rows[..., self.independent])
        return self._sparse(solution.imag / IMAGINARY, 0.0)

    def _sparse(self, solution: Array, own: float) -> list[sp.csr_matrix]:
        """Matrices whose dependent rows are given, and in which coordinates give themselves by `own`."""
        height = 3 * len(self.links.mesh.node_name)
        nodal = self.dependent < height
        column = np.searchsorted(self.kept, self.independent)
        i, j = (part.ravel() for part in np.meshgrid(self.dependent[nodal], column, indexing="ij"))
        themselves = np.flatnonzero(self.kept < height)
        places = np.append(i, self.kept[themselves]), np.append(j, themselves)
        values = (np.append(part[nodal].ravel(), np.full(len(themselves), own)) for part in solution)
        return [sp.csr_matrix((value, places), shape=(height, len(self.kept))) for value in values]

    def matrices(self) -> Iterator[tuple[PETSc.Mat, PETSc.Mat, sp.csr_matrix]]:
        """Walk over the positions: M (4.47), K (4.48) and P^T k P'."""
        links, embedding = self.links, self.links.layout.embedding
        for nodal, rate in zip(self.nodal, self.nodal_rate):
            p, on_nodes, turning = map(to_petsc, (embedding @ nodal, nodal, embedding @ rate))
            mass, stiffness, bodies = links.mass.ptap(p), links.stiffness.ptap(p), links.bodies.ptap(on_nodes)
            mass.axpy(1.0, bodies)
            k_turning = links.stiffness.matMult(turning)
            strained = p.transposeMatMult(k_turning)
            yield mass, stiffness, to_scipy(strained)
            for matrix in (p, on_nodes, turning, mass, stiffness, bodies, k_turning, strained):
                matrix.destroy()  # Python by itself does not

    def to_nodes(self, q: Array) -> Array:
        """Nodal dofs of coordinates, ``(positions, nodal dofs)``."""
        return np.array([nodal @ each for nodal, each in zip(self.nodal, q)])

    def load(self, acceleration: Array) -> Array:
        """Inertia of the rigid motion ``-P^T m a`` (4.66), ``(positions, coordinates)``."""
        embedding, mass = self.links.layout.embedding, to_scipy(self.links.mass)
        forces = (embedding.T @ (mass @ (embedding @ acceleration.T)) + to_scipy(self.links.bodies) @ acceleration.T).T
        return np.array([-nodal.T @ force for nodal, force in zip(self.nodal, forces)])


def _elastic_rows(links: Links, pose: Array) -> Array:
    """Rows of the joints over nodal dofs and the joints' own coordinates that no drive leads."""
    scene, mesh = links.scene, links.mesh

    def end(point: str) -> tuple[Index, Array]:
        body, at = scene.point(point)
        if body == "ground":
            return np.zeros(0, dtype=np.int64), np.zeros((len(pose), 3, 0))
        rigid = scene.links[body].rigid
        moved = np.tile(np.eye(3, dtype=pose.dtype), (len(pose), 1, 1))
        if rigid is not None:
            moved[:, :2, 2] = QUARTER @ np.subtract(at, rigid.centre)
        moved[:, :2] = turns(pose[:, list(scene.links).index(body), 2]) @ moved[:, :2]
        node = mesh.node(point if rigid is None else f"{body}.centre")
        return 3 * node + np.arange(3), moved

    led = np.zeros((len(pose), len(scene.drives)))
    return JointRows.of(scene, pose, led, end, 3 * len(mesh.node_name))[0][..., : -len(scene.drives)]
