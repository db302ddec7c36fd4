"""Shape functions of a beam element of length 1 (4.5)-(4.10), as polynomials of xi = x/L."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

Array = NDArray[np.float64]
LINEAR = (Polynomial([1, -1]), Polynomial([0, 1]))  # (4.5), (4.8): axial displacement of the two nodes
CUBIC = (  # displacement, rotation times L, of the first node and of the second
    Polynomial([1, 0, -3, 2]),  # (4.6)
    Polynomial([0, 1, -2, 1]),  # (4.7)
    Polynomial([0, 0, 3, -2]),  # (4.9)
    Polynomial([0, 0, -1, 1]),  # (4.10)
)
AXIAL, NORMAL = [0, 3], [1, 2, 4, 5]  # an element's dofs u, w, phi at both nodes: those along its axis, and across


def evaluate(functions: tuple[Polynomial, ...], xi: Array) -> Array:
    """Values of functions, ``(..., functions)``."""
    return np.stack([f(xi) for f in functions], axis=-1)


def integral(functions: tuple[Polynomial, ...], xi: Array, times: int = 1) -> Array:
    """Repeated integrals of functions from 0, ``(..., functions)``."""
    return np.stack([f.integ(times)(xi) for f in functions], axis=-1)
