"""Peaks between the positions of a cycle, where these are few."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.recovery.result import Result


@dataclass(frozen=True)
class PeakLimits:
    """How peaks between positions and stations are found."""

    neighbours: int = 4  # positions beyond the ends of a cycle, to which a curve of Akima goes on
    close: int = 720  # positions of a cycle: between fewer peaks are sought, at so many at least
    gained: float = (
        8.0  # times that a peak of a spline is more certain than by half of the positions; measured 7 to 130
    )
    gained_less: float = 4.0  # the same where half of the positions differ by more than `apart`
    gained_at_corners: float = 2.0  # the same of other curves
    apart: float = 0.05  # share of the largest peak
    smooth: float = 1e-3  # of the largest curve: a curve that splines foretell to it has no corners that show
    doubtful: float = 0.01  # share of the largest peak by which others are uncertain, that is reported
    on_the_way: int = 17  # places of a pin that travels


PEAK = PeakLimits()

PEAKS = {"strain": "member", "joint_force": "joint"}  # that may be doubted, and along what each has its own
CURVES = (
    *("strain", "stress", "deflection", "joint_force", "input_torque"),
    *("shaking_force", "shaking_moment", "support_force"),
)


def between_positions(result: Result) -> Result:
    """Give the curves of a cycle at more positions, where there are few: a peak lies between two as a rule.

    A curve is a cubic spline, or Akima's where that foretells each half of the positions better from the other: at
    corners splines swing beyond them. Where positions are enough, or something jumps, the result is given as it is.

    Parameters
    ----------
    result
        The result.
    """
    if not _few(result) or _jumping(result):
        return result
    kept = vars(result)  # as every plot and table asks for them
    if kept.get("closer", (None,))[0] is not result.data:
        kept["closer"] = result.data, _closer(result)
    found: Result = kept["closer"][1]
    return found


def _closer(result: Result) -> Result:
    """Give the curves of a cycle at more positions."""
    curves, finer = result.data[[name for name in CURVES if name in result.data]], {}
    for name in curves:
        curve = curves[name].transpose("theta", ...)
        theta, values = smoothed(result, curve.to_numpy())
        finer[name] = curve.dims, values, curve.attrs
    return Result(curves.drop_dims("theta").assign_coords(theta=theta).assign(finer))


def _few(result: Result) -> bool:
    """Whether the positions of a cycle are few."""
    return result.scene.analysis.method == "periodic" and 4 <= result.data.sizes["theta"] < PEAK.close


def _jumping(result: Result) -> bool:
    """Whether something jumps between positions."""
    scene = result.scene
    return bool(scene.impulses) or any(load.jumps for load in scene.loads.values())


def smoothed(result: Result, values: Array) -> tuple[Array, Array]:
    """Give drive angles (rad) and the values of a curve there: at more positions where `between_positions` has more.

    Parameters
    ----------
    result
        The result.
    values
        At its positions, ``(angles, ...)``.
    """
    theta, count = result.data["theta"].to_numpy(), len(values)
    if not _few(result) or _jumping(result):
        return theta, values
    flat, times = values.reshape(count, math.prod(values.shape[1:])), _times(count)
    found = _between(flat, times, _cornered(flat)).reshape(count * times, *values.shape[1:])
    return theta[0] + (theta[1] - theta[0]) / times * np.arange(count * times), found


def _times(count: int) -> int:
    """How many times as many positions a cycle gets."""
    return math.ceil(PEAK.close / count)


def _between(values: Array, times: int, cornered: Array) -> Array:
    """Give curves over a cycle, ``(positions, curves)``, at so many times the positions: `cornered` ones by Akima."""
    found = np.empty((len(values) * times, values.shape[1]))
    for interpolated, which in ((_by_splines, ~cornered), (_by_akima, cornered)):
        if which.any():
            found[:, which] = interpolated(values[:, which], times)
    return found


def _by_splines(values: Array, times: int) -> Array:
    """Give cubic splines over a cycle at so many times the positions, by B-splines (Unser, 1999)."""
    from scipy.ndimage import spline_filter1d  # noqa: PLC0415  (slow to import)

    part = spline_filter1d(values, order=3, axis=0, mode="grid-wrap")
    f = np.arange(times)[:, None] / times
    shares = (1 - f) ** 3 / 6, (3 * f**3 - 6 * f**2 + 4) / 6, (-3 * f**3 + 3 * f**2 + 3 * f + 1) / 6, f**3 / 6
    found = sum(share * np.roll(part, 1 - k, axis=0)[:, None] for k, share in enumerate(shares))
    return np.asarray(found).reshape(len(values) * times, -1)


def _by_akima(values: Array, times: int) -> Array:
    """Give Akima's curves over a cycle at so many times the positions."""
    count = len(values)
    return akima_over_cycle(np.arange(float(count)), values, count, PEAK.neighbours)(np.arange(count * times) / times)


def akima_over_cycle(at: Array, values: Array, period: float, neighbours: int) -> Callable[[Array], Array]:
    """Give Akima's curves through values over a cycle, which do not swing beyond them at corners.

    Parameters
    ----------
    at
        Ascending places of the values in the cycle, ``(places,)``.
    values
        Values there, ``(places, ...)``.
    period
        Length of the cycle, in units of the places.
    neighbours
        Places beyond its ends, to which the curves go on.
    """
    from scipy.interpolate import Akima1DInterpolator  # noqa: PLC0415  (slow to import)

    turns, which = np.divmod(np.arange(-neighbours, len(at) + neighbours), len(at))
    curve = Akima1DInterpolator(at[which] + period * turns, values[which])
    return lambda places: np.asarray(curve(places))


def _cornered(values: Array) -> Array:
    """Which curves, ``(curves,)``, Akima's interpolant foretells better than a spline at positions left out.

    Of an odd number of positions, where not every second one can be left out, they are all.
    """
    if len(values) % 2:
        return np.ones(values.shape[1], dtype=bool)

    by_splines = _missed(_by_splines, values)
    cornered = by_splines > PEAK.smooth * np.linalg.norm(values, axis=0).max(initial=0.0)
    if cornered.any():
        cornered[cornered] = _missed(_by_akima, values[:, cornered]) < by_splines[cornered]
    return cornered


def _missed(interpolated: Callable[[Array, int], Array], values: Array) -> Array:
    """By how much halves of the positions miss curves at the others, root of the sum of squares, ``(curves,)``."""
    even, odd = values[::2], values[1::2]
    missed = [interpolated(even, 2)[1::2] - odd, interpolated(odd, 2)[1::2] - np.roll(even, -1, axis=0)]
    return np.asarray(np.linalg.norm(np.concatenate(missed), axis=0))


def doubts(result: Result) -> dict[str, float]:
    """By which share of the largest one peaks between positions are uncertain, by the variable in `PEAKS`.

    Parameters
    ----------
    result
        The result.
    """
    return {name: doubt(result, name) for name in PEAKS}


def doubt(result: Result, name: str) -> float:
    """By which share of the largest one peaks of a variable in `PEAKS` are uncertain.

    It is estimated by the peaks that half of the positions show. Of an odd number of positions there are no halves.

    Parameters
    ----------
    result
        The result.
    name
        Name of the variable.
    """
    if not _few(result) or result.data.sizes["theta"] % 2:
        return 0.0
    curve = result.data[name].transpose("theta", PEAKS[name], ...)
    values, owners = curve.to_numpy().reshape(curve.sizes["theta"], -1), curve.sizes[PEAKS[name]]
    found, cornered = [values, values[::2], values[1::2]], np.ones(values.shape[1], dtype=bool)
    if not _jumping(result):
        cornered, times = _cornered(values), _times(len(values))
        found = [_between(part, times * len(values) // len(part), cornered) for part in found]
    peaks, *others = (np.abs(part).max(axis=0).reshape(owners, -1) for part in found)
    apart = np.abs([peaks.max(axis=1) - other.max(axis=1) for other in others]).max(axis=0)
    apart /= max(peaks.max(), np.finfo(float).tiny)
    if _jumping(result):
        return float(apart.max())
    highest = cornered.reshape(peaks.shape)[np.arange(owners), peaks.argmax(axis=1)]
    gained = np.where(apart < PEAK.apart, PEAK.gained, PEAK.gained_less)
    return float((apart / np.where(highest, PEAK.gained_at_corners, gained)).max())
