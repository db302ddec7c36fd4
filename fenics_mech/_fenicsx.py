"""Every call to dolfinx whose name or signature differs between its versions 0.5 and 0.11.

Nothing else in the package knows a version of dolfinx, or imports it.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from inspect import signature
from typing import Any

import numpy as np
import scipy.sparse as sp

from fenics_mech._arrays import Array, Index
from fenics_mech._compiling import compile_safely
from fenics_mech._libraries import versions_by_python
from fenics_mech._petsc import MPI, Absent, not_there, to_scipy
from fenics_mech.errors import MechanismError, SolverError

try:  # after PETSc and its MPI
    with versions_by_python():
        import dolfinx
        import ufl
except ImportError as error:
    dolfinx = ufl = fem = Absent(error)  # type: ignore[assignment]
KNOWN = ((0, 5), (0, 9), (0, 10), (0, 11))  # versions of dolfinx that this has been run with


def found() -> tuple[int, ...]:
    """Give the version of dolfinx, such as (0, 9)."""
    return tuple(int(part) for part in dolfinx.__version__.split(".")[:2])


@contextmanager
def _version_named() -> Iterator[None]:
    """Name the version of dolfinx in an error, where this has not been run with it."""
    try:
        yield
    except Exception as error:
        if isinstance(dolfinx, Absent):
            raise not_there(dolfinx.error) from error
        if type(error) is RuntimeError:  # of its C++, as where it gets no memory
            raise SolverError(f"dolfinx stopped: {error}. There may be too little memory") from error
        if found() in KNOWN:
            raise
        *others, last = (".".join(map(str, version)) for version in KNOWN)
        known = f"{', '.join(others)} and {last}"
        what = " ".join(str(error).split()) or type(error).__name__
        raise MechanismError(
            f"dolfinx {dolfinx.__version__} is installed, and only {known} are known to work: {what}"
        ) from error


if not isinstance(dolfinx, Absent):
    with _version_named():
        from dolfinx import fem, jit  # type: ignore[no-redef]

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
    if JIT_OPTIONS not in signature(make).parameters:  # spaces are not compiled from 0.10
        return make(*arguments)
    return compile_safely(lambda folder: make(*arguments, **{JIT_OPTIONS: {"cache_dir": folder}}))


@contextmanager
def _calling() -> Iterator[None]:
    """Call dolfinx, and keep the C compiler's command lines, which setuptools logs as information, off the screen."""
    before = logging.root.manager.disable
    logging.disable(max(before, logging.INFO))
    try:
        with _version_named():
            yield
    finally:
        logging.disable(before)


@_calling()
def line_mesh(model: Any) -> tuple[Any, Array, Index]:
    """Read a gmsh model of lines on the x axis."""
    read = gmshio.model_to_mesh(model, MPI.COMM_SELF, 0, gdim=1)
    mesh, tags = read[0], read[1]
    ends = mesh.geometry.x[_vertices(mesh), 0]
    groups = np.empty(len(ends), dtype=np.int64)
    groups[tags.indices] = tags.values
    return mesh, ends, groups


def _vertices(mesh: Any) -> Index:
    """Give the vertices of each cell of a mesh of lines, ``(cells, 2)``."""
    geometry = mesh.geometry
    dofmap = geometry.dofmaps[0] if hasattr(geometry, "dofmaps") else geometry.dofmap  # 0.11
    return np.asarray(dofmap.array if hasattr(dofmap, "array") else dofmap).reshape(-1, 2)


@_calling()
def broken_space(mesh: Any, degrees: tuple[int, ...]) -> Any:
    """Give the mixed space of discontinuous Lagrange elements of the given degrees."""
    if hasattr(fem, "functionspace"):  # 0.7
        from basix.ufl import element, mixed_element  # noqa: PLC0415

        parts = [element("Lagrange", mesh.basix_cell(), degree, discontinuous=True) for degree in degrees]
        return compiled(fem.functionspace, mesh, mixed_element(parts))
    parts = [ufl.FiniteElement("DG", mesh.ufl_cell(), degree) for degree in degrees]
    return compiled(fem.FunctionSpace, mesh, ufl.MixedElement(*parts))


@_calling()
def broken_line(mesh: Any, degree: int) -> Any:
    """Give the space of discontinuous Lagrange elements of a degree."""
    return compiled(fem.functionspace if hasattr(fem, "functionspace") else fem.FunctionSpace, mesh, ("DG", degree))


@_calling()
def cell_dofs(space: Any, part: int) -> tuple[Index, Array]:
    """Give the dofs of one part of a mixed space, ``(cells, dofs)``, and their places 0..1 in the reference cell."""
    part_space = space.sub(part)
    cells = space.mesh.topology.index_map(1).size_local
    dofs = np.array([part_space.dofmap.cell_dofs(cell) for cell in range(cells)], dtype=np.int64)
    points = part_space.collapse()[0].element.interpolation_points
    return dofs, np.asarray(points() if callable(points) else points)[:, 0]


@_calling()
def cellwise(space: Any, values: Array) -> Any:
    """Give the function of a space of constants that takes one value per cell."""
    function = fem.Function(space)
    function.x.array[[space.dofmap.cell_dofs(cell)[0] for cell in range(len(values))]] = values
    return function


@_calling()
def cellwise_coordinate(mesh: Any, flipped: Index) -> Any:
    """Give the function that goes from 0 to 1 along every cell of a line; on those `flipped` from 1 to 0."""
    space = broken_line(mesh, 1)
    points = space.element.interpolation_points
    places = np.asarray(points() if callable(points) else points)[:, 0]
    backward = np.isin(np.arange(mesh.topology.index_map(1).size_local), flipped)
    function = fem.Function(space)
    for cell, turned in enumerate(backward):
        function.x.array[space.dofmap.cell_dofs(cell)] = 1 - places if turned else places
    return function


class FormOfConstants:
    """A bilinear form of properties with one value per cell, compiled once and assembled for any of their values."""

    @_calling()
    def __init__(self, form: Callable[..., Any], space: Any, count: int) -> None:
        self.functions = [fem.Function(space) for _ in range(count)]
        self.form = compiled(fem.form, form(*self.functions))

    @_calling()
    def assembled(self, *properties: Any) -> sp.csr_matrix:
        """Assemble it with the values of other functions of the same space."""
        for function, given in zip(self.functions, properties, strict=True):
            function.x.array[:] = given.x.array
        return _assembled(self.form)


@_calling()
def assemble_matrix(form: Any) -> sp.csr_matrix:
    """Compile a bilinear form and assemble it."""
    return _assembled(compiled(fem.form, form))


def _assembled(form: Any) -> sp.csr_matrix:
    matrix = fem_petsc.assemble_matrix(form)
    matrix.assemble()
    found = to_scipy(matrix)
    matrix.destroy()
    return found


@_calling()
def assemble_vector(form: Any) -> Array:
    """Compile a linear form and assemble it."""
    return np.asarray(fem_petsc.assemble_vector(compiled(fem.form, form)).array_r).copy()


@_calling()
def plane_mesh(model: Any) -> Any:
    """Read a gmsh model of triangles in the plane z = 0."""
    return gmshio.model_to_mesh(model, MPI.COMM_SELF, 0, gdim=2)[0]


@_calling()
def lagrange(mesh: Any, degree: int) -> Any:
    """Give the space of continuous Lagrange elements of a degree."""
    return compiled(
        fem.functionspace if hasattr(fem, "functionspace") else fem.FunctionSpace, mesh, ("Lagrange", degree)
    )


@_calling()
def constant(mesh: Any, value: float) -> Any:
    """Give a number as forms on a mesh take it."""
    return fem.Constant(mesh, np.float64(value))


@_calling()
def function_of(space: Any, values: Array) -> Any:
    """Give the function of a space that has some values."""
    function = fem.Function(space)
    function.x.array[:] = values
    return function


@_calling()
def integral(form: Any) -> float:
    """Compile a form without arguments, and give its value."""
    return float(fem.assemble_scalar(compiled(fem.form, form)))


@_calling()
def largest_at_vertices(mesh: Any, expression: Any) -> float:
    """Give the largest value of an expression at the vertices of the cells, each seen from its own cell."""
    space = broken_line(mesh, 1)
    points = space.element.interpolation_points
    made = compiled(fem.Expression, expression, points() if callable(points) else points)
    function = fem.Function(space)
    function.interpolate(made)
    return float(np.abs(function.x.array).max())
