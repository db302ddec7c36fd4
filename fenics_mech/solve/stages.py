"""Radau IIA collocation of second-order equations: accelerations at the stages are the unknowns of a step."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.polynomial import Polynomial, legendre

from fenics_mech._arrays import Array


@dataclass(frozen=True)
class Tableau:
    """Points and weights of a step of length 1."""

    c: Array  # stages (stages,); the last is the end of the step
    A: Array  # (stages, stages): a rate at the stages is its start plus A times the accelerations
    square: Array  # a A, for the coordinates
    back: Array  # value of the stages' polynomial at the start (stages,)
    # largest error of a coordinate inside the step, by the difference between the acceleration at its start and the
    # stages' polynomial there; from the remainder of interpolation, whose zeros are the stages
    inside: float
    inside_rate: float  # the same of a rate

    @cached_property
    def lead(self) -> float:
        """Share of a step by which an implicit step filters its error: the mean of the eigenvalues of A."""
        return float(np.linalg.det(self.A) ** (1 / len(self.c)))

    @cached_property
    def kinked(self) -> float:
        """As `inside`, where the acceleration has a kink in the step, as where bodies stick or slip: the median."""
        shares, places = np.linspace(0, 1, 201), np.linspace(0.01, 0.99, 99)
        kinks = np.maximum(self.c[:, None] - places, 0)
        errors = self.at(shares)[1] @ self.A @ kinks - np.maximum(shares[:, None] - places, 0) ** 3 / 6
        return float(np.median(np.abs(errors).max(axis=0) / np.abs(self.back @ kinks)))

    def at(self, s: Array) -> tuple[Array, Array]:
        """Give values and integrals from 0 of the stages' polynomial at shares of a step: ``(shares, stages)`` each."""
        stages = len(self.c)
        powers = np.arange(1, stages + 1)
        inverse = np.linalg.inv(np.vander(self.c, stages, increasing=True))
        return np.vander(s, stages, increasing=True) @ inverse, (s[:, None] ** powers / powers) @ inverse


@cache
def radau(stages: int) -> Tableau:
    """Give the tableau of Radau IIA (Hairer and Wanner, Solving ODE II, chapter IV.5): order 2 stages - 1."""
    points = legendre.legroots([0] * (stages - 1) + [-1, 1]).real
    c = (np.sort(points) + 1) / 2
    c[-1] = 1.0
    inverse = np.linalg.inv(np.vander(c, stages, increasing=True))
    integrals = np.array([[x ** (k + 1) / (k + 1) for k in range(stages)] for x in c])
    A = integrals @ inverse
    product = Polynomial.fromroots(c)
    bounds = (np.abs(product.integ(m, [0] * m)(np.linspace(0, 1, 201))).max() / abs(product(0.0)) for m in (2, 1))
    return Tableau(c, A, A @ A, inverse[0], *map(float, bounds))


def stage_matrix(tableau: Tableau, h: float, M: Array, C: Array, K: Array) -> Array:
    """Give the blocks of the matrix of a step's accelerations, stages side by side: M + h A C + h^2 A A K."""
    # `M`, `C` and `K` are (stages, entries); the blocks are (entries, stages, stages).
    blocks = h * tableau.A[None] * C.T[:, :, None] + h * h * tableau.square[None] * K.T[:, :, None]
    i = np.arange(len(tableau.c))
    blocks[:, i, i] = blocks[:, i, i] + M.T
    return np.asarray(blocks)
