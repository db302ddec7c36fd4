"""Shape functions of a beam element of length 1 (4.5)-(4.10), as polynomials of xi = x/L."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Polynomial

from fenics_mech._arrays import Array

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
    # xi (...)
    return np.stack([f(xi) for f in functions], axis=-1)


def integral(functions: tuple[Polynomial, ...], xi: Array, times: int = 1) -> Array:
    """Repeated integrals of functions from 0, ``(..., functions)``."""
    # xi (...)
    powers = np.arange(max(len(f.coef) for f in functions))
    coefficients = np.zeros((len(functions), len(powers)))
    for row, f in zip(coefficients, functions):
        row[: len(f.coef)] = f.coef
    coefficients /= np.prod(powers[:, None] + np.arange(1, times + 1), axis=1)
    return xi[..., None] ** (powers + times) @ coefficients.T


def between_fixed_ends(functions: tuple[Polynomial, ...], xi: Array) -> Array:
    """Answers of ``u'' = f_j`` with u = 0 at both ends of the unit element, ``(places, functions)``."""
    # xi (places,)
    at_end = integral(functions, np.ones(1), 2)
    return integral(functions, xi, 2) - at_end * xi[:, None]


def between_clamped_ends(functions: tuple[Polynomial, ...], xi: Array) -> Array:
    """Deflections of the unit element with clamped ends under spread loads, ``(places, functions)``."""
    value, slope, x = *(integral(functions, np.ones(1), order) for order in (4, 3)), xi[:, None]
    return integral(functions, xi, 4) - (3 * value - slope) * x**2 - (slope - 2 * value) * x**3
