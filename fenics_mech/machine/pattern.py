"""One sparse pattern for all tangents of a machine, at all instants."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index

if TYPE_CHECKING:
    import scipy.sparse as sp

Places = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Pattern:
    """Places of the entries of a sparse matrix, row by row.

    Parameters
    ----------
    size
        Rows, and columns.
    indptr, indices
        As of SciPy's CSR.
    """

    size: int
    indptr: Places
    indices: Places

    @classmethod
    def of(cls, size: int, blocks: list[Places]) -> Pattern:
        """Give the pattern of dense blocks between lists of coordinates ``(blocks, coordinates)``; -1 is none."""
        codes = [np.arange(size, dtype=np.int64) * (size + 1)]
        for block in blocks:
            rows, columns = np.broadcast_arrays(block[:, :, None], block[:, None, :])
            kept = (rows >= 0) & (columns >= 0)
            codes.append(rows[kept].astype(np.int64) * size + columns[kept])
        codes_of_all = np.unique(np.concatenate(codes))
        counts = np.bincount(codes_of_all // size, minlength=size)
        indptr = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        return cls(size, indptr, (codes_of_all % size).astype(np.int32))

    @property
    def entries(self) -> int:
        """Number of entries."""
        return len(self.indices)

    @cached_property
    def _codes(self) -> Index:
        return np.repeat(np.arange(self.size), np.diff(self.indptr)) * self.size + self.indices

    def at(self, rows: Places, columns: Places) -> Places:
        """Give the numbers of the entries of lists of coordinates ``(..., rows, columns)``; -1 where there is none."""
        one, other = np.broadcast_arrays(rows[..., :, None], columns[..., None, :])
        code = one.astype(np.int64) * self.size + other
        found = np.searchsorted(self._codes, code)
        there = (one >= 0) & (other >= 0) & (np.append(self._codes, -1)[found] == code)
        return np.ascontiguousarray(np.where(there, found, -1), dtype=np.int32)

    def matrix(self, values: Array) -> sp.csr_matrix:
        """Give the matrix of the values ``(entries,)``."""
        from scipy.sparse import csr_matrix  # noqa: PLC0415  (slow to import, and `check` needs none)

        return csr_matrix((values, self.indices, self.indptr), shape=(self.size, self.size))

    def dense(self, values: Array) -> Array:
        """Give whole matrices ``(..., size, size)`` of the values ``(..., entries)``."""
        whole = np.zeros((*values.shape[:-1], self.size * self.size))
        whole[..., self._codes] = values
        return whole.reshape(*values.shape[:-1], self.size, self.size)

    def times(self, values: Array, vectors: Array) -> Array:
        """Multiply the matrices of ``(instants, entries)`` by one vector each ``(instants, size)``."""
        return np.add.reduceat(values * vectors[:, self.indices], self.indptr[:-1], axis=1)
