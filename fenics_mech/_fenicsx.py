"""Every call to dolfinx whose name or signature differs between its versions 0.5 and 0.10."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import ufl
from dolfinx import fem, jit
from mpi4py import MPI
from petsc4py import PETSc

from fenics_mech._arrays import Array, Index
from fenics_mech._compiling import compile_safely

try:  # dolfinx >= 0.10
    from dolfinx.io import gmsh as gmshio
except ImportError:
    from dolfinx.io import gmshio
try:  # explicit import from 0.7
    import dolfinx.fem.petsc as fem_petsc
except ImportError:
    fem_petsc = fem.petsc


JIT_OPTIONS = "jit_options" if hasattr(jit, "get_options") else "jit_params"  # from 0.6


def compiled(make: Callable[..., Any], *arguments: Any) -> Any:
    """Call what compiles C, such as `fem.form`, with a cache that a killed process cannot spoil."""
    return compile_safely(lambda folder: make(*arguments, **{JIT_OPTIONS: {"cache_dir": folder}}))


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep the C compiler's command lines, which setuptools logs as information, off the screen."""
    before = logging.root.manager.disable
    logging.disable(max(before, logging.INFO))
    try:
        yield
    finally:
        logging.disable(before)


def line_mesh(model: Any) -> tuple[Any, Array, Index]:
    """Read a gmsh model of lines on the x axis.

    Parameters
    ----------
    model
        The gmsh model, meshed.
    places
        Where the nodes were asked for (m); they are moved there, as gmsh's transfinite curves are good to 1e-12 only.

    Returns
    -------
    tuple
        The mesh, the x of each cell's two vertices in the order of the cell's dofs, shape ``(cells, 2)``, and each
        cell's physical group, shape ``(cells,)``.
    """
    read = gmshio.model_to_mesh(model, MPI.COMM_SELF, 0, gdim=1)
    mesh, tags = read[0], read[1]
    dofmap = mesh.geometry.dofmap
    cells = dofmap.array if hasattr(dofmap, "array") else np.asarray(dofmap)
    ends = mesh.geometry.x[cells.reshape(-1, 2), 0]
    groups = np.empty(len(ends), dtype=np.int64)
    groups[tags.indices] = tags.values
    return mesh, ends, groups


@_quiet()
def broken_space(mesh: Any, degrees: tuple[int, ...]) -> Any:
    """Give the mixed space of discontinuous Lagrange elements of the given degrees."""
    if hasattr(fem, "functionspace"):  # 0.7
        from basix.ufl import element, mixed_element  # noqa: PLC0415

        parts = [element("Lagrange", mesh.basix_cell(), degree, discontinuous=True) for degree in degrees]
        return compiled(fem.functionspace, mesh, mixed_element(parts))
    parts = [ufl.FiniteElement("DG", mesh.ufl_cell(), degree) for degree in degrees]
    return compiled(fem.FunctionSpace, mesh, ufl.MixedElement(*parts))


def cell_dofs(space: Any, part: int) -> tuple[Index, Array]:
    """Give the dofs of one part of a mixed space, ``(cells, dofs)``, and their places 0..1 in the reference cell."""
    part_space = space.sub(part)
    cells = space.mesh.topology.index_map(1).size_local
    dofs = np.array([part_space.dofmap.cell_dofs(cell) for cell in range(cells)], dtype=np.int64)
    points = part_space.collapse()[0].element.interpolation_points
    return dofs, np.asarray(points() if callable(points) else points)[:, 0]


@_quiet()
def cellwise(mesh: Any, values: Array) -> Any:
    """Give the function that takes one value per cell."""
    space = compiled(fem.functionspace if hasattr(fem, "functionspace") else fem.FunctionSpace, mesh, ("DG", 0))
    function = fem.Function(space)
    function.x.array[[space.dofmap.cell_dofs(cell)[0] for cell in range(len(values))]] = values
    return function


@_quiet()
def assemble(form: Any) -> PETSc.Mat:
    """Compile a bilinear form and assemble it."""
    matrix = fem_petsc.assemble_matrix(compiled(fem.form, form))
    matrix.assemble()
    return matrix


@_quiet()
def assemble_vector(form: Any) -> Array:
    """Compile a linear form and assemble it."""
    return np.asarray(fem_petsc.assemble_vector(compiled(fem.form, form)).array_r).copy()
