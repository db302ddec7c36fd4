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
    """Shares of a variance."""

    first: Array  # share that a variable brings by itself, ``(variables,)``
    # share that would go if the variable did not scatter: its own, and those with others, ``(variables,)``
    total: Array
    # half the width of their 95 % intervals, by bootstrap: of the first and the total one, ``(2, variables)``
    doubt: Array


def saltelli_points(samples: Array) -> Array:
    """Give the points for `sobol_indices`, ``(samples, variables + 2, variables)``."""
    # Points 0 and 1 of each sample are independent. Each other one is the first with one variable of the second.
    first, second = np.split(samples, 2, axis=1)
    mixed = np.repeat(first[:, None], first.shape[1], axis=1)
    which = np.arange(first.shape[1])
    mixed[:, which, which] = second
    return np.concatenate([first[:, None], second[:, None], mixed], axis=1)


def sobol_indices(values: Array, seed: int = 0) -> SobolIndices:
    """Give the Sobol indices of a number from its values at `saltelli_points`, ``(samples, variables + 2)``."""
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
