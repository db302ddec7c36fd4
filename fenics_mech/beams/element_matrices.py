"""Stiffness, mass and gyroscopic matrices of all links in their own axes: they do not depend on the crank angle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray
from petsc4py import PETSc

from fenics_mech import _fenicsx
from fenics_mech.beams.attachment import QUARTER
from fenics_mech.beams.forms import axial, bending, gyroscopic, mass, offset_gyroscopic, offset_mass, rotary, shear
from fenics_mech.beams.layout import Layout
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.beams.nonlinear_stretching import Stretching
from fenics_mech.beams.offset_pins import Offsets
from fenics_mech.errors import SceneError
from fenics_mech.scene import PointMass, RigidBody, Scene

if TYPE_CHECKING:
    from fenics_mech.beams.reduction import Reduction

Array = NDArray[np.float64]
DEGREE = 4  # of the polynomials that stand for a section that varies


@dataclass(frozen=True)
class Beams:
    """The links' matrices. Rows and columns are nodal dofs in link axes, 3 per node of `mesh`.

    All matrices are assembled when first asked for. Those of elements are in their members' axes, ``(elements, 6, 6)``:
    u, w, phi at both nodes.

    Parameters
    ----------
    layout
        The broken space and how nodal dofs span it.
    coefficients
        EA (N), EI (N m^2) and rho A (kg/m) as UFL coefficients.
    bodies
        Point masses and rigid links, by node.
    axial_rigidity, bending_rigidity, line_density
        EA (N), EI (N m^2) and rho A (kg/m) of each element, means along it where the section varies. EA is infinite
        where an element cannot stretch.
    density_powers
        Where a section varies: rho A along each element as coefficients of the powers 0 to `DEGREE` of the place 0..1
        in it (kg/m), ``(elements, DEGREE + 1)``; the same polynomials stand in the forms.
    stiffness_powers
        EA (N) and EI (N m^2) as `density_powers`, ``(elements, 2, DEGREE + 1)``; None where no section varies.
    shear_stiffness, shear_rigidity
        G A_s as UFL coefficient, and its means over the elements, ``(elements,)`` (N); None where beams are rigid in
        shear.
    rotary
        rho I as UFL coefficient (kg m); None where the sections' rotation has no inertia. Without the effect
        'rotary-inertia' it is that of a mass in the centre of mass, beside the neutral line.
    rotary_powers
        rho I as `density_powers`, ``(elements, 1)`` where no section varies (kg m).
    reduction
        Fewer coordinates that say the nodal dofs, where the links are reduced.
    spread
        The same beams with their mass along them, where it stands at their nodes.
    """

    layout: Layout
    coefficients: Sequence[Any]
    bodies: tuple[tuple[int, RigidBody | PointMass], ...]
    axial_rigidity: Array
    bending_rigidity: Array
    line_density: Array
    density_powers: Array | None = None
    stiffness_powers: Array | None = None
    shear_stiffness: Any | None = None
    shear_rigidity: Array | None = None
    rotary: Any | None = None
    rotary_powers: Array | None = None
    reduction: Reduction | None = None
    spread: Beams | None = None

    @property
    def mesh(self) -> BeamMesh:
        """The mesh."""
        return self.layout.mesh

    @property
    def mass_moment(self) -> Array | None:
        """Moment rho A e of the mass about the neutral line of each element (kg); None where it is 0 everywhere."""
        offsets = self.layout.offsets
        return self.line_density * offsets.mass if offsets is not None and offsets.mass.any() else None

    @cached_property
    def stiffness(self) -> PETSc.Mat:
        """Matrix k of all links (block-diagonal by link); PETSc AIJ."""
        return self.layout.nodal(self._broken_stiffness)

    @cached_property
    def mass(self) -> PETSc.Mat:
        """Matrix m of all links with the point masses; PETSc AIJ."""
        matrix = self.layout.nodal(self._broken_mass)
        _add_bodies(self.bodies, matrix, lambda body: np.diag([body.mass, body.mass, body.inertia]))
        return matrix

    @cached_property
    def rotary_mass(self) -> PETSc.Mat:
        """Share of m that the rotation of sections and point masses has; PETSc AIJ.

        The turning of the link's axes adds to that rotation and does not deflect it, so that it feels the angular
        acceleration but no Coriolis and no centrifugal force.
        """
        size = 3 * len(self.mesh.node_name)
        if self.rotary is None:
            matrix = PETSc.Mat().createAIJ((size, size), nnz=1, comm=PETSc.COMM_SELF)
        else:
            matrix = self.layout.nodal(self._broken_rotary)
        _add_bodies(self.bodies, matrix, lambda body: np.diag([0.0, 0.0, body.inertia]))
        return matrix

    @cached_property
    def gyroscopic(self) -> PETSc.Mat:
        """Matrix s of all links with the point masses; PETSc AIJ."""
        matrix = self.layout.nodal(self._broken_gyroscopic)
        _add_bodies(self.bodies, matrix, lambda body: body.mass * QUARTER)
        return matrix

    @cached_property
    def element_stiffness(self) -> Array:
        """Matrix k of each element (7.2)."""
        return self.layout.of_elements(self._broken_stiffness)

    @cached_property
    def element_mass(self) -> Array:
        """Matrix m of each element (7.1)."""
        return self.layout.of_elements(self._broken_mass)

    @cached_property
    def element_rotary_mass(self) -> Array:
        """Share of m of each element that the rotation of its sections has."""
        if self.rotary is None:
            return np.zeros_like(self.element_mass)
        return self.layout.of_elements(self._broken_rotary)

    @cached_property
    def element_gyroscopic(self) -> Array:
        """Matrix s of each element."""
        return self.layout.of_elements(self._broken_gyroscopic)

    @cached_property
    def _broken_stiffness(self) -> PETSc.Mat:
        space, (ea, ei, _) = self.layout.space, self.coefficients
        form = axial(space, ea) + bending(space, ei)
        if self.shear_stiffness is not None:
            form += shear(space, self.shear_stiffness)
        return _fenicsx.assemble(form)

    @cached_property
    def _broken_mass(self) -> PETSc.Mat:
        form = mass(self.layout.space, self.coefficients[2])
        if self.mass_moment is not None:
            form += offset_mass(self.layout.space, self.layout.coefficient(self.mass_moment))
        return _fenicsx.assemble(form if self.rotary is None else form + self._rotary_form)

    @cached_property
    def _broken_rotary(self) -> PETSc.Mat:
        return _fenicsx.assemble(self._rotary_form)

    @cached_property
    def stretching(self) -> Stretching:
        """What tension and bending do to each other in every element, assembled when first asked for."""
        return Stretching.of(self.layout)

    @cached_property
    def _broken_gyroscopic(self) -> PETSc.Mat:
        form = gyroscopic(self.layout.space, self.coefficients[2])
        if self.mass_moment is not None:
            form += offset_gyroscopic(self.layout.space, self.layout.coefficient(self.mass_moment))
        return _fenicsx.assemble(form)

    @property
    def _rotary_form(self) -> Any:
        return rotary(self.layout.space, self.rotary)


def assemble_beams(scene: Scene, mesh: BeamMesh) -> Beams:
    """Prepare the forms of all links, in link axes."""
    layout = Layout.of(mesh, Offsets.of(scene, mesh))
    coefficients, powers = along_elements(scene, layout, _rigidities)
    properties, varies = means(powers), powers.shape[-1] > 1
    links = Beams(
        layout=layout,
        coefficients=coefficients,
        bodies=_bodies(scene, mesh),
        axial_rigidity=properties[:, 0],
        bending_rigidity=properties[:, 1],
        line_density=properties[:, 2],
        density_powers=powers[:, 2] if varies else None,
        stiffness_powers=powers[:, :2] if varies else None,
    )
    if links.mass_moment is None or layout.offsets is None:
        return links
    inertia = links.mass_moment * layout.offsets.mass
    return replace(links, rotary=layout.coefficient(inertia), rotary_powers=inertia[:, None])


def means(powers: Array) -> Array:
    """Means along the elements of polynomials, ``(..., degree + 1)``."""
    return powers @ (1 / np.arange(1, powers.shape[-1] + 1))


def along_elements(
    scene: Scene, layout: Layout, properties: Callable[[Scene, str, Array], Array]
) -> tuple[Sequence[Any], Array]:
    """Properties of the members as polynomials in each element, constant ones where no section varies.

    Parameters
    ----------
    scene, layout
        The scene and its broken space.
    properties
        Gives them of a member, by label, at places 0..1 along it, ``(properties, places)``.

    Returns
    -------
    tuple
        UFL coefficients, and the coefficients of the powers of the place 0..1, ``(elements, properties, powers)``.
    """
    varies = not all(scene.sections[member.section].constant for _, member in scene.members().values())
    return (_varying if varies else _constant)(scene, layout, properties)


def _constant(
    scene: Scene, layout: Layout, properties: Callable[[Scene, str, Array], Array]
) -> tuple[Sequence[Any], Array]:
    """Give coefficients with one value per cell."""
    mesh = layout.mesh
    values = np.array([properties(scene, label, np.zeros(1)) for label in mesh.members])[mesh.cell_member]
    return [layout.coefficient(column) for column in values[..., 0].T], values


def _varying(
    scene: Scene, layout: Layout, properties: Callable[[Scene, str, Array], Array]
) -> tuple[Sequence[Any], Array]:
    """Give polynomials of degree `DEGREE`.

    They are interpolated in a discontinuous Lagrange space, so that UFL chooses a quadrature that is exact for them:
    degree 2 more than theirs in bending, 6 more in the mass.
    """
    mesh = layout.mesh
    count = len(properties(scene, mesh.members[0], np.zeros(1)))
    space = _fenicsx.broken_space(mesh.mesh, (DEGREE,) * count)
    function = fem.Function(space)
    powers = np.empty((len(mesh.cell), count, DEGREE + 1))
    for part in range(count):
        dofs, points = _fenicsx.cell_dofs(space, part)
        xi = np.where(mesh.cell_flipped[:, None], 1 - points, points)  # (elements, points)
        s = (mesh.cell_start[:, None] + mesh.cell_length[:, None] * xi) / mesh.member_length[mesh.cell_member, None]
        values = np.empty_like(s)
        for i, label in enumerate(mesh.members):
            here = mesh.cell_member == i
            values[here] = properties(scene, label, np.clip(s[here].ravel(), 0, 1))[part].reshape(-1, DEGREE + 1)
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
    block: Callable[[RigidBody | PointMass], Array],
) -> None:
    """Add a block of each body to a matrix, on the first dofs of its node."""
    matrix.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, False)
    for node, body in bodies:
        values = block(body)
        rows = list(range(3 * node, 3 * node + len(values)))
        matrix.setValues(rows, rows, values, addv=True)
    matrix.assemble()
