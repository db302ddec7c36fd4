"""Resonances of a sweep over the drive's rate: which multiple of the drive raises a strain as it meets a mode."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.signal import find_peaks

from fenics_mech._arrays import Array, Index


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
