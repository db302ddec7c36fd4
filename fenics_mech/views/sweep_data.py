"""What views of a sweep tell about its points: values in units as they were written, and whether the theory holds."""

from __future__ import annotations

import json

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.effects import EFFECTS
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.solve.stability_limits import STABILITY
from fenics_mech.studies.sweep_peaks import unresolved
from fenics_mech.views.judgements import level_of_theory
from fenics_mech.views.prefixes import fitted, without_rounding
from fenics_mech.views.tables import number

BEYOND = "outside the theory"


def written(data: xr.Dataset, path: str) -> Array:
    """Give the values of a swept field in the unit in which its range was written."""
    return data[path].to_numpy().astype(float) / data[path].attrs["written_factor"]


def units_of(data: xr.Dataset) -> AnswerUnits:
    """Give the units of a sweep or a branch: those of its scene, or those that fit its peaks."""
    stated = AnswerUnits.of(json.loads(str(data.attrs.get("scene", "{}"))).get("units") or ())
    peaks = {
        name: float(np.nanmax(values, initial=0.0))
        for name in ("peak_joint_force", "peak_input_torque", "peak_stress")
        if (values := data[name].to_numpy() if name in data else np.zeros(0)).size
    }
    force, effort = (peaks.get(name, 0.0) for name in ("peak_joint_force", "peak_input_torque"))
    slides = effort > 0 and data["peak_input_torque"].attrs.get("units") == "N"
    largest = {
        "force": max(force, effort) if slides else force,
        "moment": 0.0 if slides else effort,
        "stress": peaks.get("peak_stress", 0.0),
    }
    return fitted(without_rounding(largest, force), stated)


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


def range_of(data: xr.Dataset, path: str, first: int, last: int | None = None) -> str:
    """Say from which of its values to which a swept field goes, or which it has at one point, with the unit."""
    values = written(data, path)
    text = number(values[first]) if last in (None, first) else f"{number(values[first])} to {number(values[last])}"
    return f"{text} {written_unit(data, path)}".strip()


def unresolved_at(data: xr.Dataset, paths: list[str]) -> Array:
    """Give the places between points, ascending, where peak strains of a sweep are not resolved."""
    if len(paths) != 1 or "peak_strain" not in data:
        return np.zeros(0)
    x, peaks = written(data, paths[0]), data["peak_strain"].transpose(paths[0], "member").to_numpy()
    order = np.argsort(x)
    return np.sort(np.array(unresolved(x[order], peaks[order]), dtype=float))


def unstable_points(data: xr.Dataset) -> xr.DataArray:
    """Tell which points have a motion that no machine stays in, as disturbances of it grow."""
    told = data["error"].copy(data=np.zeros(data["error"].shape, dtype=bool))
    if "unstable" in data:
        told |= data["unstable"].astype(str) != ""
    if "multiplier" in data:
        told |= data["multiplier"].max("disturbance").transpose(*told.dims) > 1 + STABILITY.tolerance
    return told


def without_unstable(data: xr.Dataset) -> xr.Dataset:
    """Give the data with no numbers at points whose motion was refused as unstable."""
    if "unstable" not in data or not bool((refused := data["unstable"].astype(str) != "").any()):
        return data
    numbers = {name: part for name, part in data.data_vars.items() if part.dtype.kind == "f" and part.dims}
    return data.assign({name: part.where(~refused).transpose(*part.dims) for name, part in numbers.items()})


def beyond_theory(data: xr.Dataset) -> xr.DataArray:
    """Tell which points have more deflection or axial force than the theory of their effects is good for."""
    return theory_levels(data) == "bad"


def theory_levels(data: xr.Dataset) -> xr.DataArray:
    """Judge the theory at every point, as `fenics-mech run` does: a level, or "" where there is none."""
    effects = data["effects"].astype(str)
    levels = np.full(effects.shape, "", dtype=object)
    if "rotation" in data:  # a point has a result
        names = "euler_ratio", "bow", "rotation"
        sizes = [data[name].max("member").transpose(*effects.dims).to_numpy() for name in names]
        shares = [
            data[name].transpose(*effects.dims).to_numpy() if name in data else np.full(effects.shape, np.nan)
            for name in ("theory_share", "deflection_theory_share")
        ]
        for place, acting in np.ndenumerate(effects.to_numpy()):
            euler, bow, turn = (float(size[place]) for size in sizes)
            if np.isfinite(turn):
                left = float(shares[0][place]), float(shares[1][place])
                known = [EFFECTS[name] for name in acting.split(", ") if name in EFFECTS]
                levels[place] = level_of_theory((euler, bow, turn), known, None if np.isnan(left).any() else left)
    return effects.copy(data=levels)
