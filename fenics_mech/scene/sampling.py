"""Positions of a cycle, and whether a function of the drive angle does something between them that they miss."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
CYCLE = 2 * math.pi
SAMPLES, SEEN = 2**17, 0.1  # of a function in a cycle; share of its variance that fewer of them may miss
ANGLES = CYCLE / SAMPLES * np.arange(SAMPLES)  # of the samples
ROUNDING = 1e-12  # of a function's square, below which it has no variance


def enough_angles(function: Callable[[Array], Array], whole: Array, least: int, jumps: bool = False) -> int:
    """Number of equal parts of a cycle, at least so many, at whose ends a function shows what it does inside them.

    They show it where they, and those in the middle between them, have its variance: a pulse is between neither. What
    does not jump also has to be near the straight lines through both: a harmonic beyond them looks like a low one.
    `whole` is the function at `ANGLES`.
    """
    variance, count = whole.var(), least
    slack = SEEN * max(variance, ROUNDING * float(np.mean(whole**2)))
    while count < SAMPLES:
        seen = function(CYCLE / count * np.arange(0, count, 0.5))
        same = np.abs(seen.reshape(count, 2).var(axis=0) - variance) <= slack
        if np.all(same) and (jumps or np.mean((whole - _lines(seen)) ** 2) <= slack):
            break
        count *= 2
    return count


def _lines(seen: Array) -> Array:
    """Values at `SAMPLES` on straight lines between equally spaced ones."""
    return np.interp(np.arange(SAMPLES) * (len(seen) / SAMPLES), np.arange(len(seen) + 1), [*seen, seen[0]])
