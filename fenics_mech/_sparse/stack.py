"""Sparse square matrices of one pattern, one at each position, and their factors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fenics_mech._arrays import Array, Index
from fenics_mech._guard import require_memory
from fenics_mech._sparse.kernels import LANES, kernels, pointer
from fenics_mech._sparse.pattern import Pattern
from fenics_mech.errors import SolverError

DENSE = 46  # full matrices of a position that a solver holds at a time: measured, 43, and transitions of its steps


@dataclass(frozen=True, eq=False)
class Stack:
    """Matrices of one pattern.

    Parameters
    ----------
    pattern
        Where they have numbers.
    values
        These, ``(positions, nonzeros)``.
    """

    pattern: Pattern
    values: Array

    @property
    def size(self) -> int:
        """Rows of each matrix."""
        return self.pattern.size

    def __len__(self) -> int:
        """Number of positions."""
        return len(self.values)

    def __getitem__(self, positions: slice | Index) -> Stack:
        """Give the matrices at some of the positions."""
        return replace(self, values=self.values[positions])

    def __add__(self, other: Stack) -> Stack:
        """Add matrices of the same size, whatever their patterns."""
        if other.pattern is self.pattern:
            return replace(self, values=self.values + other.values)
        if len(self.values) != len(other.values):  # the compiled sum trusts it
            raise ValueError(f"{len(self.values)} matrices cannot be added to {len(other.values)}")
        joined = self.pattern.joined(other.pattern)
        if joined is other.pattern:
            return other + self
        values = self.values.copy() if joined is self.pattern else self.on(joined).values
        return Stack(joined, other.added_on(joined, values))

    def __mul__(self, factor: float) -> Stack:
        """Multiply all matrices by a number."""
        return replace(self, values=factor * self.values)

    __rmul__ = __mul__

    def scaled(self, by: Array) -> Stack:
        """Multiply rows and columns by a number each, ``(size,)``."""
        return replace(self, values=self.values * (by[self.pattern.rows] * by[self.pattern.columns]))

    def on(self, pattern: Pattern) -> Stack:
        """Give the matrices on a pattern with more places, or with more unknowns that have zeros."""
        if pattern is self.pattern:
            return self
        return Stack(pattern, self.added_on(pattern, np.zeros((len(self.values), len(pattern.rows)))))

    def added_on(self, pattern: Pattern, values: Array) -> Array:
        """Add the nonzeros to those of a pattern that has their places, ``(positions, nonzeros)``, which change."""
        module, given, count = kernels(1), np.ascontiguousarray(self.values), len(self.pattern.rows)
        places = pattern.places(self.pattern.rows, self.pattern.columns)
        pairs = (part.astype(np.int32) for part in (np.arange(count), np.zeros(count), places))
        numbers, one, result = (pointer(module, part) for part in (given, np.ones(1), values))
        lists = (pointer(module, part) for part in pairs)
        module.lib.products(len(values), count, *lists, numbers, count, one, 0, result, len(pattern.rows))
        return values

    def times(self, vectors: Array) -> Array:
        """Give the products with vectors, ``(positions, ..., size)``."""
        module, given = kernels(1), np.ascontiguousarray(vectors, dtype=float)
        result, many = np.empty_like(given), given.size // max(1, len(given) * self.size)
        arrays = (pointer(module, part) for part in (np.ascontiguousarray(self.values), given, result))
        module.lib.multiply(self.pattern.layout.of(module), len(given), many, *arrays)
        return result

    @cached_property
    def magnitude(self) -> Stack:
        """The matrices of absolute values."""
        return replace(self, values=np.abs(self.values))

    @cached_property
    def diagonal(self) -> Array:
        """Diagonals, ``(positions, size)``."""
        return self.values[:, self.pattern.diagonal]

    @property
    def transposed(self) -> Stack:
        """The transposed matrices."""
        return replace(self, values=self.values[:, self.pattern.mirrored])

    def at(self, position: int) -> sp.csr_matrix:
        """Give the matrix at one position."""
        pointers = np.searchsorted(self.pattern.rows, np.arange(self.size + 1))
        return sp.csr_matrix((self.values[position], self.pattern.columns, pointers), shape=(self.size,) * 2)

    def dense(self, position: int) -> Array:
        """Give the matrix at one position as a whole, ``(size, size)``."""
        whole = np.zeros((self.size, self.size))
        whole[self.pattern.rows, self.pattern.columns] = self.values[position]
        return whole

    @property
    def full(self) -> Array:
        """All matrices as a whole, ``(positions, size, size)``: for few unknowns only."""
        what = f"the matrices of {len(self.values)} positions with {self.size} degrees of freedom"
        require_memory(DENSE * len(self.values) * self.size**2, what, "Take fewer sub_intervals or elements")
        whole = np.zeros((len(self.values), self.size, self.size))
        whole[:, self.pattern.rows, self.pattern.columns] = self.values
        return whole

    @cached_property
    def factors(self) -> Factors:
        """Factors of all matrices."""
        return factorised(self)

    def solve(self, right: Array) -> Array:
        """Solve for right-hand sides ``(positions, ..., size)``; answers have their shape."""
        return self.factors.solve(right)


@dataclass(frozen=True, eq=False)
class Factors:
    """Factors of the matrices of a stack, without exchange of rows.

    Parameters
    ----------
    pattern
        The pattern of the matrices.
    values
        The blocks, ``(positions, blocks)``.
    """

    pattern: Pattern
    values: Array

    @property
    def pivots(self) -> Array:
        """Pivots, ``(positions, size)``: a symmetric matrix is positive where all are (Sylvester)."""
        return 1 / self.values[:, : self.pattern.size]

    def solve(self, right: Array) -> Array:
        """Solve for right-hand sides ``(positions, ..., size)``; answers have their shape."""
        answer = np.array(right, dtype=float, order="C")
        module, work = kernels(1), np.empty(LANES * self.pattern.size)
        many = answer.size // max(1, len(answer) * answer.shape[-1])
        arrays = (pointer(module, part) for part in (self.values, answer, work))
        module.lib.solve(self.pattern.layout.of(module), len(answer), many, *arrays)
        return answer


def factorised(stack: Stack) -> Factors:
    """Factorise all matrices of a stack."""
    module = kernels(1)
    factors = np.empty((len(stack.values), stack.pattern.elimination.blocks))
    values = np.ascontiguousarray(stack.values)
    null = module.ffi.NULL
    record, work = stack.pattern.layout.of(module), np.empty(LANES * factors.shape[1])
    given, made, beside = (pointer(module, part) for part in (values, factors, work))
    singular = module.lib.factor(record, len(values), given, null, null, null, null, null, made, beside)
    if singular >= 0:
        raise SingularError(singular)
    return Factors(stack.pattern, factors)


class SingularError(SolverError):
    """A matrix is singular at a position."""

    def __init__(self, position: int) -> None:
        super().__init__(f"the matrix at position {position} is singular")
        self.position = position
