"""Types of arrays, and products and sums of whole arrays over the drive angles."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Numbers = TypeVar("Numbers", NDArray[np.float64], NDArray[np.complex128])


def times(matrices: Array, vectors: Array) -> Array:
    """One matrix times one vector at each place of the leading axes: ``(..., i, j)`` by ``(..., j)``."""
    return (matrices @ vectors[..., None])[..., 0]


def solved(matrices: Array, vectors: Array) -> Array:
    """Solve with one matrix for one vector at each place of the leading axes: ``(..., i, j)`` and ``(..., i)``."""
    return np.asarray(np.linalg.solve(matrices, vectors[..., None])[..., 0], dtype=np.float64)


def turned(vectors: Array, angle: Array) -> Array:
    """Turn vectors ``(..., 2)`` counter-clockwise by angles ``(...,)``; both may lack axes of the other."""
    c, s, x, y = np.cos(angle), np.sin(angle), vectors[..., 0], vectors[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def norms(vectors: Array) -> Array:
    """Lengths of vectors of one or two numbers, ``(..., 2)``: several times as fast as by NumPy's norm."""
    squares = vectors[..., 0] ** 2
    for i in range(1, vectors.shape[-1]):
        squares += vectors[..., i] ** 2
    return np.sqrt(squares)


def each(matrices: Array, vectors: Array) -> Array:
    """One matrix per element times its vector at each angle: ``(elements, i, j)`` by ``(angles, elements, j)``."""
    found = np.empty((*vectors.shape[:2], matrices.shape[1]), np.result_type(matrices, vectors))
    np.matmul(vectors.transpose(1, 0, 2), matrices.transpose(0, 2, 1), out=found.transpose(1, 0, 2))  # as BLAS takes it
    return found


def summed(values: Numbers, place: Index, size: int) -> Numbers:
    """Sum the entries of the last axis that share a place: ``(..., entries)`` to ``(..., size)``."""
    from scipy.sparse import csr_matrix  # noqa: PLC0415  (slow to import)

    to = csr_matrix((np.ones(len(place)), (np.arange(len(place)), place)), shape=(values.shape[-1], size))
    return np.asarray((values.reshape(-1, values.shape[-1]) @ to).reshape(*values.shape[:-1], size))
