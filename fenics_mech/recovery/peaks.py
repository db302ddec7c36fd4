"""Peaks between the positions of a cycle, where these are few."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.recovery.result import Result

NEIGHBOURS = 4  # positions beyond the ends of a cycle, to which a curve goes on
FEW, CLOSE = 180, 720  # positions of a cycle: between fewer peaks are sought, at so many
PEAKS = {"strain": "member", "joint_force": "joint"}  # that may be doubted, and along what each has its own
DOUBTFUL = 0.01  # share of the largest peak by which others are uncertain, that is reported
CURVES = ("strain", "stress", "deflection", "joint_force", "input_torque")


def between_positions(result: Result) -> Result:
    """Give smooth curves of a cycle at more positions, where there are few: a peak lies between two as a rule.

    The curves are Akima's: they do not swing beyond the positions at corners, as Fourier series and splines do. Where
    positions are enough, or something jumps, the result is given as it is.

    Parameters
    ----------
    result
        The result.
    """
    data = result.data
    curves = data[[name for name in CURVES if name in data]]
    finer = {name: (curve.dims, smoothed(result, curve.to_numpy())) for name, curve in _over_theta(curves)}
    theta = next((found[0] for _, found in finer.values()), data["theta"].to_numpy())
    if len(theta) == data.sizes["theta"]:
        return result
    made = {name: (dims, found[1], curves[name].attrs) for name, (dims, found) in finer.items()}
    return Result(curves.drop_dims("theta").assign_coords(theta=theta).assign(made))


def smoothed(result: Result, values: Array) -> tuple[Array, Array]:
    """Give drive angles (rad) and the values of a curve there: at more positions where `between_positions` has more.

    Parameters
    ----------
    result
        The result.
    values
        At its positions, ``(angles, ...)``.
    """
    scene, count, theta = result.scene, len(values), result.data["theta"].to_numpy()
    smooth = not scene.impulses and not any(load.jumps for load in scene.loads.values())
    if scene.analysis.method != "periodic" or not smooth or count >= FEW:
        return theta, values
    from scipy.interpolate import Akima1DInterpolator  # noqa: PLC0415  (slow to import, and few results are as coarse)

    times, around = math.ceil(CLOSE / count), np.arange(-NEIGHBOURS, count + NEIGHBOURS)
    places = np.arange(count * times) / times
    return theta[0] + (theta[1] - theta[0]) * places, Akima1DInterpolator(around, values[around % count])(places)


def _over_theta(curves: xr.Dataset) -> Iterator[tuple[str, xr.DataArray]]:
    for name in curves:
        yield str(name), curves[name].transpose("theta", ...)


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
    if result.scene.analysis.method != "periodic" or count >= FEW or count % 2 or count < 4:
        return 0.0
    one = result.data[[name]]
    halved = [between_positions(Result(one.isel(theta=slice(start, None, 2)))) for start in (0, 1)]
    curves = (abs(found.data[name]).transpose(PEAKS[name], ...).to_numpy() for found in (closer, *halved))
    peaks, *others = (curve.reshape(len(curve), -1).max(axis=1) for curve in curves)
    return float(np.abs(peaks - others).max() / max(peaks.max(), np.finfo(float).tiny))
