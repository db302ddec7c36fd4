"""Least squares with the covariance of what they find: what data tell of variables, and what they do not.

Source: Bard, Nonlinear Parameter Estimation, 1974, chapters 5 and 7; Seber and Wild, Nonlinear Regression, 1989,
chapter 5.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index

Truths = NDArray[np.bool_]
TINY = float(np.finfo(float).eps)
ROUNDS = 20  # of estimates of the noise
SAME = 1e-3  # change of the noise, at which they end
LEAST_NOISE = 1e-9  # of the size of the measured values
UNTOLD = 1 / math.sqrt(12)  # deviation of a value that may be anywhere in its range, as a share of that
PART = 0.3  # of a direction of length 1, from which a variable belongs to it
SHARE = 0.95  # of the intervals that hold the truth


@dataclass(frozen=True)
class Noisy:
    """Measured values in groups, each with noise of one size."""

    values: Array  # the values, ``(points,)``
    group: Index  # the group of each, ``(points,)``
    known: Array  # standard deviation of the noise of each group; NaN where it is to be estimated, ``(groups,)``

    def noise(self, difference: Array, variables: int) -> Array:
        """Standard deviation of the noise of each group, known or from the differences, ``(groups,)``."""
        count = np.bincount(self.group, minlength=len(self.known))
        square = np.bincount(self.group, difference**2, minlength=len(self.known))
        size = np.bincount(self.group, self.values**2, minlength=len(self.known))
        free = count * max(1.0 - variables / len(self.values), TINY)  # degrees of freedom
        found = np.sqrt(np.maximum(square / free, LEAST_NOISE**2 * size / count))
        found = np.where(found > 0, found, 1.0)
        return np.where(np.isnan(self.known), found, self.known)


@dataclass(frozen=True)
class Fit:
    """What least squares found, for variables from 0 to 1."""

    at: Array  # the variables, ``(variables,)``
    predicted: Array  # predicted values there, ``(points,)``
    slopes: Array  # their derivatives, ``(points, variables)``
    noise: Array  # standard deviation of the noise of each group, ``(groups,)``
    data: Noisy  # what was measured
    converged: bool = True  # whether the search came to its end, and the noise settled

    @property
    def weighted(self) -> Array:
        """Differences of measured and predicted values, in units of their noise, ``(points,)``."""
        return (self.data.values - self.predicted) / self.noise[self.data.group]

    @property
    def freedom(self) -> int:
        """Degrees of freedom: points less variables."""
        return len(self.data.values) - len(self.at)

    @cached_property
    def directions(self) -> tuple[Array, Array]:
        """Directions in which the data tell less and less, as columns, and the deviation along each."""
        # They are the right singular vectors of the weighted derivatives, and one over its singular values.
        _, sizes, rows = np.linalg.svd(self.slopes / self.noise[self.data.group][:, None])
        sizes = np.concatenate([sizes, np.zeros(len(self.at) - len(sizes))])
        with np.errstate(divide="ignore"):
            return rows.T, 1 / sizes

    @property
    def untold(self) -> Array:
        """Directions along which the data tell no more than the bounds do, ``(variables, directions)``."""
        directions, deviation = self.directions
        return directions[:, deviation > UNTOLD]

    @property
    def told(self) -> Truths:
        """Which variables the data tell: those that no untold direction has a part in, ``(variables,)``."""
        return np.asarray(np.all(np.abs(self.untold) < PART, axis=1))

    @property
    def covariance(self) -> Array:
        """Covariance of the variables, ``(variables, variables)``: the inverse of J'J, with weighted derivatives J."""
        # Along directions that the data do not tell, a value may be anywhere in its range.
        directions, deviation = self.directions
        return (directions * np.minimum(deviation, UNTOLD) ** 2) @ directions.T

    @property
    def reach(self) -> float:
        """Half the width of a confidence interval in standard deviations, by Student's t where noise is estimated."""
        from scipy.stats import norm, t  # noqa: PLC0415  (slow to import)

        end = (1 + SHARE) / 2
        return float(t.ppf(end, self.freedom) if np.isnan(self.data.known).any() else norm.ppf(end))


def fit(
    predict: Callable[[Array], Array], slopes: Callable[[Array], Array], data: Noisy, start: Array, tolerance: float
) -> Fit:
    """Fit variables from 0 to 1 to measured values, by predictions ``(points,)`` and slopes ``(points, variables)``."""
    from scipy.optimize import least_squares  # noqa: PLC0415  (slow to import)

    def search(at: Array, scale: Array) -> tuple[Array, bool]:
        found = least_squares(
            lambda x: (predict(x) - data.values) / scale,
            np.clip(at, 1e-9, 1 - 1e-9),  # a start is inside of the bounds
            jac=lambda x: slopes(x) / scale[:, None],
            bounds=(0, 1),
            xtol=tolerance,
            ftol=tolerance,
            gtol=None,
        )
        return np.asarray(found.x), bool(found.status > 0)

    count = len(start)
    noise, at = data.noise(data.values - predict(start), count), start
    ended = settled = False
    for _ in range(ROUNDS):
        (at, ended), before = search(at, noise[data.group]), noise
        noise = data.noise(data.values - predict(at), count)
        if settled := len(noise) == 1 or np.allclose(noise, before, rtol=SAME, atol=0):
            break
    return Fit(at, predict(at), slopes(at), noise, data, ended and settled)
