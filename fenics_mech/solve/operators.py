"""Matrices that PETSc and SLEPc know only by their products."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._petsc import PETSc, configured
from fenics_mech.errors import SolverError


@dataclass
class _Operator:
    apply: Callable[[Array], Array]

    def mult(self, matrix: object, x: object, y: object) -> None:
        y.setArray(self.apply(x.getArray(readonly=True)))  # type: ignore[attr-defined]


@contextmanager
def shell(size: int, apply: Callable[[Array], Array]) -> Iterator[tuple[Any, Any, Any]]:
    """Give the matrix whose product with a vector a function makes, and two vectors that fit it."""
    # Python alone does not destroy what PETSc holds, and the function holds the factors of all steps.
    matrix = PETSc.Mat().createPython([size, size], _Operator(apply), comm=PETSc.COMM_SELF)
    matrix.setUp()
    right, left = matrix.createVecs()
    try:
        yield matrix, right, left
    finally:
        for thing in (right, left, matrix):
            thing.destroy()


def by_gmres(apply: Callable[[Array], Array], right: Array, rtol: float, most: int, prefix: str, failure: str) -> Array:
    """Solve a linear system whose matrix a function knows, by a KSP."""
    # Its directions are made orthogonal twice: once leaves rounding of the stiff ones, by which it stops at 1e-8.
    ksp = PETSc.KSP().create(PETSc.COMM_SELF)
    ksp.setType("gmres")
    ksp.setGMRESRestart(most)
    ksp.getPC().setType("none")
    ksp.setTolerances(rtol=rtol, atol=1e-300, max_it=most + 10)
    with shell(len(right), apply) as (operator, b, x):
        ksp.setOperators(operator)
        b.setArray(right)
        with configured(ksp, prefix, {"ksp_gmres_cgs_refinement_type": "refine_always"}, {}):
            ksp.solve(b, x)
            if ksp.getConvergedReason() < 0:
                raise SolverError(failure)
        return np.array(x.getArray())
