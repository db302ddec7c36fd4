"""Stiffness, mass and gyroscopic matrices of all links, in the links' own axes: they do not depend on the crank angle.

The forms are assembled in the broken space. The constant matrix `embedding` (broken <- nodal) carries what joins
inside a link: the Hermite functions with their element size, continuity, the members' angles and the welds. Nodal dofs
are three per node: displacement along the link's x and y axes, and rotation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem
from numpy.typing import NDArray
from petsc4py import PETSc

from fenics_mech import _fenicsx
from fenics_mech.beams.forms import axial, bending, gyroscopic, mass
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.beams.shapes import AXIAL, CUBIC, LINEAR, NORMAL, evaluate
from fenics_mech.errors import SceneError
from fenics_mech.scene import PointMass, RigidBody, Scene

Array = NDArray[np.float64]
DEGREE = 4  # of the polynomials that stand for a section that varies


@dataclass(frozen=True)
class Beams:
    """The links' matrices. Rows and columns are nodal dofs in link axes, 3 per node of `mesh`.

    Parameters
    ----------
    mesh
        The mesh.
    stiffness, mass, gyroscopic
        k, m and s of all links (block-diagonal by link), with the point masses in m and s; PETSc AIJ.
    element_stiffness, element_mass
        (7.2) and (7.1) of each element in its member's axes, ``(elements, 6, 6)``: u, w, phi at both nodes.
    axial_rigidity, bending_rigidity, line_density
        EA (N), EI (N m^2) and rho A (kg/m) of each element, means along it where the section varies.
    density_powers
        Where a section varies: rho A along each element as coefficients of the powers 0 to `DEGREE` of the place 0..1
        in it (kg/m), ``(elements, DEGREE + 1)``; the same polynomials stand in the forms.
    """

    mesh: BeamMesh
    stiffness: PETSc.Mat
    mass: PETSc.Mat
    gyroscopic: PETSc.Mat
    element_stiffness: Array
    element_mass: Array
    axial_rigidity: Array
    bending_rigidity: Array
    line_density: Array
    density_powers: Array | None = None


def assemble_beams(scene: Scene, mesh: BeamMesh) -> Beams:
    """Assemble the forms of all links once, in link axes."""
    space = _fenicsx.broken_space(mesh.mesh, (1, 3))
    varies = not all(scene.sections[member.section].constant for _, member in scene.members().values())
    (ea, ei, rho_a), powers = (_along_elements if varies else _by_element)(scene, mesh)
    properties = powers @ (1 / np.arange(1, powers.shape[-1] + 1))  # means of the powers
    broken = {
        "stiffness": _fenicsx.assemble(axial(space, ea) + bending(space, ei)),
        "mass": _fenicsx.assemble(mass(space, rho_a)),
        "gyroscopic": _fenicsx.assemble(gyroscopic(space, rho_a)),
    }
    dofs, hermite = _hermite(space, mesh)
    elements = {name: _element_matrices(broken[name], dofs, hermite) for name in ("stiffness", "mass")}
    embedding = _to_petsc(_embedding(mesh, dofs, hermite))
    nodal = {name: matrix.PtAP(embedding) for name, matrix in broken.items()}
    _add_bodies(scene, mesh, nodal["mass"], nodal["gyroscopic"])
    for matrix in (*broken.values(), embedding):
        matrix.destroy()
    return Beams(
        mesh=mesh,
        **nodal,
        element_stiffness=elements["stiffness"],
        element_mass=elements["mass"],
        axial_rigidity=properties[:, 0],
        bending_rigidity=properties[:, 1],
        line_density=properties[:, 2],
        density_powers=powers[:, 2] if varies else None,
    )


def _by_element(scene: Scene, mesh: BeamMesh) -> tuple[list[object], Array]:
    """EA, EI and rho A of members that do not vary: coefficients with one value per cell, and ``(elements, 3, 1)``."""
    values = np.array([_rigidities(scene, label, np.zeros(1)) for label in mesh.members])[mesh.cell_member]
    by_cell = np.empty_like(values)
    by_cell[mesh.cell] = values
    return [_fenicsx.cellwise(mesh.mesh, column) for column in by_cell[..., 0].T], values


def _along_elements(scene: Scene, mesh: BeamMesh) -> tuple[Sequence[object], Array]:
    """EA, EI and rho A as polynomials of degree `DEGREE` in each element.

    They are interpolated in a discontinuous Lagrange space, so that UFL chooses a quadrature that is exact for them:
    degree 2 more than theirs in bending, 6 more in the mass.

    Returns
    -------
    tuple
        UFL coefficients, and the coefficients of the powers of the place 0..1, ``(elements, 3, DEGREE + 1)``.
    """
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


def _hermite(space: object, mesh: BeamMesh) -> tuple[NDArray[np.int64], Array]:
    """Broken dofs of each element, and the Hermite and linear functions at them, in member axes.

    Returns
    -------
    tuple
        Dofs ``(elements, 6)`` and values ``(elements, 6, 6)``: column j is the broken function that nodal dof j
        (u, w, phi at both nodes) of the element makes.
    """
    (u_dofs, u_points), (w_dofs, w_points) = (_fenicsx.cell_dofs(space, part) for part in (0, 1))
    dofs = np.concatenate([u_dofs, w_dofs], axis=1)[mesh.cell]
    flipped = mesh.cell_flipped[:, None]
    linear = evaluate(LINEAR, np.where(flipped, 1 - u_points, u_points))
    cubic = evaluate(CUBIC, np.where(flipped, 1 - w_points, w_points))
    cubic[..., [1, 3]] *= mesh.cell_length[:, None, None]
    values = np.zeros((len(dofs), 6, 6))
    values[:, :2][..., AXIAL] = linear
    values[:, 2:][..., NORMAL] = cubic
    return dofs, values


def _element_matrices(broken: PETSc.Mat, dofs: NDArray[np.int64], hermite: Array) -> Array:
    """Element matrices in nodal dofs and member axes, ``(elements, 6, 6)``, from a block-diagonal broken matrix."""
    matrix = sp.csr_matrix(broken.getValuesCSR()[::-1], shape=broken.size)
    rows, columns = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
    blocks = np.asarray(matrix[rows.ravel(), columns.ravel()]).reshape(-1, 6, 6)
    return np.einsum("eai,eab,ebj->eij", hermite, blocks, hermite)


def member_rotation(mesh: BeamMesh) -> Array:
    """Turn an element's nodal dofs from link axes into its member's axes, ``(elements, 6, 6)``."""
    angle = mesh.member_angle[mesh.cell_member]
    rotation = np.zeros((len(angle), 6, 6))
    for first in (0, 3):
        rotation[:, first, first] = rotation[:, first + 1, first + 1] = np.cos(angle)
        rotation[:, first, first + 1] = np.sin(angle)
        rotation[:, first + 1, first] = -np.sin(angle)
        rotation[:, first + 2, first + 2] = 1.0
    return rotation


def element_dofs(mesh: BeamMesh) -> NDArray[np.int64]:
    """Nodal dofs of each element, ``(elements, 6)``."""
    return (3 * mesh.cell_nodes[:, :, None] + np.arange(3)).reshape(-1, 6)


def _embedding(mesh: BeamMesh, dofs: NDArray[np.int64], hermite: Array) -> sp.csr_matrix:
    """Broken <- nodal: column j is the broken function of nodal dof j (link axes)."""
    values = hermite @ member_rotation(mesh)
    rows, columns = np.broadcast_arrays(dofs[:, :, None], element_dofs(mesh)[:, None, :])
    return sp.csr_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape=(dofs.size, 3 * len(mesh.node_link)))


def _to_petsc(matrix: sp.csr_matrix) -> PETSc.Mat:
    csr = (matrix.indptr.astype(PETSc.IntType), matrix.indices.astype(PETSc.IntType), matrix.data)
    return PETSc.Mat().createAIJ(matrix.shape, csr=csr, comm=PETSc.COMM_SELF)


def _add_bodies(scene: Scene, mesh: BeamMesh, m: PETSc.Mat, s: PETSc.Mat) -> None:
    """Point masses and rigid links enter m as they stand, and s as the gyroscopic form does."""
    bodies: list[tuple[int, RigidBody | PointMass]]
    bodies = [(mesh.node(f"{name}.centre"), link.rigid) for name, link in scene.links.items() if link.rigid]
    bodies += [(mesh.node(body.at), body) for body in scene.masses.values()]
    for matrix in (m, s):
        matrix.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, False)
    for node, body in bodies:
        rows = [3 * node, 3 * node + 1, 3 * node + 2]
        m.setValues(rows, rows, np.diag([body.mass, body.mass, body.inertia]), addv=True)
        s.setValues(rows[:2], rows[:2], body.mass * np.array([[0, -1], [1, 0]]), addv=True)
    m.assemble()
    s.assemble()
