"""System matrices and load of the mechanism at every drive angle (4.47)-(4.66)."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np
import scipy.sparse as sp

from fenics_mech._arrays import Array, Index, summed
from fenics_mech._petsc import PETSc, to_petsc
from fenics_mech._sparse import Congruence, Stack
from fenics_mech.beams.element_dofs import element_dofs, member_rotation
from fenics_mech.beams.element_matrices import Beams
from fenics_mech.effects import NOTHING, Entries, Loads, Terms
from fenics_mech.effects.rotation_forces import RotationForces
from fenics_mech.effects.section_spin import SectionSpin
from fenics_mech.kinematics import Motion
from fenics_mech.mechanism.transformation import Transformation, build_transformation
from fenics_mech.scene import Scene

Made = TypeVar("Made")
KEPT = ("values", "rigid_acceleration")


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
    terms
        What effects add.
    """

    beams: Beams
    motion: Motion
    transformation: Transformation
    terms: Terms = NOTHING

    def once(self, what: str, make: Callable[[], Made], key: Hashable = None) -> Made:
        """Make something from M and K without turning loads, once; where no axial force stiffens, for all rates.

        Parameters
        ----------
        what
            Kind of thing.
        make
            Makes it.
        key
            What else it is made from.
        """
        path, terms = self.motion.path, self.terms
        if path is None:
            return make()
        forces = terms.uneven if terms.stiffening is None else (terms.stiffening, *terms.uneven)
        springs = (part.tobytes() for entries in self.terms.matrices.stiffness for part in vars(entries).values())
        return path.once(what, (self.beams, self.transformation, *forces), make, (key, *springs))

    def with_terms(self, terms: Terms) -> System:
        """Give the same mechanism with other terms, of the same acceleration; what does not depend on them is kept."""
        there = replace(self, terms=terms)
        there.__dict__.update({name: value for name, value in vars(self).items() if name in KEPT})
        return there

    def with_loads(self, loads: Loads) -> System:
        """Give the same mechanism with loads beside its own."""
        return self.with_terms(replace(self.terms, loads=self.terms.loads + loads))

    @property
    def without_axial_forces(self) -> System:
        """The mechanism without axial forces on its bending."""
        return self.with_terms(replace(self.terms, stiffening=None, uneven=()))

    @cached_property
    def applied(self) -> Array:
        """Loads on the nodal dofs in link axes (N, N m), ``(angles, nodal dofs)``."""
        applied = self.applied_by(self.terms.loads)
        return sum((law.nodal for law in self.terms.joint_laws), applied)

    def applied_by(self, loads: Loads) -> Array:
        """Loads on the nodal dofs in link axes that do the work of given loads, ``(angles, nodal dofs)``.

        Parameters
        ----------
        loads
            Loads on nodes, along elements and on their ends.
        """
        applied = np.zeros((len(self.motion.theta), self.transformation.height))
        if loads.force is not None:
            applied += loads.force
        if loads.line is not None:
            applied += self.assembled_from_members(self.beams.layout.work_equivalent(loads.line))
        if loads.ends is not None:
            applied += self.assembled_from_members(loads.ends)
        return applied

    def on_coordinates_by(self, loads: Loads) -> Array:
        """Give what loads put on the coordinates (N, N m), ``(angles, coordinates)``."""
        return self.on_coordinates(self.applied_by(loads))

    @property
    def link_of_dof(self) -> Index:
        """Link of each nodal dof."""
        return np.repeat(self.beams.mesh.node_link, 3)

    @property
    def link_of_coordinate(self) -> Index:
        """Link of each of the links' coordinates."""
        reduction, mesh = self.beams.reduction, self.beams.mesh
        if reduction is None:
            return self.link_of_dof
        return np.append(self.link_of_dof[reduction.kept], mesh.member_link[reduction.mode_member])

    @property
    def size(self) -> int:
        """Number of coordinates q."""
        return self.transformation.shape[1]

    @cached_property
    def values(self) -> Array:
        """Nonzeros of P at all angles, ``(angles, nonzeros)``."""
        return self.transformation.values(self.motion)

    @property
    def link_mass(self) -> sp.csr_matrix:
        """Mass matrix m of all links, over their coordinates."""
        return self.nodal_mass if self.beams.reduction is None else self.beams.reduction.mass

    @property
    def link_rotary_mass(self) -> sp.csr_matrix:
        """Share of m that the rotation of sections and point masses has, which feels no centrifugal force."""
        return self.nodal_rotary_mass if self.beams.reduction is None else self.beams.reduction.rotary_mass

    @property
    def link_stiffness(self) -> sp.csr_matrix:
        """Stiffness matrix k of all links, over their coordinates."""
        return self.nodal_stiffness if self.beams.reduction is None else self.beams.reduction.stiffness

    @property
    def link_gyroscopic(self) -> sp.csr_matrix:
        """Gyroscopic matrix s of all links, over their coordinates."""
        return self.nodal_gyroscopic if self.beams.reduction is None else self.beams.reduction.gyroscopic

    @property
    def nodal_mass(self) -> sp.csr_matrix:
        """Matrix m over the nodal dofs in link axes."""
        return self.beams.mass

    @property
    def nodal_rotary_mass(self) -> sp.csr_matrix:
        """Share of m that rotation has, over the nodal dofs."""
        return self.beams.rotary_mass

    @property
    def nodal_stiffness(self) -> sp.csr_matrix:
        """Matrix k over the nodal dofs."""
        return self.beams.stiffness

    @property
    def nodal_gyroscopic(self) -> sp.csr_matrix:
        """Matrix s over the nodal dofs."""
        return self.beams.gyroscopic

    def on_links(self, entries: Entries) -> Entries:
        """Carry entries over the nodal dofs to the links' coordinates."""
        reduction = self.beams.reduction
        if reduction is None:
            return entries
        rows, columns, weights = reduction.pairs(entries.rows, entries.columns)
        return Entries(rows, columns, np.asarray((weights.T @ entries.values.T).T))

    def on_nodes(self, coordinates: Array) -> Array:
        """Nodal dofs of links' coordinates, both ``(angles, ...)``."""
        reduction = self.beams.reduction
        return coordinates if reduction is None else np.ascontiguousarray((reduction.shape @ coordinates.T).T)

    def on_coordinates(self, forces: Array, values: Array | None = None) -> Array:
        """Forces on the mechanism's coordinates by those on the nodal dofs, ``(angles, ...)``: by P or a rate of it.

        Parameters
        ----------
        forces
            Forces on the nodal dofs in link axes.
        values
            Nonzeros of P or of a time derivative, ``(angles, nonzeros)``; by default those of P.
        """
        reduction = self.beams.reduction
        of_links = forces if reduction is None else (reduction.shape.T @ forces.T).T
        return self.transformation.backward(self.values if values is None else values, of_links)

    @cached_property
    def rigid_acceleration(self) -> Array:
        """Acceleration of the rigid motion in link axes, ``(angles, nodal dofs)``; eq. (4.17).

        Less gravity's, and with the drag per mass on the velocity: both forces go with the mass as inertia does.
        """
        mesh, motion = self.beams.mesh, self.motion
        of_links = np.cos(motion.angle), np.sin(motion.angle), motion.omega, motion.alpha
        c, s, omega, alpha = (np.take(array, mesh.node_link, axis=1) for array in of_links)
        origin, (x, y) = motion.acceleration[:, mesh.node_link], mesh.node_xy.T
        along_x = c * origin[..., 0] + s * origin[..., 1] - alpha * y - omega**2 * x
        along_y = c * origin[..., 1] - s * origin[..., 0] + alpha * x - omega**2 * y
        rigid = np.stack([along_x, along_y, alpha], axis=-1).reshape(len(alpha), -1)
        if self.terms.damping.external:
            rigid += self.terms.damping.external * self.rigid_velocity
        return rigid if self.terms.acceleration is None else rigid + self.terms.acceleration

    @property
    def tangential(self) -> Array:
        """Rate of the links' axes by which v feels a force across it, ``alpha + c omega`` (1/s^2), ``(angles, links)``.

        The first is Euler's; the second is the external drag c on the velocity ``omega x v``.
        """
        return self.motion.alpha + self.terms.damping.external * self.motion.omega

    @cached_property
    def rigid_velocity(self) -> Array:
        """Velocity of the rigid motion in link axes, ``(angles, nodal dofs)``."""
        motion = self.motion
        as_acceleration = replace(
            motion, acceleration=motion.velocity, alpha=motion.omega, omega=np.zeros_like(motion.omega)
        )
        return replace(self, motion=as_acceleration, terms=NOTHING).rigid_acceleration

    @cached_property
    def load(self) -> Array:
        """Loads and inertia of the rigid motion, the right-hand side of (5.1), ``(angles, coordinates)``."""
        inertia = (self.nodal_mass @ self.rigid_acceleration.T).T
        return self.on_coordinates(self.applied - inertia)

    def to_links(self, q: Array) -> Array:
        """Nodal dofs in link axes of coordinates at all angles (4.41), ``(angles, nodal dofs)``.

        Parameters
        ----------
        q
            Coordinates, ``(angles, coordinates)``.
        """
        return self.on_nodes(self.transformation.forward(self.values, q))

    def nodes_at(self, k: int, q: Array) -> Array:
        """Nodal dofs in link axes of coordinates at angle number k, ``(nodes, 3)``."""
        every = np.zeros((len(self.values), self.size))
        every[k] = q
        return self.to_links(every)[k].reshape(-1, 3)

    def bent_most(self, k: int, q: Array) -> str:
        """Link that coordinates at angle number k, ``(coordinates,)``, bend most."""
        turned, of_link = self.nodes_at(k, q)[:, 2], self.beams.mesh.node_link
        return self.motion.links[int(np.argmax([np.ptp(turned[of_link == i]) for i in range(of_link.max() + 1)]))]

    def turned_too_far(self, k: int, axis: str) -> str:
        """Say that an axis has no strains at angle number k."""
        return (
            f"at drive angle {np.degrees(self.motion.theta[k]):.6g} deg the {axis} would turn by 90 degrees or more "
            "from its straight line, where strains end. Lower loads or speed, or take stiffer members"
        )

    def assembled(self, ends: Array) -> Array:
        """Sum forces on the elements' ends ``(angles, elements, 6)`` to nodal forces ``(angles, nodal dofs)``.

        Parameters
        ----------
        ends
            Forces and moments in link axes (N, N m), ``(angles, elements, 6)``.
        """
        return summed(ends.reshape(len(ends), -1), element_dofs(self.beams.mesh).ravel(), self.transformation.height)

    def assembled_from_members(self, ends: Array) -> Array:
        """Sum forces on the elements' ends in the axes of their members, ``(angles, elements, 6)``, to nodal ones."""
        return self.assembled(np.einsum("eji,tej->tei", member_rotation(self.beams.mesh), ends))

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
        moved = self.transformation.forward(values, vectors)
        momenta = (self.link_mass @ moved.reshape(-1, moved.shape[-1]).T).T
        return self.transformation.backward(values, momenta.reshape(moved.shape))

    @cached_property
    def added_stiffness(self) -> tuple[Entries, ...]:
        """Stiffness that effects add to that of the links."""
        convective = self.terms.matrices.convective if self.terms.coupled else ()
        return (*self.symmetric_stiffness, *self.terms.matrices.follower, *convective)

    @cached_property
    def rotation_forces(self) -> RotationForces | None:
        """What acts on rotations beyond its linear parts, by the links' coordinates; None where slopes are small."""
        if self.terms.law is None or not self.terms.rotation_forces:
            return None
        forces, reduction = RotationForces.joined(self.terms.rotation_forces), self.beams.reduction
        return forces if reduction is None else forces.by(*reduction.moving(forces.dofs))

    @property
    def spin(self) -> SectionSpin | None:
        """Inertia of sections beyond linear theory, by the links' coordinates; None where it does not act."""
        return None if self.terms.law is None else self.terms.law.spin

    @cached_property
    def symmetric_stiffness(self) -> tuple[Entries, ...]:
        """Of that, what a potential energy has: springs and geometric stiffness."""
        given = self.terms.axial_stiffness
        of_elements = (Entries.of_elements(self.beams.mesh, np.sum(given, axis=0)),) if given else ()
        return (*self.terms.matrices.stiffness, *of_elements)

    def held_matrices(self, symmetric: bool = True, among: slice = slice(None)) -> tuple[Stack, Stack]:
        """M (4.57) and K (4.58) of the mechanism held at its angles.

        Parameters
        ----------
        symmetric
            Leave out the stiffness of loads that turn with the links and of dampers, as natural modes do.
        among
            The angles.
        """
        added = [self.on_links(part) for part in (self.symmetric_stiffness if symmetric else self.added_stiffness)]
        constant = self.link_mass, self.link_stiffness
        places = [tuple(part.astype(np.int64) for part in matrix.nonzero()) for matrix in constant]
        places += [(entries.rows, entries.columns) for entries in added]
        transformation, p = self.transformation, self.values[among]
        products = Congruence.of(*transformation.shape, transformation.rows, transformation.columns, places)
        m, k = map(products.values_of_matrix, constant)
        for entries in added:
            k = k + products.values_of(entries.rows, entries.columns, entries.part(among).values)
        return products.products(p, (m, p)), products.products(p, (k, p))

    @cached_property
    def held_stiffness(self) -> Stack:
        """K (4.58) of the mechanism held at its angles, with what is not symmetric of it."""
        if len(self.added_stiffness) > len(self.symmetric_stiffness):
            return self.held_matrices(symmetric=False)[1]
        return self.once("held stiffness", lambda: self.held_matrices()[1])

    def positions(
        self, symmetric: bool = False, among: slice = slice(None)
    ) -> Iterator[tuple[int, PETSc.Mat, PETSc.Mat]]:
        """Walk over the angles: yields index, M and K.

        The two PETSc matrices are used again at the next angle: copy what has to last.

        Parameters
        ----------
        symmetric, among
            As of `held_matrices`.
        """
        stacks = self.held_matrices(symmetric, among)
        matrices: list[PETSc.Mat] = []
        for i, k in enumerate(range(len(self.values))[among]):
            if not matrices:
                matrices = [to_petsc(stack.at(i)) for stack in stacks]
                pointers, columns, _ = matrices[0].getValuesCSR()
            for matrix, stack in zip(matrices, stacks):
                matrix.setValuesCSR(pointers, columns, stack.values[i])
                matrix.assemble()
            yield k, *matrices
        for matrix in matrices:
            matrix.destroy()


def build_system(scene: Scene, beams: Beams, motion: Motion, terms: Terms = NOTHING) -> System:
    """Join the links of a scene to a mechanism that moves as given.

    Parameters
    ----------
    scene, beams, motion
        The scene, the matrices of its links and its rigid motion.
    terms
        What effects add.

    Raises
    ------
    AssemblyError
        When the joints' equations cannot be solved at some angle.
    """
    return System(beams, motion, build_transformation(scene, beams, motion), terms)
