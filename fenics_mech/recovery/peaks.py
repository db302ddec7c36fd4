"""Peaks between the positions of a cycle, where these are few."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.recovery.result import Result


@dataclass(frozen=True)
class PeakLimits:
    """How peaks between positions and stations are found."""

    neighbours: int = 4  # positions beyond the ends of a cycle, to which a curve goes on
    few: int = 180  # positions of a cycle: between fewer peaks are sought
    close: int = 720  # positions at which they are sought then
    doubtful: float = 0.01  # share of the largest peak by which others are uncertain, that is reported
    on_the_way: int = 17  # places of a pin that travels


PEAK = PeakLimits()

PEAKS = {"strain": "member", "joint_force": "joint"}  # that may be doubted, and along what each has its own
CURVES = (
    *("strain", "stress", "deflection", "joint_force", "input_torque"),
    *("shaking_force", "shaking_moment", "support_force"),
)


def between_positions(result: Result) -> Result:
    """Give smooth curves of a cycle at more positions, where there are few: a peak lies between two as a rule.

    The curves are Akima's: they do not swing beyond the positions at corners, as Fourier series and splines do. Where
    positions are enough, or something jumps, the result is given as it is.

    Parameters
    ----------
    result
        The result.
    """
    if not _coarse(result):
        return result
    curves, finer = result.data[[name for name in CURVES if name in result.data]], {}
    for name in curves:
        curve = curves[name].transpose("theta", ...)
        theta, values = smoothed(result, curve.to_numpy())
        finer[name] = curve.dims, values, curve.attrs
    return Result(curves.drop_dims("theta").assign_coords(theta=theta).assign(finer))


def _coarse(result: Result) -> bool:
    """Whether the positions of a cycle are few, and nothing jumps between them."""
    scene = result.scene
    smooth = not scene.impulses and not any(load.jumps for load in scene.loads.values())
    return scene.analysis.method == "periodic" and smooth and result.data.sizes["theta"] < PEAK.few


def smoothed(result: Result, values: Array) -> tuple[Array, Array]:
    """Give drive angles (rad) and the values of a curve there: at more positions where `between_positions` has more.

    Parameters
    ----------
    result
        The result.
    values
        At its positions, ``(angles, ...)``.
    """
    count, theta = len(values), result.data["theta"].to_numpy()
    if not _coarse(result):
        return theta, values
    from scipy.interpolate import Akima1DInterpolator  # noqa: PLC0415  (slow to import, and few results are as coarse)

    times, around = math.ceil(PEAK.close / count), np.arange(-PEAK.neighbours, count + PEAK.neighbours)
    places = np.arange(count * times) / times
    return theta[0] + (theta[1] - theta[0]) * places, Akima1DInterpolator(around, values[around % count])(places)


def doubts(result: Result) -> dict[str, float]:
    """By which share of the largest one peaks between positions are uncertain, by the variable in `PEAKS`.

    Parameters
    ----------
    result
        The result.
    """
    looked_at = Result(result.data[list(PEAKS)])
    closer = between_positions(looked_at)
    return {name: doubt(looked_at, closer, name) for name in PEAKS}


def doubt(result: Result, closer: Result, name: str) -> float:
    """By which share of the largest one peaks of a variable in `PEAKS` are uncertain, as half of the positions shows.

    Of an odd number of positions there are no halves.

    Parameters
    ----------
    result
        The result.
    closer
        What `between_positions` gives for it.
    name
        Name of the variable.
    """
    count = result.data.sizes["theta"]
    if result.scene.analysis.method != "periodic" or count >= PEAK.few or count % 2 or count < 4:
        return 0.0
    one = result.data[[name]]
    halved = [between_positions(Result(one.isel(theta=slice(start, None, 2)))) for start in (0, 1)]
    curves = (abs(found.data[name]).transpose(PEAKS[name], ...).to_numpy() for found in (closer, *halved))
    peaks, *others = (curve.reshape(len(curve), -1).max(axis=1) for curve in curves)
    return float(np.abs(peaks - others).max() / max(peaks.max(), np.finfo(float).tiny))
