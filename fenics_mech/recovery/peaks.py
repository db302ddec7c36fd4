"""Peaks between the positions of a cycle, and how certain they are."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array, Index, norms
from fenics_mech.estimate.missed_peaks import BETWEEN
from fenics_mech.recovery.cycle_curves import DRAWN, CycleCurves
from fenics_mech.recovery.result import Result, kept
from fenics_mech.scene import Harmonics, Scene


@dataclass(frozen=True)
class PeakLimits:
    """How peaks between positions and stations are found."""

    certain: int = 720  # positions of a cycle, from so many on its peaks are not doubted
    gained: float = (
        8.0  # times that a peak of a spline is more certain than by half of the positions; measured 7 to 130
    )
    gained_less: float = 4.0  # the same where half of the positions differ by more than `apart`
    gained_at_corners: float = 2.0  # the same of other curves, and of those that may have corners between positions
    apart: float = 0.05  # share of the largest peak
    unseen: float = 0.1  # the same, from which on half of the positions do not see a curve: nothing is gained
    few: int = 16  # positions that may not see it either: with fewer, peaks are doubted twice as much
    doubtful: float = 0.01  # share of the largest peak by which others are uncertain, that is reported
    near: float = 0.01  # share of a peak by which a vector may be shorter between positions than at them


PEAK = PeakLimits()

CYCLIC = "periodic", "quasi-static"  # methods whose positions are those of a cycle that repeats
PEAKS = "strain", "joint_force"  # that may be doubted
CURVES = {  # whose peaks are sought between positions, and along what each has its own
    "strain": "member",
    "stress": "member",
    "deflection": "member",
    "joint_force": "joint",
    "support_force": "support",
    "input_torque": "",
    "shaking_force": "",
    "shaking_moment": "",
}
ORDER = ("theta", "member", "joint", "support", "s", "fibre", "component")  # of the dimensions of their curves


def curves_over_cycle(scene: Scene, values: Array, name: str = "") -> CycleCurves:
    """Draw curves through values at the positions of a cycle: by their harmonics, and at corners Akima's curves."""
    # Where the positions are no cycle that repeats, are fewer than four, or something jumps between them, the curves
    # are nowhere beyond the positions.
    # values: values at the positions of its result, ``(positions, ...)``
    if not _smooth(scene, len(values)):
        return CycleCurves.of_positions(values)
    return CycleCurves.through(values, of_harmonics=_without_corners(scene, name))


def _without_corners(scene: Scene, name: str = "") -> bool:
    """Whether nothing in a scene may give curves of a variable corners: then their harmonics fade away."""
    # Strains and stresses at stations have corners where a pin passes that travels along the member.
    smooth = all(drive.law is None or isinstance(drive.law, Harmonics) for drive in scene.drives)
    travels = name in ("strain", "stress") and any(joint.member for joint in scene.joints.values())
    varies = any(load.factor is not None for load in scene.loads.values())
    return smooth and not (travels or varies or scene.joint_laws)


@kept
def curves_of(result: Result, name: str) -> CycleCurves:
    """Draw the curves of a variable, whose dimensions are in the order of `ORDER`."""
    return curves_over_cycle(result.scene, _ordered(result, name).to_numpy(), name)


def _ordered(result: Result, name: str) -> xr.Variable:
    """Give a variable with its dimensions in the order of `ORDER`, without its labels, which take longer."""
    variable = result.data.variables[name]
    return variable.transpose(*sorted(map(str, variable.dims), key=ORDER.index))


def peak_of(result: Result, name: str) -> tuple[Index, Array, Array]:
    """Give the peak of a variable on each of its owners: members, joints or supports, or one alone."""
    # Gives number of the owner's curve, place in positions, and value there, ``(owners,)`` each.
    curves, which = _leading(result, name)
    places, values = _peaks(result, name, curves)
    highest = np.arange(len(values)), np.abs(values).argmax(axis=1)
    return which[highest], places[highest], values[highest]


@kept
def _leading(result: Result, name: str) -> tuple[CycleCurves, Index]:
    """Draw those curves of each owner that may have its peak, and tell which they are, ``(owners, curves)``."""
    # Others are lower by more than twice the largest step from a position to the next. Splines and curves of Akima
    # are beyond their positions by one such step at most, and curves by harmonics were by 1.5 at most.
    data, owner = _ordered(result, name), CURVES[name]
    count, vector = data.sizes["theta"], "component" in data.dims
    owners = data.sizes[owner] if owner else 1
    each = math.prod(size for dim, size in data.sizes.items() if dim not in ("theta", owner, "component"))
    values = data.to_numpy().reshape(count, owners, each, 2 if vector else 1)
    size = norms(values)
    step = norms(np.abs(np.roll(values, -1, axis=0) - values).max(axis=0))
    highest = size.max(axis=0) + 2 * step
    surely = np.minimum(*(size[half::2].max(axis=(0, 2)) for half in (0, min(1, count - 1)))) * (1 - PEAK.near)
    highest[~(highest < surely[:, None])] = np.inf  # what is no number is looked at too
    most = int(np.isinf(highest).sum(axis=1).max(initial=1))
    which = np.sort(np.argsort(-highest, axis=1, kind="stable")[:, :most], axis=1)
    some = np.ascontiguousarray(values[:, np.arange(owners)[:, None], which])
    some = some if vector else some[..., 0]
    if not _smooth(result.scene, count):
        return CycleCurves.of_positions(some), which
    largest = float(np.linalg.norm(values, axis=0).max(initial=0.0))
    return CycleCurves.through(some, _without_corners(result.scene, name), largest), which


def _peaks(result: Result, name: str, curves: CycleCurves) -> tuple[Array, Array]:
    """Give where curves of a variable are largest, and the values there, of their shape."""
    return curves.longest() if "component" in result.data.variables[name].dims else curves.largest()


def between_positions(result: Result, least: int = DRAWN) -> Result:
    """Give the curves of a cycle also where they have their peaks, as most of these lie between two positions."""
    # Where positions are few, the curves are given at more of them. Where the result is no cycle that repeats, or
    # something jumps, it is given as it is.
    return _closer(result, least)[0]


def smoothed(result: Result, values: Array, name: str = "") -> tuple[Array, Array]:
    """Give drive angles (rad) and the values of a curve there: those at which `between_positions` has its curves."""
    # values: at its positions, ``(angles, ...)``
    closer, places = _closer(result)
    if closer is not result:
        values = curves_over_cycle(result.scene, values, name).at(places)
    return closer.data["theta"].to_numpy(), values


def _closer(result: Result, least: int = DRAWN) -> tuple[Result, Array]:
    """Give the curves of a cycle at so many positions at least, and these places, in positions of the result."""
    count = result.data.sizes["theta"]
    if not _smooth(result.scene, count):
        return result, np.arange(float(count))
    return _at_more(result, least)


@kept
def _at_more(result: Result, least: int) -> tuple[Result, Array]:
    """Give the curves of a cycle at its positions, at more where these are few, and at peaks of members and joints."""
    data = result.data[[name for name in CURVES if name in result.data]]
    names, count = list(map(str, data)), data.sizes["theta"]
    times = math.ceil(least / count)
    places = [np.arange(count * times) / times]
    for name in names:
        places.append(peak_of(result, name)[1])
    at = np.unique(np.round(np.concatenate(places), 9) % count)
    curves = {name: (_ordered(result, name).dims, curves_of(result, name).at(at), data[name].attrs) for name in names}
    found = data.drop_dims("theta").assign_coords(theta=angles_at(result, at)).assign(curves)
    return Result(found), at


def angles_at(result: Result, places: Array) -> Array:
    """Give the drive angles (rad) of places between the positions of a cycle."""
    theta, k = result.data.variables["theta"].to_numpy(), np.floor(places).astype(int)
    return np.asarray(theta[k] + (places - k) * (theta[min(1, len(theta) - 1)] - theta[0]))


def _smooth(scene: Scene, count: int) -> bool:
    """Whether positions are those of a cycle that repeats, in which nothing jumps."""
    jumping = scene.impulses or any(load.jumps for load in scene.loads.values())
    return scene.analysis.method in CYCLIC and count >= 4 and not jumping


def doubts(result: Result) -> dict[str, float]:
    """By which share of the largest one peaks between positions are uncertain, by the variable in `PEAKS`."""
    return {name: doubt(result, name) for name in PEAKS}


def doubt(result: Result, name: str) -> float:
    """By which share of the largest one peaks of a variable in `PEAKS` are uncertain."""
    # The estimates of errors tell it as the source "positions". Where there are none, it is estimated by the peaks
    # that half of the positions show, and is larger than the error where these see the curves. On nine linkages it
    # was less than half of the error only with 14 positions, of which half do not see the narrow peaks of one
    # linkage.
    if name in (told := estimated_doubts(result.data)):
        return told[name]
    count = result.data.sizes["theta"]
    if result.scene.analysis.method not in CYCLIC or not 4 <= count < PEAK.certain:
        return 0.0
    curves = _leading(result, name)[0]
    peaks, others = (np.abs(_peaks(result, name, part)[1]) for part in (curves, curves.others()))
    apart = np.abs(peaks.max(axis=-1) - others.max(axis=-1)).max(axis=0)
    apart /= max(peaks.max(), np.finfo(float).tiny)
    if curves.corners is None:
        return float(gained(apart, None, count).max())
    corners = curves.corners.any(axis=-1) if "component" in result.data.variables[name].dims else curves.corners
    cornered = corners[np.arange(len(peaks)), peaks.argmax(axis=1)] | (not curves.of_harmonics)
    return float(gained(apart, cornered, count).max())


def estimated_doubts(data: xr.Dataset) -> dict[str, float]:
    """Give the uncertainties of `doubts` that estimates of errors tell; nothing where they do not."""
    if BETWEEN not in data.get("source", ()):
        return {}
    names = {"strain": "relative_error", "joint_force": "joint_force_relative_error"}
    return {what: float(data[name].sel(source=BETWEEN)) for what, name in names.items()}


def gained(apart: Array, cornered: Array | None, count: int) -> Array:
    """Give how uncertain peaks are by those that halves of the positions show, ``(peaks,)``."""
    # apart: by which share of the largest peak those of the halves differ from it, ``(peaks,)``; cornered: whether
    # the curves may have corners, ``(peaks,)``; None where they are nowhere beyond the positions
    if cornered is None:
        return apart
    if count < PEAK.few:
        return np.minimum(1.0, 2 * apart)
    times = np.where(cornered, PEAK.gained_at_corners, np.where(apart < PEAK.apart, PEAK.gained, PEAK.gained_less))
    return np.asarray(apart / np.where(apart < PEAK.unseen, times, 1.0))
