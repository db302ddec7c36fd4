"""Stiffness and mass matrices of all links in their own axes: they do not depend on the crank angle."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from operator import add
from typing import Any

import numpy as np
import scipy.sparse as sp

from fenics_mech import _fenicsx
from fenics_mech._arrays import Array, Index, each
from fenics_mech.beams.distributions import Distribution, along_elements
from fenics_mech.beams.element_dofs import in_member_axes
from fenics_mech.beams.forms import axial, bending, bowing, mass, offset_mass, rotary, shear
from fenics_mech.beams.layout import Layout
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.beams.offset_pins import Offsets
from fenics_mech.scene import Link, PointMass, RigidBody, Scene

STRAINED: Index = np.array([3, 2, 5])  # u of the second node, and both rotations: what strains an element held at w
Form = Callable[[Any, Any], Any]  # UFL form of a space and the coefficient of a property


@dataclass(frozen=True)
class ElementRigidity:
    """Stiffness of the sections along the elements."""

    axial: Distribution  # EA (N) and EI (N m^2). The mean of EA is infinite where an element cannot stretch.
    bending: Distribution
    shear: Distribution | None = None  # G A_s (N); None where beams are rigid in shear

    @property
    def varies(self) -> bool:
        """Whether a section varies along elements."""
        return self.bending.varies


@dataclass(frozen=True)
class Inertia:
    """Mass of the sections along the elements, and of bodies at nodes."""

    density: Distribution  # rho A (kg/m)
    bodies: tuple[tuple[int, RigidBody | PointMass], ...] = ()  # point masses and rigid links, by node
    # rho I (kg m); None where the sections' rotation has no inertia. Without the effect 'rotary-inertia' it is that
    # of a mass in the centre of mass, beside the neutral line.
    rotary: Distribution | None = None
    spread: Inertia | None = None  # the same inertia with its mass along the elements, where it stands at their nodes


@dataclass(frozen=True)
class Beams:
    """The links' matrices. Rows and columns are nodal dofs in link axes, 3 per node of `mesh`."""

    # All matrices are assembled when first asked for. Those of elements are in their members' axes, (elements, 6, 6):
    # u, w, phi at both nodes.

    layout: Layout  # the broken space and how nodal dofs span it
    rigidity: ElementRigidity  # stiffness of the sections
    inertia: Inertia  # mass of the sections and of bodies at nodes

    @property
    def mesh(self) -> BeamMesh:
        """The mesh."""
        return self.layout.mesh

    @property
    def mass_moment(self) -> Array | None:
        """Moment rho A e of the mass about the neutral line of each element (kg); None where it is 0 everywhere."""
        offsets = self.layout.offsets
        return self.inertia.density.mean * offsets.mass if offsets is not None and offsets.mass.any() else None

    @cached_property
    def stiffness(self) -> sp.csr_matrix:
        """Matrix k of all links (block-diagonal by link)."""
        return self.layout.nodal(self._broken_stiffness)

    @cached_property
    def mass(self) -> sp.csr_matrix:
        """Matrix m of all links with the point masses."""
        return self._with_bodies(self._broken_mass, lambda body: np.diag([body.mass, body.mass, body.inertia]))

    def _with_bodies(
        self, broken: sp.csr_matrix | None, block: Callable[[RigidBody | PointMass], Array]
    ) -> sp.csr_matrix:
        """Matrix over the nodal dofs of a broken one, with a block of each body on the first dofs of its node."""
        size = 3 * len(self.mesh.node_name)
        matrix = sp.csr_matrix((size, size)) if broken is None else self.layout.nodal(broken)
        blocks = [(3 * node, block(body)) for node, body in self.inertia.bodies]
        places = [(first + i, first + j, value) for first, part in blocks for (i, j), value in np.ndenumerate(part)]
        rows, columns, values = np.array(places).reshape(-1, 3).T
        return matrix + sp.csr_matrix((values, (rows.astype(int), columns.astype(int))), shape=matrix.shape)

    @cached_property
    def element_stiffness(self) -> Array:
        """Matrix k of each element (7.2) in its member's axes, ``(elements, 6, 6)``."""
        return self.layout.of_elements(self._broken_stiffness)

    def elastic_ends(self, nodal: Array) -> Array:
        """Forces on the elements' ends in their members' axes, by what strains each element (7.2)."""
        # nodal (angles, nodal dofs) (m, rad)
        # The matrix k times displacements loses digits where a stiff element moves far as a whole. Here its strain is
        # taken first, and its forces are in balance to the last digit.
        length, v = self.mesh.cell_length, in_member_axes(self.mesh, nodal)
        chord = (v[..., 4] - v[..., 1]) / length
        strained = np.stack([v[..., 3] - v[..., 0], v[..., 2] - chord, v[..., 5] - chord], axis=-1)
        axial, first, last = np.moveaxis(each(self.element_stiffness[:, STRAINED[:, None], STRAINED], strained), -1, 0)
        shear = (first + last) / length
        return np.stack([-axial, shear, first, axial, -shear, last], axis=-1)

    @cached_property
    def element_mass(self) -> Array:
        """Matrix m of each element (7.1) in its member's axes, ``(elements, 6, 6)``."""
        return self.layout.of_elements(self._broken_mass)

    @cached_property
    def element_rotary_mass(self) -> Array:
        """Share of m of each element that the rotation of its sections has, ``(elements, 6, 6)``."""
        if self._broken_rotary is None:
            return np.zeros_like(self.element_mass)
        return self.layout.of_elements(self._broken_rotary)

    @cached_property
    def element_bow(self) -> Array:
        """``int w' z' dx`` of each element in its member's axes, ``(elements, 6, 6)``."""
        ones = Distribution.constant(self.layout, np.ones(len(self.mesh.cell)))
        return self.layout.of_elements(self._assembled({bowing: ones}))

    @cached_property
    def _broken_stiffness(self) -> sp.csr_matrix:
        rigidity = self.rigidity
        return self._assembled({axial: rigidity.axial, bending: rigidity.bending, shear: rigidity.shear})

    @cached_property
    def _broken_mass(self) -> sp.csr_matrix:
        return self._assembled(
            {mass: self.inertia.density, offset_mass: self._moment_beside, rotary: self.inertia.rotary}
        )

    @cached_property
    def _broken_rotary(self) -> sp.csr_matrix | None:
        return None if self.inertia.rotary is None else self._assembled({rotary: self.inertia.rotary})

    @property
    def _moment_beside(self) -> Distribution | None:
        """Moment of the mass about the neutral line; None where it is 0 everywhere."""
        return None if self.mass_moment is None else Distribution.constant(self.layout, self.mass_moment)

    def _assembled(self, parts: Mapping[Form, Distribution | None]) -> sp.csr_matrix:
        """Assemble the sum of forms, each of its property; where that is constant, it is compiled once for a layout."""
        given, space = {form: part for form, part in parts.items() if part is not None}, self.layout.space

        def summed(*coefficients: Any) -> Any:
            return reduce(add, (form(space, coefficient) for form, coefficient in zip(given, coefficients)))

        properties = [part.coefficient for part in given.values()]
        if any(part.varies for part in given.values()):
            return _fenicsx.assemble_matrix(summed(*properties))
        name = " and ".join(form.__name__ for form in given)
        made = self.layout.once(name, lambda: _fenicsx.FormOfConstants(summed, self.mesh.constants, len(properties)))
        return made.assembled(*properties)


def assemble_beams(scene: Scene, mesh: BeamMesh) -> Beams:
    """Prepare the matrices of all links by Euler and Bernoulli, (7.1) and (7.2), in link axes."""
    members = scene.members()

    def properties(label: str, s: Array) -> Array:
        here = scene.rigidity(label, s)
        return np.stack([here.axial, here.bending, here.line_density])

    layout = Layout.of(mesh, Offsets.of(mesh, scene.rigidity, members, scene.joints))
    varies = not all(scene.sections[member.section].constant for _, member in members.values())
    ea, ei, density = along_elements(layout, properties, varies)
    links = Beams(layout, ElementRigidity(ea, ei), Inertia(density, _bodies(scene.links, scene.masses, mesh)))
    if links.mass_moment is None or layout.offsets is None:
        return links
    rotary_inertia = Distribution.constant(layout, links.mass_moment * layout.offsets.mass)
    return replace(links, inertia=replace(links.inertia, rotary=rotary_inertia))


def _bodies(
    links: Mapping[str, Link], masses: Mapping[str, PointMass], mesh: BeamMesh
) -> tuple[tuple[int, RigidBody | PointMass], ...]:
    """Nodes of rigid links and point masses, with their inertia."""
    rigid = [(mesh.node(f"{name}.centre"), link.rigid) for name, link in links.items() if link.rigid]
    return (*rigid, *((mesh.node(body.at), body) for body in masses.values()))
