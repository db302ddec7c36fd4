"""Natural frequencies and critical speeds in words of people."""

from __future__ import annotations

import numpy as np

from fenics_mech.recovery import Result
from fenics_mech.safety.critical_speeds import (
    STRONG,
    CriticalSpeed,
    cause_of,
    critical_speeds,
    multiple_of,
    speeds_to_avoid,
    turns,
)
from fenics_mech.views.words import share, short


def frequency_ranges(result: Result) -> list[tuple[float, float]]:
    """Give the lowest and highest frequency of each mode over the cycle (Hz), 0 of rigid bodies."""
    # They are those of the mechanism held at each position: of the response, or where it has no modes, of the few
    # positions at which critical speeds are sought.
    data = result.data
    if "frequency" in data:
        frequency = data["frequency"].transpose("theta", "mode").to_numpy()
        return [(float(low), float(high)) for low, high in zip(frequency.min(axis=0), frequency.max(axis=0))]
    if "mode_frequency" not in data:
        return []
    ends = np.nan_to_num(data["mode_frequency"].sel(limit=["lowest", "highest"]).transpose("mode", "limit").to_numpy())
    return [(float(low), float(high)) for low, high in ends]


def speeds_in_words(result: Result, most: int = 2) -> str:
    """Name the nearest speeds to avoid below and above the present one; "" where critical speeds are not sought."""
    if why := result.data.attrs.get("critical_speeds_unknown"):
        return f"not known: {why}"
    if not critical_speeds(result):
        return ""
    near = sorted(speeds_to_avoid(result, 1), key=lambda one: abs(one.distance))[:most]
    causes = [  # one alone is told without its link
        cause_of(result, one) if most > 1 else f"{one.numbered} {multiple_of(result, one)}" for one in near
    ]
    said = [f"{band_of(result, one)} ({cause}: {rise_of(one)})" for one, cause in zip(near, causes)]
    orders = float(result.data["critical_order"].max())
    none = f"none: up to {orders:g} times the drive no harmonic makes a mode add {share(STRONG)} to the peak strain"
    return "; ".join(said) or none


def band_of(result: Result, one: CriticalSpeed) -> str:
    """Write the range of a speed to avoid, and whether the present speed is in it."""
    return turns(result, *(one.band or (one.speed, one.speed))) + (", where it runs" if runs_in(result, one) else "")


def runs_in(result: Result, one: CriticalSpeed) -> bool:
    """Say whether the present speed is in the range of a speed to avoid."""
    low, high = one.band or (one.speed, one.speed)
    return low <= abs(result.scene.cycle_rate) <= high


def rise_of(one: CriticalSpeed) -> str:
    """Write what the mode's vibration adds to the peak strain."""
    if not np.isfinite(one.rise):
        return "any strain, as nothing damps it"
    return f"about +{share(one.rise)} strain" if one.rise < 1 else f"about {short(1 + one.rise, 2)} times the strain"
