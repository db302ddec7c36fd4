"""What is taken of a curve over the cycle, and of its places: the largest size, the least value, and others."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array

REDUCTIONS: dict[str, Callable[[Array], Array]] = {  # of a curve over the positions, ``(positions, places)``
    "max": lambda curve: np.abs(curve).max(axis=0),
    "min": lambda curve: curve.min(axis=0),
    "mean": lambda curve: curve.mean(axis=0),
    "rms": lambda curve: np.sqrt((curve**2).mean(axis=0)),
    "range": lambda curve: np.ptp(curve, axis=0),
}


def reduced(found: xr.DataArray, reduction: str) -> float:
    """Reduce a variable to one number: over the positions first, and then to the worst of the places."""
    # The worst is the largest size, or the least value of "min". Vectors count by their lengths.
    if "component" in found.dims:
        found = ((found**2).sum("component")) ** 0.5
    values = found.transpose("theta", ...).to_numpy() if "theta" in found.dims else found.to_numpy()[None]
    values = values.reshape(len(values), -1).astype(float)
    values = values[:, np.isfinite(values).any(axis=0)]
    if not values.size:
        return math.nan
    over_cycle = REDUCTIONS[reduction](values)
    if reduction == "min":
        return float(np.nanmin(over_cycle))
    return float(over_cycle[np.nanargmax(np.abs(over_cycle))]) if np.isfinite(over_cycle).any() else math.nan
