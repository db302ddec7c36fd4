"""Where square matrices have numbers, and how they are factorised without many more.

The order of elimination is that of minimum degree, from PETSc.

Source: Davis, Direct Methods for Sparse Linear Systems (2006), ch. 4 and 7.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fenics_mech._arrays import Index
from fenics_mech._petsc import PETSc, to_petsc
from fenics_mech._sparse.kernels import pointer


@dataclass(frozen=True, eq=False)
class Elimination:
    """The factors' pattern, as `kernels.c` describes it."""

    order: Index  # unknown that is eliminated at each turn, (size,)
    # where the blocks below the diagonal of each turn's column begin, (size + 1,), and their rows as turns
    first: Index
    below: Index
    update: Index  # where the updates of each turn begin, (size + 1,), and the block that each changes
    target: Index
    place: Index  # block of each nonzero, (nonzeros,)

    @property
    def blocks(self) -> int:
        """Number of blocks of the factors."""
        return len(self.order) + 2 * len(self.below)


@dataclass(frozen=True, eq=False)
class Pattern:
    """Nonzeros of square matrices: all of the diagonal, and with each its mirror image; by rows.

    Parameters
    ----------
    size
        Rows and columns.
    rows, columns
        Of the nonzeros, ``(nonzeros,)``.
    """

    size: int
    rows: Index
    columns: Index

    @classmethod
    def of(cls, size: int, rows: Index, columns: Index) -> Pattern:
        """Give the smallest pattern with these places; equal places give the same object."""
        here = np.arange(size)
        one, other = np.concatenate([here, rows, columns]), np.concatenate([here, columns, rows])
        keys = np.unique(one * np.int64(size) + other)
        return _pattern(size, keys.tobytes())

    @cached_property
    def keys(self) -> Index:
        """Number of each place, ascending."""
        return self.rows * np.int64(self.size) + self.columns

    @cached_property
    def diagonal(self) -> Index:
        """Nonzeros of the diagonal, ``(size,)``."""
        return self.places(np.arange(self.size), np.arange(self.size))

    @cached_property
    def mirrored(self) -> Index:
        """The mirror image of each nonzero, ``(nonzeros,)``."""
        return self.places(self.columns, self.rows)

    def places(self, rows: Index, columns: Index) -> Index:
        """Give the nonzeros at places that the pattern has."""
        return np.searchsorted(self.keys, rows * np.int64(self.size) + columns)

    def joined(self, other: Pattern) -> Pattern:
        """Give the pattern with the places of both, which are of one size."""
        if other is self:
            return self
        both = np.concatenate([self.rows, other.rows]), np.concatenate([self.columns, other.columns])
        return Pattern.of(self.size, *both)

    @cached_property
    def layout(self) -> CompiledPattern:
        """The pattern for the compiled loops."""
        return CompiledPattern(self)

    @cached_property
    def elimination(self) -> Elimination:
        """How matrices of the pattern are factorised."""
        order = _minimum_degree(self)
        turn = np.argsort(order)
        columns = _filled(self.size, turn[self.rows], turn[self.columns])
        many = np.array([len(column) for column in columns], dtype=np.int64)
        first, update = (np.append(0, np.cumsum(part)) for part in (many, many**2))
        below = np.concatenate([np.zeros(0, dtype=np.int64), *columns])
        keys = np.repeat(np.arange(self.size), many) * np.int64(self.size) + below  # by column, then row: ascending

        def block(i: Index, j: Index) -> Index:
            """Number of the block in row i and column j."""
            low, high = np.minimum(i, j), np.maximum(i, j)
            off = self.size + np.searchsorted(keys, low * np.int64(self.size) + high) + len(below) * (i < j)
            return np.where(i == j, i, off)

        pairs = [np.broadcast_arrays(column[:, None], column) for column in columns]
        target = [block(i.ravel(), j.ravel()) for i, j in pairs]
        return Elimination(
            order=order,
            first=first,
            below=below,
            update=update,
            target=np.concatenate([np.zeros(0, dtype=np.int64), *target]),
            place=block(turn[self.rows], turn[self.columns]),
        )


@dataclass(frozen=True, eq=False)
class CompiledPattern:
    """A pattern as C reads it."""

    pattern: Pattern
    _records: dict[Any, Any] = field(default_factory=dict)

    @cached_property
    def _arrays(self) -> dict[str, NDArray[Any]]:
        pattern, found = self.pattern, self.pattern.elimination
        turn = np.argsort(found.order)
        short = {
            "begin": np.searchsorted(pattern.rows, np.arange(pattern.size + 1)),
            "columns": pattern.columns,
            "place": found.place,
            "order": found.order,
            "turn": turn,
            "first": found.first,
            "below": found.below,
            "target": found.target,
        }
        return {name: part.astype(np.int32) for name, part in short.items()} | {"update": found.update}

    def of(self, module: Any) -> Any:
        """Give the record of a compiled module; it lives as long as this."""
        if module not in self._records:
            self._records[module] = self._record(module)
        return self._records[module]

    def _record(self, module: Any) -> Any:
        record = module.ffi.new("pattern *")
        record.size = self.pattern.size
        record.entries, record.blocks = len(self.pattern.rows), self.pattern.elimination.blocks
        record.below_all = len(self.pattern.elimination.below)
        for name, array in self._arrays.items():
            setattr(record, name, pointer(module, array))
        return record


@lru_cache(maxsize=32)
def _pattern(size: int, keys: bytes) -> Pattern:
    """Give one object for equal patterns, so that each is laid out for elimination once."""
    places = np.frombuffer(keys, dtype=np.int64)
    return Pattern(size, places // size, places % size)


def _minimum_degree(pattern: Pattern) -> Index:
    """Order of elimination of the unknowns."""
    size, places = pattern.size, (pattern.rows, pattern.columns)
    if size < 2 or len(pattern.rows) == size**2:
        return np.arange(size)
    matrix = to_petsc(sp.csr_matrix((np.ones(len(places[0])), places), shape=(size, size)))
    rows, columns = matrix.getOrdering(PETSc.Mat.OrderingType.QMD)
    order = rows.getIndices().astype(np.int64)
    for thing in (rows, columns, matrix):
        thing.destroy()
    return order


def _filled(size: int, rows: Index, columns: Index) -> list[Index]:
    """Rows below the diagonal of each column of the factors, by the elimination tree."""
    lower = rows > columns
    order = np.lexsort((rows[lower], columns[lower]))
    rows, columns = rows[lower][order], columns[lower][order]
    begin = np.searchsorted(columns, np.arange(size + 1))
    found: list[Index] = []
    children: list[list[int]] = [[] for _ in range(size)]
    for j in range(size):
        parts = [rows[begin[j] : begin[j + 1]], *(found[child] for child in children[j])]
        column = np.unique(np.concatenate(parts))
        found.append(column[column > j])
        if len(found[j]):
            children[found[j][0]].append(j)
    return found
