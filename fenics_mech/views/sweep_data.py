"""What a sweep holds: its fields as written, units, points outside the theory or unstable, and resonances."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.signal import find_peaks

from fenics_mech._arrays import Array, Index
from fenics_mech.effects import EFFECTS
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.solve.stability_limits import STABILITY
from fenics_mech.studies.sweep_peaks import unresolved
from fenics_mech.views.judgements import level_of_theory
from fenics_mech.views.prefixes import fitted, without_rounding
from fenics_mech.views.tables import number

BEYOND = "outside the theory"


@dataclass(frozen=True)
class ResonanceLimits:
    """When a strain counts as raised by a mode."""

    raised: float = 1.4  # times its growth with the square of the speed, from which it is shown
    near: float = 0.1  # of a mode's frequency, up to which a raised strain is the mode's
    named: float = 1.6  # times that growth, at a maximum that is named
    close: float = 0.05  # of a mode's frequency, and of the speed, within which two are one
    least: float = 0.02  # of the peak strain, below which nothing is named
    most: int = 5  # that are named
    fewest: int = 5  # points of a sweep in which resonances are sought


RESONANCE = ResonanceLimits()


@dataclass(frozen=True)
class Resonance:
    """A maximum of a harmonic of the strain, near a mode."""

    point: int  # number of the point in the sweep
    order: int  # multiple of the drive's rate
    mode: int  # number of the mode, from 0
    strain: float  # amplitude of the harmonic (1)


def resonances_of(data: xr.Dataset) -> list[Resonance]:
    """Give the resonances of a sweep over one field, the largest first; none where its points are few."""
    points = whole_points(data)
    if not len(points):
        return []
    rate, low, high, amplitude = sizes_at(data, points)
    peak = data["peak_strain"].transpose(..., "member").to_numpy()[points]
    found = resonances(rate, (low, high), amplitude, peak)
    return [Resonance(int(points[one.point]), one.order, one.mode, one.strain) for one in found]


def rising_at_ends(data: xr.Dataset) -> list[Resonance]:
    """Give the harmonics that still rise at the ends of a sweep over one field, near a mode: at each the largest."""
    points = whole_points(data)
    if not len(points):
        return []
    rate, low, high, amplitude = sizes_at(data, points)
    gain, distance = gains(rate, amplitude), distances(rate, low, high, amplitude.shape[2])
    peak = np.nanmax(data["peak_strain"].transpose(..., "member").to_numpy()[points], axis=1)
    found = []
    for end, beside in ((0, 1), (-1, -2)):
        rises = (gain[end] > gain[beside]) & (gain[end] > RESONANCE.named)
        rises &= (amplitude[end] > RESONANCE.least * peak[end]) & (distance[end].min(axis=1) < RESONANCE.near)
        sizes = np.where(rises, np.nan_to_num(amplitude[end]), 0.0)
        member, order = np.unravel_index(sizes.argmax(), sizes.shape)
        if order and sizes[member, order]:
            mode = int(distance[end, order].argmin())
            found.append(Resonance(int(points[end]), int(order), mode, float(sizes[member, order])))
    return found


def peak_of_speed(data: xr.Dataset) -> tuple[int, float] | None:
    """Find the strain that stands out most from those at the speeds beside it, whatever raises it."""
    points = whole_points(data)
    if len(points) < RESONANCE.fewest:
        return None
    rate = np.abs(data["drive_rate"].to_numpy()[points])
    points = points[np.argsort(rate)]
    found = None
    for strain in data["peak_strain"].transpose("member", ...).to_numpy()[:, points]:
        peaks, known = find_peaks(strain, prominence=0)
        below = strain[peaks] - known["prominences"]  # the higher one of the valleys beside it
        for place, times in zip(peaks[below > 0], (strain[peaks] / np.where(below > 0, below, 1.0))[below > 0]):
            if times > max(RESONANCE.named, 0.0 if found is None else found[1]):
                found = int(points[place]), float(times)
    return found


def whole_points(data: xr.Dataset) -> Index:
    """Give the numbers of the points of a sweep over one field that did not fail, where resonances can be sought."""
    if not {"strain_harmonic", "frequency_lowest", "drive_rate"} <= set(data.variables):
        return np.zeros(0, dtype=int)
    rate = data["drive_rate"].to_numpy()
    whole = np.isfinite(rate) & np.isfinite(ranges(data)[0]).all(axis=1)
    if whole.sum() < RESONANCE.fewest or np.ptp(rate[whole]) < 1e-9 * np.abs(rate[whole]).max():
        return np.zeros(0, dtype=int)
    return np.flatnonzero(whole)


def ranges(data: xr.Dataset) -> tuple[Array, Array]:
    """Give the range of each mode's frequency (Hz) in a sweep over one field, ``(points, modes)`` each."""
    # It is that about the motion, where that is known at all points that did not fail, else that at rest.
    ends = [f"{name}_{end}" for name in ("frequency", "running") for end in ("lowest", "highest")]
    held_low, held_high, *running = (data[name].transpose(..., "mode").to_numpy() for name in ends if name in data)
    if running and (np.isfinite(running[0]) == np.isfinite(held_low)).all():
        return running[0], running[1]
    return held_low, held_high


def sizes_at(data: xr.Dataset, points: Index) -> tuple[Array, Array, Array, Array]:
    """Give the drive's rate (Hz), each mode's range (Hz) and the strain's harmonics at some points of a sweep."""
    rate = np.abs(data["drive_rate"].to_numpy()[points]) / (2 * np.pi)
    low, high = (end[points] for end in ranges(data))
    return rate, low, high, data["strain_harmonic"].transpose(..., "member", "harmonic").to_numpy()[points]


def gains(rate: Array, amplitude: Array) -> Array:
    """Give harmonics over their growth with the square of the rate, relative to the median over the sweep."""
    # Without vibration strains grow with the square of the speed. What stands out of that growth is resonance.
    # rate: of the drive (Hz), ``(points,)``; amplitude: of the strain's harmonics, ``(points, members, harmonics)``
    grown = amplitude / rate[:, None, None] ** 2
    middle = np.nanmedian(grown, axis=0)
    return np.divide(grown, middle, out=np.zeros_like(grown), where=middle > 0)


def distances(rate: Array, low: Array, high: Array, orders: int) -> Array:
    """Give the relative distance of each multiple of the rate from each mode's range, ``(points, orders, modes)``."""
    # rate: of the drive (Hz), ``(points,)``; low, high: range of each mode's frequency (Hz), ``(points, modes)``
    multiple = np.maximum(np.arange(orders) * rate[:, None], 1e-9)[..., None]
    return np.maximum(np.maximum(low[:, None] / multiple - 1, multiple / high[:, None] - 1), 0.0)


def raised(gain: Array, amplitude: Array, distance: Array) -> Array:
    """Give the largest strain of all members, where a mode nearby raises it, ``(points, harmonics)``; elsewhere 0."""
    # amplitude: of the strain's harmonics, ``(points, members, harmonics)``
    found = np.where(gain > RESONANCE.raised, np.nan_to_num(amplitude), 0.0).max(axis=1)
    return np.where(distance.min(axis=2) < RESONANCE.near, found, 0.0)


def resonances(rate: Array, modes: tuple[Array, Array], amplitude: Array, peak: Array) -> list[Resonance]:
    """Give the resonances of a sweep, the largest first: of one multiple those apart by more than a few percent."""
    # rate: of the drive (Hz), ``(points,)``, in one direction; modes: lowest and highest frequency of each mode (Hz),
    # ``(points, modes)`` each; amplitude: of the strain's harmonics, ``(points, members, harmonics)``; peak: largest
    # strain of each member, ``(points, members)``
    gain, distance = gains(rate, amplitude), distances(rate, *modes, amplitude.shape[2])
    inner, before, after = gain[1:-1], gain[:-2], gain[2:]
    highest = (inner >= before) & (inner > after) & (inner > RESONANCE.named)
    highest &= amplitude[1:-1] > RESONANCE.least * np.nanmax(peak, axis=1)[1:-1, None, None]
    found = []
    for i, member, order in np.argwhere(highest):
        mode = int(distance[i + 1, order].argmin())
        if order and distance[i + 1, order, mode] < RESONANCE.close:
            found.append(Resonance(int(i + 1), int(order), mode, float(amplitude[i + 1, member, order])))
    kept: list[Resonance] = []
    for one in sorted(found, key=lambda one: -one.strain):
        same = (other for other in kept if other.order == one.order)
        if not any(
            other.mode == one.mode or abs(rate[other.point] / rate[one.point] - 1) < RESONANCE.close for other in same
        ):
            kept.append(one)
    return kept


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
