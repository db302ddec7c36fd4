"""Positions of a cycle, and whether a function of the drive angle changes between them in a way that they miss."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.scene.formulas.expression import Formula
from fenics_mech.scene.formulas.interval import bounds_over

CELL_POINTS, CELL_WEIGHTS = ((1 + np.polynomial.legendre.leggauss(6)[0]) / 2, np.polynomial.legendre.leggauss(6)[1] / 2)


@dataclass(frozen=True)
class SamplingLimits:
    """Limits of how finely a function of the drive angle is looked at."""

    missed: float = 0.1  # share of a function's variance that fewer of them may miss
    rounding: float = 1e-12  # of a function's square, below which it has no variance
    largest_cell: float = 1e-6  # of a formula's integral over the cycle that one of its pieces may hide
    nothing_known: float = 1e-3  # of the largest hidden integral: counts as the whole one where that is not known
    narrowest: float = 1e-14  # rad, of pieces: rounding of angles is 1e-15
    samples: int = 2**17  # of a function in a cycle: one for each 48 microrad
    pieces: int = 4096  # equal parts of a cycle that are looked at, at least
    same: float = 1e-9  # rad between drive angles, or difference of values, that counts as none
    unresolved: float = 0.1  # of the largest value of a factor, that points of a cycle may miss before that is remarked


SAMPLING = SamplingLimits()


@dataclass(frozen=True, eq=False)
class SampledFunction:
    """A function of the drive angle at the points of a quadrature over a cycle."""

    angles: Array  # rad, ``(points,)``, and so are the others
    weights: Array  # rad, which add up to 2 pi
    values: Array

    def mean(self, values: Array) -> float:
        """Mean of other values at the points over the cycle."""
        return float(self.weights @ values) / TURN

    @property
    def variance(self) -> float:
        """Mean square of the difference from the mean."""
        return self.mean((self.values - self.mean(self.values)) ** 2)

    @classmethod
    def equally(cls, values: Array) -> SampledFunction:
        """Take values at equal steps of a cycle from 0 on."""
        step = TURN / len(values)
        return cls(step * np.arange(len(values), dtype=float), np.full(len(values), step), values)

    @classmethod
    def between(cls, edges: Array, function: Callable[[Array], Array]) -> SampledFunction:
        """Take Gauss points between ascending angles, 0 to 2 pi: they integrate the square of degree 5 exactly."""
        angles, weights = gauss_points(edges)
        return cls(angles, weights, function(angles))


def gauss_points(edges: Array) -> tuple[Array, Array]:
    """Give points and weights of Gauss-Legendre quadrature between ascending edges, ``(6 pieces,)`` each."""
    width = np.diff(edges)[:, None]
    return (edges[:-1, None] + width * CELL_POINTS).ravel(), (width * CELL_WEIGHTS).ravel()


def enough_angles(values_at: Callable[[int], Array], whole: SampledFunction, least: int, jumps: bool = False) -> int:
    """Number of equal parts of a cycle, at least so many, at whose ends a function shows what it does inside them."""
    # They show it where they, and those in the middle between them, have its variance: a pulse is between neither. What
    # does not jump also has to be near the straight lines through both: a harmonic beyond them looks like a low one.
    variance, count = whole.variance, least
    allowed = SAMPLING.missed * max(variance, SAMPLING.rounding * whole.mean(whole.values**2))
    while count < SAMPLING.samples:
        seen = values_at(2 * count)
        same = np.abs(seen.reshape(count, 2).var(axis=0) - variance) <= allowed
        if np.all(same) and (jumps or whole.mean((whole.values - _lines(seen, whole.angles)) ** 2) <= allowed):
            break
        count *= 2
    return count


def equal_steps(count: int) -> Array:
    """Angles (rad) at so many equal steps of a cycle, from 0 on, ``(count,)``."""
    return TURN / count * np.arange(count, dtype=float)


def _lines(seen: Array, angles: Array) -> Array:
    """Values at angles (rad) on straight lines between equally spaced ones."""
    return np.interp(angles * (len(seen) / TURN), np.arange(len(seen) + 1), [*seen, seen[0]])


@lru_cache(maxsize=32)
def pieces_of(text: str, *, of_second: bool = False) -> Array:
    """Give edges (rad) of pieces of a cycle in which a formula of theta, or its second derivative, hides no peak."""
    formula, edges = Formula(text, ("theta",)), np.linspace(0.0, TURN, SAMPLING.pieces + 1)
    while len(edges) < SAMPLING.samples:
        low, high = bounds_over(formula, edges[:-1], edges[1:], of_second=of_second)
        width = np.diff(edges)
        hidden = (high - low) * width
        least = float(np.abs(np.clip(0.0, low, high)) @ width)  # that the integral of the magnitude is
        largest = float(hidden[np.isfinite(hidden)].max(initial=0.0))
        most_hidden = SAMPLING.largest_cell * max(least, SAMPLING.nothing_known * largest)
        wide = (hidden > most_hidden) & (width > SAMPLING.narrowest)
        if not wide.any():
            break
        edges = np.sort(np.concatenate([edges, (edges[:-1] + edges[1:])[wide] / 2]))
    return edges
