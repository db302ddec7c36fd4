"""Stiffness, mass and gyroscopic matrices of all links, in the links' own axes: they do not depend on the crank angle.

The forms are assembled in the broken space. The constant matrix `embedding` (broken <- nodal) carries what joins
inside a link: the Hermite functions with their element size, continuity, the members' angles and the welds. Nodal dofs
are three per node: displacement along the link's x and y axes, and rotation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from petsc4py import PETSc

from fenics_mech import _fenicsx
from fenics_mech.beams.forms import axial, bending, gyroscopic, mass
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.scene import Scene

Array = NDArray[np.float64]


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
        EA (N), EI (N m^2) and rho A (kg/m) of each element.
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


def assemble_beams(scene: Scene, mesh: BeamMesh) -> Beams:
    """Assemble the forms of all links once, in link axes."""
    space = _fenicsx.broken_space(mesh.mesh, (1, 3))
    properties = np.array([_rigidities(scene, label) for label in mesh.members])[mesh.cell_member]

    def coefficient(values: Array) -> object:
        by_cell = np.empty(len(values))
        by_cell[mesh.cell] = values
        return _fenicsx.cellwise(mesh.mesh, by_cell)

    ea, ei, rho_a = (coefficient(column) for column in properties.T)
    broken = {
        "stiffness": _fenicsx.assemble(axial(space, ea) + bending(space, ei)),
        "mass": _fenicsx.assemble(mass(space, rho_a)),
        "gyroscopic": _fenicsx.assemble(gyroscopic(space, rho_a)),
    }
    dofs, hermite = _hermite(space, mesh)
    elements = {name: _element_matrices(broken[name], dofs, hermite) for name in ("stiffness", "mass")}
    embedding = _to_petsc(_embedding(mesh, dofs, hermite))
    nodal = {name: matrix.PtAP(embedding) for name, matrix in broken.items()}
    _add_point_masses(scene, mesh, nodal["mass"], nodal["gyroscopic"])
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
    )


def _rigidities(scene: Scene, label: str) -> tuple[float, float, float]:
    """EA (N), EI (N m^2) and rho A (kg/m) of a member."""
    _, member = scene.members()[label]
    section, material = scene.sections[member.section], scene.materials[member.material]
    return material.modulus * section.area, material.modulus * section.inertia, material.density * section.area


def shape_functions(xi: Array) -> tuple[Array, Array]:
    """Axial (4.5), (4.8) and bending (4.6)-(4.10) shape functions on an element of length 1.

    Returns
    -------
    tuple
        ``(points, 2)`` for the axial displacements and ``(points, 4)`` for w, phi h at both nodes.
    """
    xi = np.asarray(xi)
    linear = np.stack([1 - xi, xi], axis=-1)
    cubic = np.stack(
        [
            (1 - xi) ** 2 * (1 + 2 * xi),  # (4.6)
            xi * (1 - xi) ** 2,  # (4.7)
            xi**2 * (3 - 2 * xi),  # (4.9)
            -(1 - xi) * xi**2,  # (4.10)
        ],
        axis=-1,
    )
    return linear, cubic


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
    linear, _ = shape_functions(np.where(flipped, 1 - u_points, u_points))
    _, cubic = shape_functions(np.where(flipped, 1 - w_points, w_points))
    cubic[..., [1, 3]] *= mesh.cell_length[:, None, None]
    values = np.zeros((len(dofs), 6, 6))
    values[:, :2][..., [0, 3]] = linear
    values[:, 2:][..., [1, 2, 4, 5]] = cubic
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


def _add_point_masses(scene: Scene, mesh: BeamMesh, m: PETSc.Mat, s: PETSc.Mat) -> None:
    """Point masses enter m as they stand, and s as the gyroscopic form does."""
    for matrix in (m, s):
        matrix.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, False)
    for point in scene.masses.values():
        row = 3 * mesh.node(point.at)
        m.setValues([row, row + 1], [row, row + 1], point.mass * np.eye(2), addv=True)
        s.setValues([row, row + 1], [row, row + 1], point.mass * np.array([[0, -1], [1, 0]]), addv=True)
    m.assemble()
    s.assemble()
