"""Stiffness, mass and gyroscopic matrices of all links in their own axes: they do not depend on the crank angle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray
from petsc4py import PETSc

from fenics_mech import _fenicsx
from fenics_mech.beams.attachment import QUARTER
from fenics_mech.beams.forms import axial, bending, gyroscopic, mass
from fenics_mech.beams.layout import Layout
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.errors import SceneError
from fenics_mech.scene import PointMass, RigidBody, Scene

Array = NDArray[np.float64]
DEGREE = 4  # of the polynomials that stand for a section that varies


@dataclass(frozen=True)
class Beams:
    """The links' matrices. Rows and columns are nodal dofs in link axes, 3 per node of `mesh`.

    Parameters
    ----------
    layout
        The broken space and how nodal dofs span it.
    coefficients
        EA (N), EI (N m^2) and rho A (kg/m) as UFL coefficients.
    bodies
        Point masses and rigid links, by node.
    stiffness, mass
        k and m of all links (block-diagonal by link), with the point masses in m; PETSc AIJ.
    element_stiffness, element_mass
        (7.2) and (7.1) of each element in its member's axes, ``(elements, 6, 6)``: u, w, phi at both nodes.
    axial_rigidity, bending_rigidity, line_density
        EA (N), EI (N m^2) and rho A (kg/m) of each element, means along it where the section varies.
    density_powers
        Where a section varies: rho A along each element as coefficients of the powers 0 to `DEGREE` of the place 0..1
        in it (kg/m), ``(elements, DEGREE + 1)``; the same polynomials stand in the forms.
    """

    layout: Layout
    coefficients: Sequence[Any]
    bodies: tuple[tuple[int, RigidBody | PointMass], ...]
    stiffness: PETSc.Mat
    mass: PETSc.Mat
    element_stiffness: Array
    element_mass: Array
    axial_rigidity: Array
    bending_rigidity: Array
    line_density: Array
    density_powers: Array | None = None

    @property
    def mesh(self) -> BeamMesh:
        """The mesh."""
        return self.layout.mesh

    @cached_property
    def gyroscopic(self) -> PETSc.Mat:
        """Matrix s of all links with the point masses, assembled when first asked for; PETSc AIJ."""
        matrix = self.layout.nodal(self._broken_gyroscopic)
        _add_bodies(self.bodies, matrix, lambda body: (2, body.mass * QUARTER))
        return matrix

    @cached_property
    def element_gyroscopic(self) -> Array:
        """Matrix s of each element in its member's axes, ``(elements, 6, 6)``."""
        return self.layout.of_elements(self._broken_gyroscopic)

    @cached_property
    def _broken_gyroscopic(self) -> PETSc.Mat:
        return self.layout.assemble(gyroscopic(self.layout.space, self.coefficients[2]))


def assemble_beams(scene: Scene, mesh: BeamMesh) -> Beams:
    """Assemble the forms of all links once, in link axes."""
    layout = Layout.of(mesh)
    varies = not all(scene.sections[member.section].constant for _, member in scene.members().values())
    coefficients, powers = (_along_elements if varies else _by_element)(scene, layout)
    ea, ei, rho_a = coefficients
    properties = powers @ (1 / np.arange(1, powers.shape[-1] + 1))  # means of the powers
    broken = (
        layout.assemble(axial(layout.space, ea) + bending(layout.space, ei)),
        layout.assemble(mass(layout.space, rho_a)),
    )
    element_stiffness, element_mass = (layout.of_elements(matrix) for matrix in broken)
    k, m = (layout.nodal(matrix) for matrix in broken)
    bodies = _bodies(scene, mesh)
    _add_bodies(bodies, m, lambda body: (3, np.diag([body.mass, body.mass, body.inertia])))
    for matrix in broken:
        matrix.destroy()
    return Beams(
        layout=layout,
        coefficients=coefficients,
        bodies=bodies,
        stiffness=k,
        mass=m,
        element_stiffness=element_stiffness,
        element_mass=element_mass,
        axial_rigidity=properties[:, 0],
        bending_rigidity=properties[:, 1],
        line_density=properties[:, 2],
        density_powers=powers[:, 2] if varies else None,
    )


def _by_element(scene: Scene, layout: Layout) -> tuple[list[Any], Array]:
    """EA, EI and rho A of members that do not vary: coefficients with one value per cell, and ``(elements, 3, 1)``."""
    mesh = layout.mesh
    values = np.array([_rigidities(scene, label, np.zeros(1)) for label in mesh.members])[mesh.cell_member]
    return [layout.coefficient(column) for column in values[..., 0].T], values


def _along_elements(scene: Scene, layout: Layout) -> tuple[Sequence[Any], Array]:
    """EA, EI and rho A as polynomials of degree `DEGREE` in each element.

    They are interpolated in a discontinuous Lagrange space, so that UFL chooses a quadrature that is exact for them:
    degree 2 more than theirs in bending, 6 more in the mass.

    Returns
    -------
    tuple
        UFL coefficients, and the coefficients of the powers of the place 0..1, ``(elements, 3, DEGREE + 1)``.
    """
    mesh = layout.mesh
    space = _fenicsx.broken_space(mesh.mesh, (DEGREE,) * 3)
    function = fem.Function(space)
    powers = np.empty((len(mesh.cell), 3, DEGREE + 1))
    for part in range(3):
        dofs, points = _fenicsx.cell_dofs(space, part)
        xi = np.where(mesh.cell_flipped[:, None], 1 - points, points)  # (elements, points)
        s = (mesh.cell_start[:, None] + mesh.cell_length[:, None] * xi) / mesh.member_length[mesh.cell_member, None]
        values = np.empty_like(s)
        for i, label in enumerate(mesh.members):
            here = mesh.cell_member == i
            values[here] = _rigidities(scene, label, np.clip(s[here].ravel(), 0, 1))[part].reshape(-1, DEGREE + 1)
        function.x.array[dofs[mesh.cell]] = values
        powers[:, part] = np.linalg.solve(
            np.vander(xi.ravel(), DEGREE + 1, True).reshape(*xi.shape, -1), values[..., None]
        )[..., 0]
    _refuse_negative(mesh, powers)
    return ufl.split(function), powers


def _refuse_negative(mesh: BeamMesh, powers: Array) -> None:
    """Raise where a polynomial through positive values is negative between them: the section varies too fast for it."""
    between = np.vander(np.linspace(0, 1, 41), DEGREE + 1, increasing=True)
    bad = (powers @ between.T).min(axis=(1, 2)) <= 0
    if bad.any():
        element = int(np.argmax(bad))
        i = mesh.cell_member[element]
        raise SceneError(
            f"the section varies too fast for the element at {mesh.cell_start[element] / mesh.member_length[i]:.4g}",
            place=f"member {mesh.members[i]}",
            hint="Use more elements",
        )


def _rigidities(scene: Scene, label: str, s: Array) -> Array:
    """EA (N), EI (N m^2) and rho A (kg/m) of a member at places s, ``(3, places)``."""
    rigidity = scene.rigidity(label, s)
    return np.stack([rigidity.axial, rigidity.bending, rigidity.line_density])


def _bodies(scene: Scene, mesh: BeamMesh) -> tuple[tuple[int, RigidBody | PointMass], ...]:
    """Nodes of rigid links and point masses, with their inertia."""
    rigid = [(mesh.node(f"{name}.centre"), link.rigid) for name, link in scene.links.items() if link.rigid]
    return (*rigid, *((mesh.node(body.at), body) for body in scene.masses.values()))


def _add_bodies(
    bodies: Sequence[tuple[int, RigidBody | PointMass]],
    matrix: PETSc.Mat,
    block: Callable[[RigidBody | PointMass], tuple[int, Array]],
) -> None:
    """Add a block of each body to a matrix, on the first dofs of its node."""
    matrix.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, False)
    for node, body in bodies:
        size, values = block(body)
        rows = list(range(3 * node, 3 * node + size))
        matrix.setValues(rows, rows, values, addv=True)
    matrix.assemble()
