"""Beam elements with places inside: polynomials of higher degree, so that one element makes a member."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import legvander

from fenics_mech._arrays import Array

MOST = 4  # places inside of which there are kernels: see `_kernels/build.py`
TAPERED = 6  # points more than places inside: exact for products of two shapes and a cubic, as of a taper's EI
Along = float | Callable[[Array], Array]  # a number of the section, or by the share of the length


@dataclass(frozen=True)
class Shapes:
    """Polynomials through the place and the first axis of both ends, and through even places inside.

    Their order is that of the vectors that they weigh: place and axis times length of both ends, then places inside.

    Parameters
    ----------
    inner
        Places inside.
    """

    inner: int

    @property
    def places(self) -> Array:
        """Shares of the length at which the places lie ``(inner,)``."""
        return np.arange(1, self.inner + 1) / (self.inner + 1)

    @cached_property
    def _coefficients(self) -> Array:
        """Of the powers of the share, ``(powers, shapes)``."""
        ends = np.array([0.0, 1.0])
        conditions = np.concatenate([self._powers(ends, 0), self._powers(ends, 1), self._powers(self.places, 0)])
        order = [0, 2, 1, 3, *range(4, 4 + self.inner)]  # place and axis of the first end, then of the second
        return np.asarray(np.linalg.inv(conditions[order]))

    def _powers(self, x: Array, derivative: int) -> Array:
        powers = np.arange(4 + self.inner)
        factor = np.prod([np.maximum(powers - k, 0) for k in range(derivative)], axis=0)
        return np.asarray(factor * x[:, None] ** np.maximum(powers - derivative, 0))

    def at(self, x: Array, derivative: int = 0) -> Array:
        """Give the shapes, or their derivatives, at shares of the length: ``(shares, shapes)``."""
        return self._powers(x, derivative) @ self._coefficients

    def rule(self, more: int) -> tuple[Array, Array]:
        """Points and weights of Gauss's rule with so many points more than places inside."""
        points, weights = np.polynomial.legendre.leggauss(self.inner + more)
        return (points + 1) / 2, weights / 2

    def modes(self, points: Array) -> Array:
        """Legendre polynomials ``(points, 2 + inner)``."""
        return legvander(2 * points - 1, 1 + self.inner)

    def table(self) -> Array:
        """Give what the kernel takes, of each point: weight, derivatives of the shapes but the first, polynomials."""
        # 3 points more than places integrate the square of the slope; with one less, errors are 2 to 20 times as
        # large.
        points, weights = self.rule(3)
        return np.hstack([weights[:, None], self.at(points, 1)[:, 1:], self.at(points, 2)[:, 1:], self.modes(points)])

    def stiffness(self, length: float, EA: Along, EI: Along) -> Array:
        """Give that of the Legendre modes of stretch and turn: both are series of them, put into the energy."""
        points, weights = self.rule(TAPERED)
        whole = np.zeros((3 + 2 * self.inner,) * 2)
        for values, first, count in ((EA, 0, 1 + self.inner), (EI, 1 + self.inner, 2 + self.inner)):
            scaled = self.modes(points)[:, :count] * (2 * np.arange(count) + 1)
            own = slice(first, first + count)
            whole[own, own] = scaled.T @ (scaled * (weights * _values(values, points))[:, None])
            whole[own, own] *= length if first == 0 else 1 / length
        return whole

    def mass(self, length: float, line_mass: Along, rotary: Along = 0.0) -> Array:
        """Give the mass between the vectors ``(4 + inner, 4 + inner)``; sections turn as the axis does."""
        points, weights = self.rule(TAPERED)
        scale = np.array([1, length, 1, length, *[1] * self.inner])
        made = np.zeros((len(scale),) * 2)
        for derivative, values in ((0, line_mass), (1, rotary)):
            shapes = self.at(points, derivative) * scale / length**derivative
            made += length * shapes.T @ (shapes * (weights * _values(values, points))[:, None])
        return made


def _values(given: Along, x: Array) -> Array:
    return np.asarray(given(x)) if callable(given) else np.full(len(x), float(given))
