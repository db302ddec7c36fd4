"""The mechanism at some positions: P(theta) joins its links, ``M = P^T m P`` (4.47), ``K = P^T k P`` (4.48)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import SuperLU, splu

from fenics_mech._arrays import Array, Index
from fenics_mech._petsc import PETSc, to_petsc
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.classical.bodies import Bodies
from fenics_mech.classical.joints import JointRows, own_coordinates, turns
from fenics_mech.errors import AssemblyError
from fenics_mech.kinematics import Motion as LinkMotion
from fenics_mech.machine import Pattern
from fenics_mech.machine.from_scene import SceneMachine

IMAGINARY = 1e-30  # step of derivatives by complex numbers, which lose no digits
LOOKED_AT = 120  # positions at which coordinates are chosen: cranks turn by few degrees between them
PIVOT = 1e-6  # of a column of the joints' rows: what is left of it at its worst position, to be solved for


@dataclass(frozen=True)
class Transformation:
    """P(theta): nodal dofs in link axes by the coordinates q."""

    # These are nodal dofs in link axes, displacements X, Y of pins in the fixed frame, and slides in guides: what is
    # left when the joints' rows are solved for as many unknowns.

    made: SceneMachine  # the machine of a scene; its chart is the rigid motion
    t: Array  # instants of the positions (s)
    dependent: Index  # unknowns of the joints that are solved for, and the others
    independent: Index
    block: Array  # the first by the second (4.41), and its derivative by time, (positions, dependent, independent)
    rate: Array
    motion: LinkMotion  # the rigid motion of the links

    @classmethod
    def of(cls, made: SceneMachine, t: Array, like: Transformation | None = None) -> Transformation:
        """Solve the rows of the joints."""
        chart = made.machine.chart
        assert isinstance(chart, Bodies)
        links, scene, mesh = chart.links(t), made.scene, _mesh(made)
        pose, rate = (
            np.concatenate([place, angle[..., None]], axis=2)
            for place, angle in ((links.position, links.angle), (links.velocity, links.omega))
        )
        columns, rows = JointRows(scene, mesh, pose + 1j * IMAGINARY * rate).whole()
        dependent = _chosen(mesh, columns, rows[:: 1 + len(t) // LOOKED_AT].real) if like is None else like.dependent
        independent = np.setdiff1d(columns, dependent)
        solved, others = (rows[..., np.searchsorted(columns, part)] for part in (dependent, independent))
        block = -np.linalg.solve(solved, others)
        return cls(made, t, dependent, independent, block.real, block.imag / IMAGINARY, links)

    def part(self, which: slice) -> Transformation:
        """Give it at some of the positions."""
        arrays = {name: getattr(self, name)[which] for name in ("t", "block", "rate")}
        return replace(self, motion=self.motion.part(which), **arrays)

    @property
    def nodal(self) -> int:
        """Number of nodal dofs."""
        return 3 * len(_mesh(self.made).node_name)

    @cached_property
    def kept(self) -> Index:
        """The unknowns that are coordinates, of nodal dofs and the joints' own."""
        return np.setdiff1d(np.arange(self.nodal + len(own_coordinates(self.made.scene))), self.dependent)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates: "link.node.x" in link axes, "joint.X" in the fixed frame, "joint.slide"."""
        nodes = [f"{name}.{part}" for name in _mesh(self.made).node_name for part in ("x", "y", "rotation")]
        names = nodes + own_coordinates(self.made.scene)
        return tuple(names[i] for i in self.kept)

    @cached_property
    def places(self) -> tuple[Index, Index, Index, Index]:
        """Nodal dofs that are coordinates and their numbers; those that are not, and coordinates that give them."""
        own, solved = self.kept < self.nodal, self.dependent < self.nodal
        return self.kept[own], np.flatnonzero(own), np.flatnonzero(solved), np.searchsorted(self.kept, self.independent)

    def to_nodes(self, q: Array) -> Array:
        """Give nodal dofs of coordinates, ``(positions, ..., nodal dofs)``."""
        own, numbers, solved, by = self.places
        found = np.zeros((*q.shape[:-1], self.nodal))
        found[..., own] = q[..., numbers]
        found[..., self.dependent[solved]] = np.einsum("kij,k...j->k...i", self.block[:, solved], q[..., by])
        return found

    def turning(self, q: Array) -> Array:
        """Give the rates of nodal dofs as the links turn, and coordinates do not change, ``P' q``."""
        _, _, solved, by = self.places
        found = np.zeros((*q.shape[:-1], self.nodal))
        found[..., self.dependent[solved]] = np.einsum("kij,k...j->k...i", self.rate[:, solved], q[..., by])
        return found

    def on_coordinates(self, forces: Array) -> Array:
        """Give forces on coordinates, by those on nodal dofs, ``P^T f``, ``(positions, coordinates)``."""
        own, numbers, solved, by = self.places
        found = np.zeros((len(forces), len(self.kept)))
        found[:, numbers] = forces[:, own]
        found[:, by] += np.einsum("kij,ki->kj", self.block[:, solved], forces[:, self.dependent[solved]])
        return found

    # ---- nodal dofs and coordinates of the machine, which are in the fixed frame ----
    @cached_property
    def _of_machine(self) -> Index:
        """The nodal dof that each coordinate of the machine is ``(coordinates,)``."""
        mesh, places = _mesh(self.made), self.made.machine.places
        rigid = {self.made.node_pose[node] for node, name in enumerate(mesh.node_name) if name.endswith(".centre")}
        found = np.full(self.made.machine.n, -1)
        for node, (name, pose) in enumerate(zip(mesh.node_name, self.made.node_pose)):
            if name.endswith(".centre") or pose not in rigid:
                there = places[pose] >= 0
                found[places[pose][there]] = 3 * node + np.flatnonzero(there)
        return found

    def in_fixed_axes(self, nodal: Array) -> Array:
        """Turn nodal dofs, or forces on them, from the axes of the links, ``(positions, nodes, 3)``."""
        return self._turned(nodal, self.motion.angle).reshape(len(nodal), -1, 3)

    def _turned(self, nodal: Array, angle: Array) -> Array:
        """Turn nodal dofs by the angles of their links, ``(positions, nodal dofs)``."""
        found = nodal.reshape(len(nodal), -1, 3).copy()
        found[..., :2] = (turns(angle[:, _mesh(self.made).node_link]) @ found[..., :2, None])[..., 0]
        return found.reshape(nodal.shape)

    def to_machine(self, nodal: Array) -> Array:
        """Give coordinates of the machine, or their accelerations, by nodal dofs, ``(positions, size)``."""
        return self.of_nodes(self.in_fixed_axes(nodal))

    def of_nodes(self, values: Array) -> Array:
        """Give coordinates of the machine by those of all nodes in the fixed frame ``(positions, nodes, 3)``."""
        found = values.reshape(len(values), -1)[:, self._of_machine]
        return np.pad(found, ((0, 0), (0, self.made.machine.size - found.shape[1])))

    def from_machine(self, forces: Array) -> Array:
        """Give forces on coordinates by those on coordinates of the machine, ``(positions, coordinates)``."""
        nodal = np.zeros((len(forces), self.nodal))
        nodal[:, self._of_machine] = forces[:, : self.made.machine.n]
        return self.on_coordinates(self._turned(nodal, -self.motion.angle))

    @cached_property
    def acceleration(self) -> Array:
        """Acceleration of the rigid motion less gravity's, in link axes (4.17), ``(positions, nodal dofs)``."""
        motion, mesh = self.motion, _mesh(self.made)
        link, (x, y) = mesh.node_link, mesh.node_xy.T
        origin = motion.acceleration[:, link] - np.array(self.made.scene.gravity)
        origin = (turns(-motion.angle[:, link]) @ origin[..., None])[..., 0]
        omega, alpha = motion.omega[:, link], motion.alpha[:, link]
        along = origin[..., 0] - alpha * y - omega**2 * x
        across = origin[..., 1] + alpha * x - omega**2 * y
        return np.stack([along, across, alpha], axis=-1).reshape(len(alpha), -1)

    @cached_property
    def load(self) -> Array:
        """Inertia of the rigid motion ``-P^T m a`` (4.66), and loads, ``(positions, coordinates)``."""
        links = self.made.links
        assert links is not None
        found = -self.on_coordinates((links.mass @ self.acceleration.T).T)
        if not self.made.scene.loads:
            return found
        zero = np.zeros((len(self.t), self.made.machine.size))
        loads = self.made.machine.residual(self.t, zero, zero, zero, moving=False, heavy=False, tangents=False)
        return found - self.from_machine(loads.force)


def _mesh(made: SceneMachine) -> BeamMesh:
    assert made.links is not None
    return made.links.mesh


def _chosen(mesh: BeamMesh, columns: Index, rows: Array) -> Index:
    """Choose the unknowns to solve for: beams' places, then their rotations, joints' own, rigid links."""
    rigid = np.repeat([name.endswith(".centre") for name in mesh.node_name], 3)
    of_nodes = np.where(rigid, 3, np.tile([0, 0, 1], len(mesh.node_name)))
    turn = np.append(of_nodes, np.full(max(0, columns.max() + 1 - len(rigid)), 2))[columns]
    left, dependent = rows / np.maximum(np.abs(rows).max(axis=(0, 1)), 1e-300), []
    for column in np.argsort(turn, kind="stable"):
        size = np.linalg.norm(left[..., column], axis=1)
        if size.min() > PIVOT:
            unit = left[..., column] / size[:, None]
            left = left - unit[..., None] * (unit[:, None, :] @ left)
            dependent.append(columns[column])
    if len(dependent) < rows.shape[1]:
        raise AssemblyError("the joints hold the links more than once, or rigid links are in line at some position")
    return np.array(dependent)


@dataclass(frozen=True)
class Stack:
    """Symmetric matrices of one pattern, one at each position."""

    pattern: Pattern
    values: Array  # (positions, entries)

    def __getitem__(self, positions: slice) -> Stack:
        """Give the matrices at some of the positions."""
        return Stack(self.pattern, self.values[positions])

    def at(self, position: int) -> sp.csr_matrix:
        """Give the matrix at one position."""
        return self.pattern.matrix(self.values[position])

    def times(self, vectors: Array) -> Array:
        """Give the products with vectors, ``(positions, ..., size)``."""
        return np.array([(self.at(k) @ of_one.T).T for k, of_one in enumerate(vectors)])

    def solve(self, right: Array) -> Array:
        """Solve for right-hand sides ``(positions, size)``."""
        return np.array([_factors(self.at(k)).solve(of_one) for k, of_one in enumerate(right)])


def _factors(matrix: sp.csr_matrix) -> SuperLU:
    return splu(matrix.tocsc(), "MMD_AT_PLUS_A", 0.0, options={"SymmetricMode": True})


@dataclass(frozen=True)
class Mechanism:
    """The mechanism at some positions."""

    P: Transformation  # what joins its links
    mass: Stack  # M (4.47) and K (4.48) at all positions
    stiffness: Stack

    @classmethod
    def of(cls, P: Transformation) -> Mechanism:
        """Give M and K by PETSc's ``P^T A P`` of the links' matrices m and k at every position."""
        links = P.made.links
        assert links is not None
        return cls(P, *(_joined(P, matrix) for matrix in (links.mass, links.stiffness)))

    def part(self, which: slice) -> Mechanism:
        """Give it at some of the positions."""
        return Mechanism(self.P.part(which), self.mass[which], self.stiffness[which])

    def slower(self, k: int, omega: float) -> int:
        """Count the modes at a position below a frequency (rad/s), by negative pivots: Sylvester's law of inertia."""
        return int((_factors(self.stiffness.at(k) - omega**2 * self.mass.at(k)).U.diagonal() < 0).sum())

    def strain_by_turning(self, shapes: Array, displacements: Array) -> Array:
        """Give the work of stress in shapes on strain rates of turning ``(positions, shapes, displacements)``."""
        # shapes, displacements (positions, ..., coordinates)
        # That is shapes^T P^T k P' displacements.
        links = self.P.made.links
        assert links is not None
        stress = self.P.to_nodes(shapes)
        stress = (links.stiffness @ stress.reshape(-1, stress.shape[-1]).T).T.reshape(stress.shape)
        return np.asarray(stress @ self.P.turning(displacements).transpose(0, 2, 1))


def _joined(P: Transformation, matrix: sp.csr_matrix) -> Stack:
    """Give ``P^T A P`` at all positions."""
    own, numbers, solved, by = P.places
    at = np.meshgrid(P.dependent[solved], by, indexing="ij")
    rows, columns = (np.append(one, part.ravel()) for one, part in zip((own, numbers), at))
    order = np.lexsort((columns, rows))
    csr = (np.searchsorted(rows[order], np.arange(P.nodal + 1)), columns[order])
    pattern = [part.astype(PETSc.IntType) for part in csr]
    given, found, values = to_petsc(matrix), None, []
    joined = PETSc.Mat().createAIJ((P.nodal, len(P.kept)), csr=(*pattern, np.zeros(len(rows))), comm=PETSc.COMM_SELF)
    for block in P.block[:, solved]:
        joined.setValuesCSR(*pattern, np.append(np.ones(len(own)), block.ravel())[order])
        joined.assemble()
        found = given.ptap(joined, result=found)
        values.append(found.getValuesCSR()[2])
    assert found is not None
    pattern_found = Pattern(len(P.kept), *(part.copy() for part in found.getValuesCSR()[:2]))
    for thing in (given, joined, found):
        thing.destroy()  # Python by itself does not
    return Stack(pattern_found, np.array(values))
