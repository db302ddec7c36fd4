"""What views of a sweep tell about its points: values in units as they were written, and whether the theory holds."""

from __future__ import annotations

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.accuracy.validity import VALIDITY
from fenics_mech.effects import EFFECTS
from fenics_mech.views.tables import number

BEYOND = "outside the theory"


def written(data: xr.Dataset, path: str) -> Array:
    """Give the values of a swept field in the unit in which its range was written."""
    return data[path].to_numpy().astype(float) / data[path].attrs["written_factor"]


def edges(x: Array) -> Array:
    """Give the ends of the range and the middles between its points: what surrounds each point."""
    return np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]])


def written_unit(data: xr.Dataset, path: str) -> str:
    """Give the unit in which the range of a swept field was written; nothing where it has none."""
    unit = str(data[path].attrs["written_units"])
    return "" if unit == "1" else unit


def named(data: xr.Dataset, path: str) -> str:
    """Name a swept field with its unit, if it has one, as a heading."""
    unit = written_unit(data, path)
    return f"{path} ({unit})" if unit else path


def range_of(data: xr.Dataset, path: str, first: int, last: int) -> str:
    """Say from which of its values to which a swept field goes, with the unit."""
    values = written(data, path)
    text = number(values[first]) if first == last else f"{number(values[first])} to {number(values[last])}"
    return f"{text} {written_unit(data, path)}".strip()


def beyond_theory(data: xr.Dataset) -> xr.DataArray:
    """Tell which points have more deflection or axial force than the theory of their effects is good for."""
    effects = data["effects"].astype(str)
    if "rotation" not in data:  # no point has a result
        return xr.zeros_like(effects, dtype=bool)
    exact, carried = (
        effects.str.contains("|".join(effect.name for effect in EFFECTS.values() if known(effect)))
        for known in (lambda effect: effect.nonlinear, lambda effect: effect.stress_stiffening)
    )
    euler, bow, turn = (data[name].max("member") for name in ("euler_ratio", "bow", "rotation"))
    linear = (bow > VALIDITY.bow) | (~carried & (euler > VALIDITY.euler_ratio))
    return xr.where(exact, turn > VALIDITY.rotation, linear)
