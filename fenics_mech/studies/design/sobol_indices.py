"""Sobol indices: which share of the variance of a number comes from which variable.

Source: Saltelli, Annoni, Azzini, Campolongo, Ratto and Tarantola, Computer Physics Communications 181 (2010) 259.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array

RESAMPLES = 200  # of the bootstrap
TINY = np.finfo(float).tiny
SHARE = 0.95  # of the intervals that hold the truth


@dataclass(frozen=True)
class SobolIndices:
    """Shares of a variance.

    Parameters
    ----------
    first
        Share that a variable brings by itself, ``(variables,)``.
    total
        Share that would go if the variable did not scatter: its own, and those with others, ``(variables,)``.
    doubt
        Half the width of their 95 % intervals, by bootstrap: of the first and the total one, ``(2, variables)``.
    """

    first: Array
    total: Array
    doubt: Array


def saltelli_points(samples: Array) -> Array:
    """Give the points for `sobol_indices`, ``(samples, variables + 2, variables)``.

    Points 0 and 1 of each sample are independent. Each other one is the first with one variable of the second.

    Parameters
    ----------
    samples
        Random or quasi-random points, ``(samples, 2 variables)``.
    """
    first, second = np.split(samples, 2, axis=1)
    mixed = np.repeat(first[:, None], first.shape[1], axis=1)
    which = np.arange(first.shape[1])
    mixed[:, which, which] = second
    return np.concatenate([first[:, None], second[:, None], mixed], axis=1)


def sobol_indices(values: Array, seed: int = 0) -> SobolIndices:
    """Give the Sobol indices of a number.

    Parameters
    ----------
    values
        The number at the points of `saltelli_points`, ``(samples, variables + 2)``. Samples with NaN are left out.
    seed
        Of the bootstrap.

    Examples
    --------
    >>> points = saltelli_points(np.random.default_rng(0).random((4096, 4)))
    >>> found = sobol_indices(points[..., 0] + 2 * points[..., 1])  # variances of 1 to 4
    >>> bool(np.allclose(found.first, [0.2, 0.8], atol=0.03))
    True
    """
    values = values[np.isfinite(values).all(axis=1)]
    if len(values) < 2 or np.ptp(values[:, :2]) == 0:
        nothing = np.full(values.shape[1] - 2, np.nan)
        return SobolIndices(nothing, nothing, np.stack([nothing, nothing]))
    drawn = np.random.default_rng(seed).integers(len(values), size=(RESAMPLES, len(values)))
    again = np.array([_estimates(values[rows]) for rows in drawn])
    low, high = np.nanquantile(again, [(1 - SHARE) / 2, (1 + SHARE) / 2], axis=0)
    first, total = _estimates(values)
    return SobolIndices(first, total, (high - low) / 2)


def _estimates(values: Array) -> Array:
    """First and total indices, ``(2, variables)``."""
    values = values - values[:, :2].mean()  # the mean costs accuracy
    first, second, mixed = values[:, :1], values[:, 1:2], values[:, 2:]
    variance = np.maximum(values[:, :2].var(), TINY)
    own = (second * (mixed - first)).mean(axis=0) / variance  # Saltelli et al., table 2 (b)
    total = ((first - mixed) ** 2).mean(axis=0) / (2 * variance)  # Jansen; table 2 (f)
    return np.stack([own, total])
