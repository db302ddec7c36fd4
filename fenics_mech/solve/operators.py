"""Matrices that PETSc and SLEPc know only by their products."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from fenics_mech._arrays import Array
from fenics_mech._petsc import PETSc


class _Operator:
    def __init__(self, apply: Callable[[Array], Array]) -> None:
        self.apply = apply

    def mult(self, matrix: object, x: object, y: object) -> None:
        y.setArray(self.apply(x.getArray(readonly=True)))  # type: ignore[attr-defined]


@contextmanager
def shell(size: int, apply: Callable[[Array], Array]) -> Iterator[tuple[Any, Any, Any]]:
    """Give the matrix whose product with a vector a function makes, and two vectors that fit it.

    Python alone does not destroy what PETSc holds, and the function holds the factors of all steps.

    Parameters
    ----------
    size
        Rows, and columns.
    apply
        Gives the product.
    """
    matrix = PETSc.Mat().createPython([size, size], _Operator(apply), comm=PETSc.COMM_SELF)
    matrix.setUp()
    right, left = matrix.createVecs()
    try:
        yield matrix, right, left
    finally:
        for thing in (right, left, matrix):
            thing.destroy()
