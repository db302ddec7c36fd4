"""Factors of sparse matrices whose unknowns have different units."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError


class Factors:
    """LU factors of a square matrix, whose rows and columns are brought to a size of one before.

    Parameters
    ----------
    matrix
        The matrix.
    what
        What it belongs to, for the message.

    Raises
    ------
    SolverError
        When it is singular.
    """

    def __init__(self, matrix: sp.spmatrix, what: str) -> None:
        A = sp.csc_matrix(matrix)
        size = np.abs(A)
        rows = 1 / np.sqrt(np.maximum(size.max(axis=1).toarray()[:, 0], 1e-300))
        columns = 1 / np.maximum(np.abs(sp.diags(rows) @ A).max(axis=0).toarray()[0], 1e-300)
        self._rows, self._columns = rows, columns
        try:
            self._lu = splu(sp.csc_matrix(sp.diags(rows) @ A @ sp.diags(columns)))
        except RuntimeError as error:
            raise SolverError(f"{what}: the equations are singular") from error

    def solve(self, right: Array) -> Array:
        """Solve for one vector, or for columns."""
        shape = (-1, *[1] * (right.ndim - 1))
        return np.asarray(self._lu.solve(self._rows.reshape(shape) * right) * self._columns.reshape(shape))
