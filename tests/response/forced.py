"""Periodic motions of Duffing's oscillator ``q'' + c q' + q + b q^3 = F cos w t`` by their Fourier coefficients."""

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import root

ORDERS = np.arange(1, 10, 2)
ANGLES = 2 * np.pi * np.arange(64) / 64
COSINE, SINE = np.cos(np.outer(ANGLES, ORDERS)), np.sin(np.outer(ANGLES, ORDERS))


def lack(coefficients, rate, damping, cubic, force):
    """Galerkin's conditions for the harmonics 1, 3 ... 9; 64 points are exact for the cube of the 9th."""
    a, b = coefficients.reshape(2, -1)
    q, first = COSINE @ a + SINE @ b, rate * (COSINE @ (ORDERS * b) - SINE @ (ORDERS * a))
    second = -(rate**2) * (COSINE @ (ORDERS**2 * a) + SINE @ (ORDERS**2 * b))
    left = second + damping * first + q + cubic * q**3 - force * np.cos(ANGLES)
    return np.concatenate([COSINE.T @ left, SINE.T @ left]) / 32


def folds(damping, cubic, force):
    """The rates w at which the resonance curve folds, and the amplitudes of the first harmonic there, ``(folds, 2)``.

    The delay of the first harmonic rises all along the curve, from 0 to pi, and is its parameter here.
    """
    delays = np.linspace(0.1, 3.0, 291)
    known = np.zeros(2 * len(ORDERS) + 1)
    known[-1] = np.sqrt(1 + (damping / np.tan(delays[0]) / 2) ** 2) - damping / np.tan(delays[0]) / 2
    size = force / (1 - known[-1] ** 2)
    known[0], known[len(ORDERS)] = size * np.cos(delays[0]), size * np.sin(delays[0])
    found = []
    for delay in delays:

        def conditions(x, delay=delay):
            across = x[0] * np.sin(delay) - x[len(ORDERS)] * np.cos(delay)
            return np.append(lack(x[:-1], x[-1], damping, cubic, force), across)

        solved = root(conditions, known, tol=1e-12)
        if not solved.success:  # a step that is too long for Powell's method
            solved = root(conditions, known, method="lm", tol=1e-14)
        assert np.abs(conditions(solved.x)).max() < 1e-9
        known = solved.x
        found.append((known[-1], np.hypot(known[0], known[len(ORDERS)])))
    curve = CubicSpline(delays, found)
    at = CubicSpline(delays, np.array(found)[:, 0]).derivative().roots(extrapolate=False)
    return curve(at)
