"""Balance of energy of a motion: what drives and loads give, what damping takes, and what is left over."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.terms.causes import Cause


def balance_of(mean: Mapping[str, float], small: float, bound: float) -> xr.Dataset:
    """Label the mean power of every cause, and how far they are from a balance."""
    # mean: mean power of each cause (W); small: power that the imbalance is relative to where all means are smaller
    # (W); bound: what the estimated errors of the efforts make of the drives' mean power at most (W)
    # Gives `mean_power` (W) by `cause`, and the attributes that `energy_balance` names.
    residual, largest = sum(mean.values()), max(abs(value) for value in mean.values())
    attributes = {
        "power_residual": residual,
        "power_balance_error": abs(residual) / max(largest, small, TINY),
        "power_error": bound,
    }
    return xr.Dataset({"mean_power": (("cause",), list(mean.values()))}, {"cause": list(map(str, mean))}, attributes)


def mean_in_time(time: Array, powers: Mapping[str, Array]) -> dict[str, float]:
    """Give the mean of powers over a motion in time (W), by cubic splines."""
    # time: times (s), ``(times,)``; powers: power of each cause (W), ``(times,)`` each
    from scipy.interpolate import CubicSpline  # noqa: PLC0415  (slow to import, and a cycle needs none)

    duration = float(np.ptp(time))
    return {
        name: float(CubicSpline(time, power).integrate(*time[[0, -1]])) / duration for name, power in powers.items()
    }


def stored(time: Array, energy: Array) -> dict[str, float]:
    """Give minus the mean rate of what motion, links and springs store (W), as the power of `Cause.STORED`."""
    # time: times (s), ``(times,)``; energy: the stored energy (J), ``(times,)``
    return {Cause.STORED: -float(energy[-1] - energy[0]) / float(np.ptp(time))}
