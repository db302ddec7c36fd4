"""The minimum of a function of one number that takes many at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.kinematics.conditioning import CONDITION


def minimum(function: Callable[[Array], Array], low: float, high: float, within: float) -> tuple[float, float]:
    """Find the minimum between two places by finer and finer samples."""
    # function (places,)
    while True:
        places = np.linspace(low, high, CONDITION.points)
        values = function(places)
        i = int(values.argmin())
        low, high = places[max(i - 1, 0)], places[min(i + 1, CONDITION.points - 1)]
        if high - low <= 2 * within:
            return float(places[i]), float(values[i])
