"""Balance of energy of a motion: what drives and loads give, what damping takes, and what is left over."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY


def balance_of(
    mean: Mapping[str, float], powers: Mapping[str, Array], bound: float = 0.0, share: float = 1.0, least: float = 0.0
) -> xr.Dataset:
    """Label the mean power of every cause (W), and how far they are from a balance."""
    # The imbalance is relative to the largest mean. Where all are smaller, it is relative to a share of the largest
    # power over time, or to the `least` (W). `bound` is what the estimated errors of the efforts make of it (W).
    residual, largest = sum(mean.values()), max(abs(value) for value in mean.values())
    small = max(share * max(float(np.abs(power).mean()) for power in powers.values()), least)
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


def given_by(energy: Array, duration: float) -> float:
    """Give the mean power that an energy gives as it falls over a motion (W)."""
    return -float(energy[-1] - energy[0]) / duration
