"""Peaks of the curves of a sweep: where they are, where points are missing for them, and whether they are enough."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene

Estimates = Literal["auto", "all", "peaks"]
MANY_POINTS = 24  # beyond which errors are estimated at peaks and ends alone, unless it is asked for otherwise
RESOLVED = 0.01  # of a member's largest peak strain: what linear interpolation between the points may miss
FINEST = 64  # parts that refinement may cut a step of the range into


def peaks_of(strains: Array, rank: int) -> NDArray[np.bool_]:
    """Tell which points of a grid are its corners, or have a peak of some curve."""
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
    """Midpoints of the steps in which linear interpolation of the peaks is not good enough, the worst first."""
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
