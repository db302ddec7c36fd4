"""Factors of sparse matrices whose unknowns have different units."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from fenics_mech._arrays import Array, Index
from fenics_mech.errors import SolverError
from fenics_mech.machine import Pattern

SINGULAR = (
    "{}: the equations are singular: something is free to move, or joints depend on each other. "
    "Look for a link that its joints do not hold, or one that is held twice"
)


SMALL = 200  # rows of a matrix: its inverse takes less time than sparse factors and their solutions


class Blocks:
    """Where the entries of a matrix lie that has a block of `stages` rows and columns at each entry of a pattern."""

    def __init__(self, pattern: Pattern, stages: int) -> None:
        row = np.repeat(np.arange(pattern.size), np.diff(pattern.indptr))[:, None, None] * stages
        stage = np.arange(stages)
        rows, columns = np.broadcast_arrays(row + stage[:, None], pattern.indices[:, None, None] * stages + stage)
        self.size = pattern.size * stages
        self.places = rows.ravel(), columns.ravel()
        self._by_row, self._rows = _sorted(rows.ravel(), columns.ravel(), self.size)
        self.by_column, self.indptr = _sorted(columns.ravel(), rows.ravel(), self.size)
        self.indices = rows.ravel()[self.by_column].astype(np.int32)
        self.columns = columns.ravel()[self.by_column]

    def largest_of_rows(self, sizes: Array) -> Array:
        """Give the largest entry of every row, by the sizes of all entries."""
        return np.asarray(np.maximum.reduceat(sizes[self._by_row], self._rows[:-1]))


def _sorted(first: Index, second: Index, size: int) -> tuple[Index, Index]:
    """Give the order of entries by one of their places, then by the other, and where each of the first begins."""
    starts = np.concatenate([[0], np.cumsum(np.bincount(first, minlength=size))])
    return np.lexsort((second, first)), starts


@lru_cache(maxsize=16)
def blocks_of(pattern: Pattern, stages: int) -> Blocks:
    """Give where the entries of a matrix of blocks lie, made once for a pattern."""
    return Blocks(pattern, stages)


class Factors:
    """LU factors of a square matrix, whose rows and columns are brought to a size of one before."""

    def __init__(self, blocks: Blocks, values: Array, what: str) -> None:
        # values (entries of the pattern, stages, stages)
        flat = values.ravel()
        self._rows = 1 / np.sqrt(np.maximum(blocks.largest_of_rows(np.abs(flat)), 1e-300))
        data = flat[blocks.by_column] * self._rows[blocks.indices]
        largest = np.maximum.reduceat(np.abs(data), blocks.indptr[:-1])
        self._columns = 1 / np.maximum(largest, 1e-300)
        data *= self._columns[blocks.columns]
        shape = (blocks.size, blocks.size)
        try:
            self._lu = splu(sp.csc_matrix((data, blocks.indices, blocks.indptr.astype(np.int32)), shape=shape))
        except RuntimeError as error:
            raise SolverError(SINGULAR.format(what)) from error

    def solve(self, right: Array) -> Array:
        """Solve for one vector, or for columns."""
        shape = (-1, *[1] * (right.ndim - 1))
        return np.asarray(self._lu.solve(self._rows.reshape(shape) * right) * self._columns.reshape(shape))


def inverses(blocks: Blocks, values: Array, what: str) -> Array:
    """Give the inverses of many small matrices with the same pattern, scaled as `Factors` does before."""
    # values (matrices, entries of the pattern, stages, stages)
    whole = np.zeros((len(values), blocks.size, blocks.size))
    whole[:, *blocks.places] = values.reshape(len(values), -1)
    rows = 1 / np.sqrt(np.maximum(np.abs(whole).max(axis=2, initial=0.0), 1e-300))
    whole *= rows[:, :, None]
    columns = 1 / np.maximum(np.abs(whole).max(axis=1, initial=0.0), 1e-300)
    whole *= columns[:, None]
    try:
        found = np.linalg.inv(whole)
    except np.linalg.LinAlgError as error:
        raise SolverError(SINGULAR.format(what)) from error
    found *= columns[:, :, None]
    found *= rows[:, None]
    return found


def solutions(blocks: Blocks, values: Array, right: Array, what: str) -> Array:
    """Solve many systems with the same pattern, each for one vector."""
    # values (matrices, entries of the pattern, stages, stages); right (matrices, size)
    if blocks.size <= SMALL:
        return np.asarray((inverses(blocks, values, what) @ right[..., None])[..., 0])
    return np.array([Factors(blocks, value, what).solve(vector) for value, vector in zip(values, right)])
