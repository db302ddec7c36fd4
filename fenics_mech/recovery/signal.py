"""What a periodic result is made of: harmonics of strains, joint forces and torque, and the vibration in the strains.

Section 7.4 of the dissertation reads a vibration frequency off each measured strain curve (figures 7.7 and 7.8) and
compares it with the member's natural frequency. Its 274.7 and 307.0 rad/s are 8.5 and 9.5 times the drive's 32.3. Here
too ripples are counted, in the strain less its quasi-static curve. A periodic strain has a whole number of them, so
that the frequency is known to about that of the drive.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index
from fenics_mech.recovery.result import at_place
from fenics_mech.scene import Analysis, Drive, RestToRest, Scene

MID_SPAN, PEAK = "mid-span", "peak"
LEAST_POSITIONS = 8  # in a dwell, to see its vibration
DWELLS = "after out", "after back"


@dataclass(frozen=True)
class VibrationLimits:
    """When a strain counts as vibrating."""

    same: float = 0.01  # difference of the last two cycles of a motion in time, up to which the last is periodic
    least: float = 1e-3  # of the strain's peak, below which nothing vibrates
    least_samples: int = 10  # in a period of the first mode, to count ripples
    least_ripple: float = 0.05  # height over the higher of the valleys beside it, of the vibration from top to bottom


VIBRATION = VibrationLimits()


def harmonics(values: Array, phase: float = 0.0) -> NDArray[np.complex128]:
    """Fourier coefficients of a periodic quantity, ``values(t) = Re sum_n c_n exp(i n phase(t))``."""
    # values: at N equal steps of time over one cycle, ``(steps, ...)``; phase: phase of the cycle at the first step
    # (rad)
    # Gives ``c_n`` for n from 0 to below N/2, ``(harmonics, ...)``: of harmonic n the amplitude is ``|c_n|``, and its
    # phase, ``angle(c_n)``, that of a cosine.
    steps = len(values)
    found = np.fft.rfft(values, axis=0)[: 1 + (steps - 1) // 2] * (2 / steps)
    found[0] /= 2
    return found * np.exp(-1j * phase * np.arange(len(found))).reshape(-1, *(1,) * (values.ndim - 1))


def last_cycle(analysis: Analysis, drives: Sequence[Drive], data: xr.Dataset) -> slice | None:
    """Positions of a result that are one cycle of a periodic motion, or None where it has none."""
    count = data.sizes["theta"]
    if not drives or analysis.method == "static" or count < 3:
        return None
    if analysis.method != "transient":
        return slice(0, count)
    periodic = count >= analysis.sub_intervals and data.attrs.get("cycle_change", math.inf) <= VIBRATION.same
    return slice(count - analysis.sub_intervals, count) if periodic else None


def of_cycle(data: xr.Dataset, part: slice, period: float, still: xr.DataArray | None = None) -> xr.Dataset:
    """Harmonics of strains, joint forces and torque, and the vibration of each member's strain."""
    # period: duration of the cycle (s)
    cycle = data[["strain", "joint_force", "input_torque"]].isel(theta=part)
    phase = abs(float(cycle["theta"][0]))
    waves, place = _gauged(cycle["strain"])
    found: dict[str, tuple[tuple[str, ...], Array]] = {"strain": (("member", "gauge"), waves)}
    found["joint_force"] = (("joint", "component"), cycle["joint_force"].transpose("theta", ...).to_numpy())
    found["input_torque"] = ((), cycle["input_torque"].to_numpy())
    variables: dict[str, tuple[tuple[str, ...], Array]] = {}
    for name, (dims, values) in found.items():
        series = harmonics(values, phase)
        variables[f"{name}_amplitude"] = (("harmonic", *dims), np.abs(series))
        variables[f"{name}_phase"] = (("harmonic", *dims), np.asarray(np.angle(series), dtype=np.float64))
    order = np.arange(len(series))
    coordinates = {"harmonic": order, "harmonic_frequency": ("harmonic", order / period)} | place
    if still is not None and "frequency" in data:
        frequency = data["frequency"].transpose("theta", "mode").to_numpy()
        variables |= _vibration(waves[..., 0], _at_mid_span(still), frequency, period)
    return xr.Dataset(variables, coordinates)


def _gauged(strain: xr.DataArray) -> tuple[Array, dict[str, object]]:
    """Strains at mid-span and where they are largest, ``(angles, members, 2)``, and the coordinates of those places."""
    strain = strain.transpose("theta", "member", "s", "fibre")
    largest = np.abs(strain.to_numpy()).max(axis=0)
    flat = largest.reshape(len(largest), -1).argmax(axis=1)
    s, fibre = np.unravel_index(flat, largest.shape[1:])
    middle = _at_mid_span(strain)
    peak = strain.to_numpy()[:, np.arange(len(largest)), s, fibre]
    where = np.stack([np.full(len(s), 0.5), strain["s"].to_numpy()[s]], axis=1)
    sides = np.stack([np.full(len(s), "+"), strain["fibre"].to_numpy()[fibre]], axis=1)
    along = ("member", "gauge")
    places: dict[str, object] = {
        "gauge": [MID_SPAN, PEAK],
        "gauge_s": (along, where),
        "gauge_fibre": (along, sides.astype(object)),
    }
    return np.stack([middle, peak], axis=-1), places


def _at_mid_span(strain: xr.DataArray) -> Array:
    """Strain of the + fibre at mid-span, ``(angles, members)``."""
    return at_place(strain.sel(fibre="+").transpose("theta", "member", "s").to_numpy(), strain["s"].to_numpy(), 0.5)


def _vibration(
    strain: Array, still: Array, frequency: Array, period: float
) -> dict[str, tuple[tuple[str, ...], Array]]:
    """Count the ripples of the strain about its quasi-static curve, and find their mode and their largest harmonic."""
    vibration = strain - still
    size = np.ptp(vibration, axis=0) / 2
    vibrates = size > VIBRATION.least * np.abs(strain).max(axis=0)
    vibrates &= len(strain) >= VIBRATION.least_samples * frequency[:, 0].max() * period
    rate = np.array([ripples(wave) for wave in vibration.T]) / period
    mode = vibrating_mode(rate, frequency, period)
    vibrates &= np.isfinite(mode)
    values = {
        "vibration_amplitude": size,
        "vibration_frequency": np.where(vibrates, rate, np.nan),
        "vibration_harmonic": np.where(vibrates, 1 + np.abs(harmonics(vibration)[1:]).argmax(axis=0), np.nan),
        "vibration_mode": np.where(vibrates, 1 + mode, np.nan),
    }
    return {name: (("member",), value) for name, value in values.items()}


def ripples(wave: Array) -> int:
    """Maxima of a periodic curve that stand out by a ripple's least height."""
    # wave: one cycle of the curve, ``(steps,)``
    start = int(wave.argmin())
    height = VIBRATION.least_ripple * float(max(np.ptp(wave), np.finfo(float).tiny))
    count, rising, turn = 0, False, float(wave[start])
    for value in np.append(np.roll(wave, -start), wave[start]):  # from the lowest point to itself: no maximum is cut
        if rising == (value > turn):
            turn = value
        elif abs(value - turn) >= height:
            count, rising, turn = count + rising, not rising, value
    return count


def vibrating_mode(rate: Array, frequency: Array, period: float) -> Array:
    """Number, from 0, of the mode in which something vibrates, NaN where it follows the drive instead."""
    # Ripples that are near no natural frequency, or one in a cycle, are multiples of the drive and no vibration.
    # rate: frequencies of ripples (Hz), ``(members,)``; frequency: natural frequencies (Hz), ``(angles, modes)``;
    # period: duration of the cycle (s)
    return np.where(rate * period > 1.5, nearest_mode(rate, frequency, 1 / period), np.nan)


def nearest_mode(rate: Array, frequency: Array, resolution: float) -> Array:
    """Number, from 0, of the mode whose range over the cycle is nearest to each rate; of several the nearest mean."""
    # It is NaN where none is as near as the resolution: a motion that is driven, and not a vibration of the links.
    # rate: frequencies (Hz), ``(members,)``; frequency: natural frequencies (Hz), ``(angles, modes)``; resolution: of
    # the rates (Hz)
    rate = rate[:, None]
    outside = np.maximum(np.maximum(frequency.min(axis=0) - rate, rate - frequency.max(axis=0)), 0)
    nearest = np.lexsort((np.abs(rate - frequency.mean(axis=0)), outside), axis=1)[:, 0]
    return np.where(outside.min(axis=1) <= resolution, nearest, np.nan)


def residual_vibration(scene: Scene, data: xr.Dataset) -> xr.Dataset:
    """Give how far each member swings on in the dwells: half of the range of its deflection where that is largest."""
    # Of a motion in time it is the last dwell of each kind that has enough positions. A scene whose one drive does
    # not move from rest to rest, or that has freedoms, gives nothing.
    drives = scene.drives
    moves = len(drives) == 1 and isinstance(drives[0].law, RestToRest) and not scene.freedoms
    if not moves or scene.analysis.method not in ("periodic", "transient"):
        return xr.Dataset()
    law = drives[0].law
    assert isinstance(law, RestToRest)
    theta = data["theta"].to_numpy() * np.sign(scene.cycle_rate)
    bent = data["deflection"].transpose("theta", "member", "s", "component").to_numpy()
    found = {}
    for name, begin, end in zip(DWELLS, (law.out[1], law.back[1]), (law.back[0], 1 + law.out[0])):
        inside = _last_dwell(theta / (2 * np.pi), begin, end, repeats=scene.analysis.method == "periodic")
        if len(inside) >= LEAST_POSITIONS:
            found[name] = np.linalg.norm(np.ptp(bent[inside], axis=0), axis=-1).max(axis=-1) / 2
    if not found:
        return xr.Dataset()
    size = np.stack(list(found.values()))
    return xr.Dataset({"residual_vibration": (("dwell", "member"), size)}, {"dwell": list(found)})


def _last_dwell(turns: Array, begin: float, end: float, *, repeats: bool) -> Index:
    """Positions in the last dwell that has enough of them; `turns` count cycles from the start."""
    if repeats:
        return np.flatnonzero((turns - begin) % 1.0 <= end - begin)
    for cycle in range(int(np.floor(turns[-1])), int(np.floor(turns[0])) - 2, -1):
        inside = np.flatnonzero((turns >= cycle + begin) & (turns <= cycle + end))
        if len(inside) >= LEAST_POSITIONS and turns[0] <= cycle + begin:
            return inside
    return np.zeros(0, dtype=np.int64)
