"""Collocation points in a step, and the Runge-Kutta coefficients that they make."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.polynomial import Legendre, Polynomial

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.scene import Analysis


@dataclass(frozen=True, eq=False)
class Tableau:
    """Coefficients of a collocation method with s points. Those of a scheme and a number of points are one object.

    Parameters
    ----------
    points
        c, places 0..1 in the step, ``(s,)``.
    inner
        A: integrals of the Lagrange polynomials up to each point, ``(s, s)``.
    weights
        b: their integrals over the step, ``(s,)``.
    """

    points: Array
    inner: Array
    weights: Array

    @classmethod
    @cache
    def of(cls, scheme: str, stages: int) -> Tableau:
        """Give the method "gauss" (order 2s, conserves quadratic energies) or "radau" (IIA, order 2s - 1, L-stable).

        Source: Hairer and Wanner, Solving Ordinary Differential Equations II, sections IV.5 and IV.8.

        Parameters
        ----------
        scheme
            "gauss" or "radau".
        stages
            Number s of points.
        """
        legendre = Legendre.basis(stages)
        if scheme == "radau":
            legendre = legendre - Legendre.basis(stages - 1)
        points = (np.sort(legendre.roots().real) + 1) / 2
        lagrange = [part.integ() for part in _lagrange(points)]
        inner = np.stack([integral(points) for integral in lagrange], axis=-1, dtype=np.float64)
        return cls(points, inner, np.array([integral(1) for integral in lagrange]))

    @classmethod
    def of_analysis(cls, analysis: Analysis) -> Tableau:
        """Give the method that an analysis states.

        Parameters
        ----------
        analysis
            States scheme and stages.
        """
        return cls.of(analysis.scheme, analysis.stages)

    @cached_property
    def square(self) -> Array:
        """A^2: the integrals taken twice, ``(s, s)``."""
        return self.inner @ self.inner

    def stage_matrix(self, step: float | Array, mass: Array, damping: Array, stiffness: Array) -> Array:
        """Give ``M + h A C + h^2 A^2 K`` of the accelerations at all points of a step, ``(..., s n, s n)``.

        Parameters
        ----------
        step
            Duration h of each step (s), ``(...)``.
        mass, damping, stiffness
            M, C and K at the points, ``(..., s, n, n)``.

        Source: Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.8.
        """
        s, n = mass.shape[-3:-1]
        h = np.asarray(step)[..., None, None]
        weights = np.stack([h * self.inner, h**2 * self.square], axis=-1)
        parts = np.stack([damping, stiffness], axis=-3).reshape(*damping.shape[:-2], 2, n * n)
        matrix = (weights @ parts).reshape(*mass.shape[:-2], s, n, n)
        matrix[..., np.arange(s), np.arange(s), :, :] += mass
        return np.moveaxis(matrix, -3, -2).reshape(*mass.shape[:-3], s * n, s * n)

    def change(self, angle: Array) -> Array:
        """Give by what share of its angle in a step the steps change a free vibration, ``|R(ix) - exp(ix)| / x``.

        It is like a damping ratio, or a share of the frequency.

        Source: Hairer and Wanner, Solving Ordinary Differential Equations II, (3.2) and (3.3) of section IV.3.

        Parameters
        ----------
        angle
            Angle by which the vibration turns in a step (rad), ``(vibrations,)``.
        """
        z = 1j * np.asarray(angle)[:, None, None]
        ones = np.ones((1, len(self.points), 1))
        end = 1 + (z * self.weights @ np.linalg.solve(np.eye(len(self.points)) - z * self.inner, ones))[:, 0, 0]
        return np.abs(end - np.exp(z[:, 0, 0])) / np.maximum(np.abs(angle), TINY)

    def integrals(self, places: Array) -> Array:
        """Give the Lagrange polynomials' integrals from 0 to other places, ``(places, s)``.

        Parameters
        ----------
        places
            Places in the step, 0..1, ``(places,)``.
        """
        return np.stack([part.integ()(places) for part in _lagrange(self.points)], axis=-1)


def _lagrange(points: Array) -> list[Polynomial]:
    """Give the polynomials that are 1 at one point and 0 at the others."""
    one = Polynomial([1.0])
    nodal = [Polynomial.fromroots(np.delete(points, j)) if len(points) > 1 else one for j in range(len(points))]
    return [polynomial / polynomial(point) for polynomial, point in zip(nodal, points)]
