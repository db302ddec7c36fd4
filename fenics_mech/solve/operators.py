"""Matrices that PETSc and SLEPc know only by their products."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from fenics_mech._arrays import Array
from fenics_mech._petsc import PETSc


class _Operator:
    def __init__(self, apply: Callable[[Array], Array]) -> None:
        self.apply = apply

    def mult(self, matrix: object, x: object, y: object) -> None:
        y.setArray(self.apply(x.getArray(readonly=True)))  # type: ignore[attr-defined]


def shell(size: int, apply: Callable[[Array], Array]) -> Any:
    """Give the matrix whose product with a vector a function makes.

    Parameters
    ----------
    size
        Rows, and columns.
    apply
        Gives the product.
    """
    matrix = PETSc.Mat().createPython([size, size], _Operator(apply), comm=PETSc.COMM_SELF)
    matrix.setUp()
    return matrix
