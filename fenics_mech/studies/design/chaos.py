"""Polynomial chaos: a number as a polynomial of what scatters, by least squares over samples.

The polynomials are orthonormal under the distributions: Legendre's of a uniform one, and nearly Hermite's of a normal
one that is cut. So their coefficients give the variance and its Sobol indices without further samples.

Source: Sudret, Reliability Engineering and System Safety 93 (2008) 964; for the degree by leaving out one sample at a
time Blatman and Sudret, Journal of Computational Physics 230 (2011) 2345.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import comb

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.studies.design.fit import Truths
from fenics_mech.studies.design.scatter import CUT

SAMPLES = 2.0  # for each polynomial, at least
MOST = 12  # largest degree
TERMS = 600  # polynomials at most
NODES = 64  # of the quadrature by which they are made orthonormal
TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class Chaos:
    """A number as a sum of orthonormal polynomials."""

    powers: Index  # degree of each polynomial in each variable, ``(polynomials, variables)``; the first is the constant
    coefficients: Array  # of the polynomials, ``(polynomials,)``
    left: float  # share of the variance of samples that they do not tell, each sample by a fit to all others

    @property
    def degree(self) -> int:
        """Largest degree."""
        return int(self.powers.sum(axis=1).max())

    @property
    def mean(self) -> float:
        """Mean of the number."""
        return float(self.coefficients[0])

    @cached_property
    def deviation(self) -> float:
        """Standard deviation of the number."""
        return float(np.linalg.norm(self.coefficients[1:]))

    @property
    def first(self) -> Array:
        """Share of the variance that each variable brings by itself, ``(variables,)``."""
        acting = self.powers > 0
        return self._share(acting & (acting.sum(axis=1, keepdims=True) == 1))

    @property
    def total(self) -> Array:
        """Share that would go if a variable did not scatter, ``(variables,)``."""
        return self._share(self.powers > 0)

    def _share(self, which: Truths) -> Array:
        square = self.coefficients**2
        return np.asarray(square @ which / max(self.deviation**2, TINY))


def polynomial_chaos(places: Array, values: Array, normal: Truths) -> Chaos | None:
    """Fit polynomials to samples; of all degrees that of the least error counts."""
    # places 0..1 in the ranges of the variables ``(samples, variables)``, values there ``(samples,)``; variables whose
    # distribution is normal, cut at `CUT` deviations ``(variables,)``: others are as likely everywhere
    best: Chaos | None = None
    if not np.ptp(values) > 0:
        return None
    each = np.stack([_orthonormal(place, bool(cut)) for place, cut in zip(places.T, normal)])
    for degree in range(1, MOST + 1):
        powers = _powers(degree, places.shape[1], int(len(values) / SAMPLES))
        if powers is None:
            break
        found = _fitted(each, powers, values)
        if best is None or found.left < best.left:
            best = found
    return best


def _powers(degree: int, variables: int, most: int) -> Index | None:
    """Degrees of all polynomials up to a total degree, the constant first; None where they are too many."""
    if comb(degree + variables, variables) > min(most, TERMS):
        return None
    rows: list[list[int]] = [[]]
    for _ in range(variables):
        rows = [[*row, power] for row, power in product(rows, range(degree + 1)) if sum(row) + power <= degree]
    return np.array(sorted(rows, key=sum), dtype=np.int64)


def _orthonormal(place: Array, cut: bool) -> Array:
    """Orthonormal polynomials of one variable at its samples, ``(samples, most + 1)``."""
    points, weights = np.polynomial.legendre.leggauss(NODES)
    if cut:
        weights = weights * np.exp(-((CUT * points) ** 2) / 2)
    at_points, at_samples = (np.polynomial.legendre.legvander(x, MOST) for x in (points, 2 * place - 1))
    lower = np.linalg.cholesky((at_points.T * (weights / weights.sum())) @ at_points)
    return np.asarray(np.linalg.solve(lower, at_samples.T).T)


def _fitted(each: Array, powers: Index, values: Array) -> Chaos:
    """Fit polynomials by least squares, with the error by leaving out each sample."""
    matrix = np.prod(np.stack([one[:, power] for one, power in zip(each, powers.T)]), axis=0)
    q, r = np.linalg.qr(matrix)
    coefficients = np.linalg.lstsq(r, q.T @ values, rcond=None)[0]
    apart = (values - matrix @ coefficients) / np.maximum(1 - (q**2).sum(axis=1), np.finfo(float).eps)
    return Chaos(powers, coefficients, float((apart**2).mean() / values.var()))
