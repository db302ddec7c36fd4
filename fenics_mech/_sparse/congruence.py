"""Matrices over the mechanism's coordinates from those over the links': ``P^T (X0 P + X1 P' + X2 P'')``.

Which entry of P meets which entry of a link matrix, and where their product goes, is found once for all positions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index, summed
from fenics_mech._sparse.kernels import kernels, pointer
from fenics_mech._sparse.pattern import Pattern
from fenics_mech._sparse.stack import Stack


@dataclass(frozen=True, eq=False)
class Congruence:
    """Products of matrices of one pattern with P.

    Parameters
    ----------
    height
        The links' coordinates.
    size
        The mechanism's.
    rows, columns
        Of the nonzeros of P, the rows ascending.
    link_rows, link_columns
        Places of the nonzeros of the link matrices, ascending by rows.
    """

    height: int
    size: int
    rows: Index
    columns: Index
    link_rows: Index
    link_columns: Index

    @classmethod
    def of(
        cls, height: int, size: int, rows: Index, columns: Index, places: Sequence[tuple[Index, Index]]
    ) -> Congruence:
        """Take the places of several matrices or entries together."""
        keys = np.unique(np.concatenate([row * np.int64(height) + column for row, column in places]))
        return cls(height, size, rows, columns, keys // height, keys % height)

    @cached_property
    def _begin(self) -> Index:
        """First nonzero of P in each row, and their number."""
        return np.searchsorted(self.rows, np.arange(self.height + 1))

    @cached_property
    def _keys(self) -> Index:
        """Number of each place of the link matrices, ascending."""
        return self.link_rows * np.int64(self.height) + self.link_columns

    @cached_property
    def _first(self) -> tuple[ProductPairs, Index, Index]:
        """Products of link matrices with P: their pairs, and the rows and columns of their nonzeros."""
        link, of_p = _met(self._begin, self.link_columns)
        keys, target = np.unique(self.link_rows[link] * np.int64(self.size) + self.columns[of_p], return_inverse=True)
        return ProductPairs.of(link, of_p, target), keys // self.size, keys % self.size

    @cached_property
    def _second(self) -> tuple[ProductPairs, Pattern]:
        """Products of P^T with those: their pairs, and the pattern of the matrices over the coordinates."""
        _, rows, columns = self._first
        product, of_p = _met(self._begin, rows)
        pattern = Pattern.of(self.size, self.columns[of_p], columns[product])
        return ProductPairs.of(of_p, product, pattern.places(self.columns[of_p], columns[product])), pattern

    @property
    def pattern(self) -> Pattern:
        """Pattern of the matrices over the coordinates."""
        return self._second[1]

    def values_of(self, rows: Index, columns: Index, values: Array) -> Array:
        """Place entries ``(positions or 1, entries)`` among the nonzeros of the link matrices."""
        places = np.searchsorted(self._keys, rows * np.int64(self.height) + columns)
        return summed(values, places, len(self._keys))

    def values_of_matrix(self, matrix: sp.csr_matrix) -> Array:
        """Place the entries of a constant matrix, ``(1, nonzeros)``."""
        entries = matrix.tocoo()
        return self.values_of(entries.row.astype(np.int64), entries.col.astype(np.int64), entries.data[None])

    def products(self, back: Array, *parts: tuple[Array, Array]) -> Stack:
        """Give ``P^T (X0 P0 + X1 P1 + ...)`` at all positions.

        Parameters
        ----------
        back
            Nonzeros of P on the left, ``(positions, nonzeros)``.
        parts
            Of each term the nonzeros of X, ``(positions or 1, link nonzeros)``, and those of P or a derivative of it.
        """
        first, rows, _ = self._first
        moved = np.zeros((len(back), len(rows)))
        for x, p in parts:
            first.add(x, p, moved)
        second, pattern = self._second
        values = np.zeros((len(back), len(pattern.rows)))
        second.add(back, moved, values)
        return Stack(pattern, values)


def _met(begin: Index, wanted: Index) -> tuple[Index, Index]:
    """Pair each wanted row with all nonzeros of P in that row: numbers of the wanted ones, and of the nonzeros."""
    many = np.diff(begin)[wanted]
    which = np.repeat(np.arange(len(wanted)), many)
    within = np.arange(len(which)) - np.repeat(np.cumsum(many) - many, many)
    return which, begin[wanted[which]] + within


@dataclass(frozen=True, eq=False)
class ProductPairs:
    """Pairs of nonzeros whose products are added up.

    Parameters
    ----------
    left, right, target
        The two nonzeros, and the place of each product, ``(pairs,)``.
    """

    left: NDArray[np.int32]
    right: NDArray[np.int32]
    target: NDArray[np.int32]

    @classmethod
    def of(cls, left: Index, right: Index, target: Index) -> ProductPairs:
        """Put pairs in the order of their places."""
        order = np.argsort(target, kind="stable")
        return cls(*(part[order].astype(np.int32) for part in (left, right, target)))

    def add(self, one: Array, other: Array, result: Array) -> None:
        """Add the products at all positions; `one` may be the same at all of them."""
        module, count = kernels(1), len(result)
        one, other = np.ascontiguousarray(one), np.ascontiguousarray(other)
        assert len(one) in (1, count)
        assert len(other) == count
        module.lib.products(
            count,
            len(self.left),
            *(pointer(module, part) for part in (self.left, self.right, self.target)),
            pointer(module, one),
            0 if len(one) == 1 else one.shape[1],
            pointer(module, other),
            other.shape[1],
            pointer(module, result),
            result.shape[1],
        )
