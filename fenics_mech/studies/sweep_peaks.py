"""Peaks of the curves of a sweep: where they are, where points are missing for them, and whether they are enough."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene
from fenics_mech.studies.kept_records import Record
from fenics_mech.studies.sweep_points import stacked

Estimates = Literal["auto", "all", "peaks"]
MANY_POINTS = 24  # beyond which errors are estimated at peaks and ends alone, unless it is asked for otherwise
RESOLVED = 0.01  # of a member's largest peak strain: what linear interpolation between the points may miss
FINEST = 64  # parts that refinement may cut a step of the range into


def peaks_of(strains: Array, rank: int) -> NDArray[np.bool_]:
    """Tell which points of a grid are its corners, or have a peak of some curve, of strains ``(*grid, members)``."""
    # A peak is no less than the points beside it along any axis.
    known = np.where(np.isnan(strains), -np.inf, strains)
    highest = np.isfinite(known)
    for axis in range(rank):
        padded = np.pad(known, [(int(i == axis),) * 2 for i in range(known.ndim)], constant_values=-np.inf)
        beside = (np.take(padded, range(first, first + known.shape[axis]), axis) for first in (0, 2))
        highest &= np.all([known >= other for other in beside], axis=0)
    found = np.asarray(np.any(highest, axis=-1))
    found[np.ix_(*([0, -1] for _ in range(rank)))] = True
    return found


def unresolved(places: Array, peaks: Array) -> list[float]:
    """Midpoints of steps in which linear interpolation of peaks ``(points, members)`` is too coarse, worst first."""
    # The error in a step h is estimated as ``h^2 |y''| / 8`` with the larger of the second divided differences at its
    # two ends, relative to the largest y. The steps at a point that failed are passed over.
    if len(places) < 3:
        return []
    step = np.diff(places)
    slope = np.diff(peaks, axis=0) / step[:, None]
    second = np.abs(2 * np.diff(slope, axis=0) / (step[1:] + step[:-1])[:, None])
    known = np.nan_to_num(second, nan=0.0)
    bend = np.fmax(np.concatenate([known[:1], known]), np.concatenate([known, known[-1:]]))
    largest = np.nan_to_num(np.nanmax(peaks, axis=0, initial=0.0))
    error = (step[:, None] ** 2 * bend / 8 / np.where(largest > 0, largest, 1)).max(axis=1)
    error[np.isnan(slope).any(axis=1) | (step < 1.5 * step.max() / FINEST)] = 0
    worst = np.argsort(-error, kind="stable")
    return [float(places[k] + step[k] / 2) for k in worst if error[k] > RESOLVED]


def at_peaks_alone(scene: Scene, estimates: Estimates, points: int) -> bool:
    """Whether errors are estimated at peaks and ends alone."""
    chosen = {"effects": scene.effects == "auto", "tolerance": scene.tolerance is not None}
    if estimates != "peaks":
        return estimates == "auto" and points > MANY_POINTS and not any(chosen.values())
    for place in (name for name, by_estimates in chosen.items() if by_estimates):
        message = "error estimates choose this for each point, and would be made at few points only"
        raise SceneError(message, place=place, hint="List the effects and state the mesh, or estimate at all points")
    return True


MOST = 3  # analyses: parabolas through three points then meet the top of an oscillator's curve to 1 %
ENOUGH = 0.02  # of a step of the sweep, by which the top moves no more


def largest_between(
    values: Sequence[float], records: Sequence[Record], analysed: Callable[[float], Record], members: Sequence[str]
) -> str:
    """Seek the largest strain between the points beside the largest one, by parabolas; what was found, as JSON."""
    strains = stacked([_strains(record) for record in records]).reshape(len(records), -1)
    if np.isnan(strains).all():
        return ""
    k, member = map(int, np.unravel_index(int(np.nanargmax(strains)), strains.shape))
    if not 0 < k < len(values) - 1 or np.isnan(strains[k - 1 : k + 2, member]).any():
        return ""
    x, y = np.array(values[k - 1 : k + 2], dtype=float), strains[k - 1 : k + 2, member]
    step, best = min(np.diff(x)), None
    for _ in range(MOST):
        top = vertex(x, y)
        if not x[0] < top < x[2] or np.abs(top - x).min() < ENOUGH * step:
            break
        record = analysed(top)
        found = _strains(record)
        if found is None:
            break
        best = (top, record) if found[member] > y.max() else best
        x, y = _around_top(np.append(x, top), np.append(y, found[member]))
    if best is None:
        return ""
    value, record = best
    told = {"value": value, "member": members[member]}
    return json.dumps(told | {name: record["values"][f"peak_{name}"][member] for name in ("strain", "stress")})


def vertex(x: Array, y: Array) -> float:
    """Give where the parabola through three points has its top; NaN where it has none."""
    left, right = (y[1] - y[0]) / (x[1] - x[0]), (y[2] - y[1]) / (x[2] - x[1])
    bend = (right - left) / (x[2] - x[0])
    return float((x[0] + x[1]) / 2 - left / (2 * bend)) if bend < 0 else math.nan


def _around_top(x: Array, y: Array) -> tuple[Array, Array]:
    """Give the highest of points and those beside it."""
    order = np.argsort(x)
    x, y = x[order], y[order]
    k = min(max(int(y.argmax()), 1), len(x) - 2)
    return x[k - 1 : k + 2], y[k - 1 : k + 2]


def _strains(record: Record) -> list[float] | None:
    """Peak strains of a point with a stable motion, by member."""
    return None if record["error"] or record["unstable"] else record.get("values", {}).get("peak_strain")
