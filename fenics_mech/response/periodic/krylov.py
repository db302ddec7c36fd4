"""Linear systems of which only products with vectors are known, solved by a KSP of PETSc."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from fenics_mech._arrays import Array
from fenics_mech._petsc import PETSc, configured


class _Products:
    """A matrix of which PETSc knows products only."""

    def __init__(self, apply: Callable[[Array], Array]) -> None:
        self.apply = apply

    def mult(self, matrix: PETSc.Mat, x: PETSc.Vec, y: PETSc.Vec) -> None:
        y.array[:] = self.apply(x.array_r)


def products(size: int, apply: Callable[[Array], Array]) -> PETSc.Mat:
    """Give a square matrix of which products with vectors are known; whoever asks for it destroys it.

    Parameters
    ----------
    size
        Number of its rows.
    apply
        Gives the product with a vector, ``(size,)`` both.
    """
    matrix = PETSc.Mat().createPython((size, size), context=_Products(apply), comm=PETSc.COMM_SELF)
    matrix.setUp()
    return matrix


def krylov(
    apply: Callable[[Array], Array],
    right: Array,
    defaults: Mapping[str, Any],
    options: Mapping[str, Any],
    preconditioner: object = None,
) -> tuple[Array, int]:
    """Solve a linear system by GMRES, unless the options ask for another method.

    Parameters
    ----------
    apply
        Gives the product of the matrix with a vector.
    right
        The right-hand side, ``(size,)``.
    defaults
        Options of the solver, without prefix.
    options
        PETSc options with the prefix "periodic_", which win.
    preconditioner
        Context of a PC in Python, if there is one.

    Returns
    -------
    tuple
        The answer and PETSc's reason to stop.
    """
    matrix = products(len(right), apply)
    b, x = matrix.createVecs()
    b.array[:] = right
    ksp = PETSc.KSP().create(comm=PETSc.COMM_SELF)
    own = {"ksp_type": "gmres", "ksp_gmres_cgs_refinement_type": "refine_always", "pc_type": "none"}
    if preconditioner is not None:
        own["pc_type"] = "python"
        ksp.getPC().setType("python")
        ksp.getPC().setPythonContext(preconditioner)
    with configured(ksp, "periodic_", own | dict(defaults), options):
        ksp.setOperators(matrix)
        ksp.solve(b, x)
        reason = ksp.getConvergedReason()
    answer = x.array_r.copy()
    for thing in (matrix, b, x):
        thing.destroy()
    return answer, reason
