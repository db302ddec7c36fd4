"""Peaks between the positions of a cycle and between the stations of a result, and by how much these miss them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.errors import ANSWERED, UnresolvedError

ACCELERATIONS = ("point_acceleration", "point_acceleration_bent")  # of links that do not bend, and of bent ones
BETWEEN = "positions"  # the source of errors by what lies between them
Owner = tuple[str, int]  # a quantity, and the number of the member, joint, drive or point that has it


@dataclass(frozen=True, eq=False)
class MissedPeaks:
    """By how much the positions of a cycle miss the peaks between them."""

    count: int  # number of the positions
    points: tuple[str, ...]  # the points that are followed
    # by quantity, how uncertain the peaks are that positions show, ``(members, joints, drives or points,)``
    errors: Mapping[str, Array]
    # the part of it that is surely missed: how far the peaks of loads and rigid motion are from those shown
    known: Mapping[str, Array]
    # peaks, angles: by quantity, the largest values, and the drive angles (rad) at which they are
    peaks: Mapping[str, Array]
    angles: Mapping[str, Array]
    # gives a number of positions that show the peaks of quantities to errors of each owner; None where too many
    enough: Callable[[Mapping[str, Array]], int | None]

    def of_points(self, sources: Sequence[str]) -> dict[str, tuple[tuple[str, ...], Array]]:
        """Give the errors of the points' accelerations as variables; what other sources add to them is not known."""
        found = dict[str, tuple[tuple[str, ...], Array]]()
        between = np.array([source == BETWEEN for source in sources])
        for name in ACCELERATIONS:
            if name in self.errors:
                error, largest = self.errors[name], max(float(self.peaks[name].max(initial=0.0)), TINY)
                found[f"{name}_error"] = ("source", "point"), np.where(between[:, None], error, np.nan)
                relative = np.where(between, error.max(initial=0.0) / largest, np.nan)
                found[f"{name}_relative_error"] = ("source",), relative
        return found

    def refusal(self, owner: Owner, what: str, enough: int | None) -> UnresolvedError:
        """Say where a peak is that the positions miss, and how many of them show it."""
        (name, which), unit = owner, {"joint_force": " N", "deflection": " m"}.get(owner[0], "")
        angle, peak, missed = (float(part[name][which]) for part in (self.angles, self.peaks, self.known))
        advice = (
            "Take lengths, laws or loads that change less fast"
            if enough is None
            else f"Take at least {enough} sub_intervals"
        )
        return UnresolvedError(
            f"the positions are too few: the {what} reaches {peak:.4g}{unit} at drive angle "
            f"{math.degrees(angle):.6g} deg, and {self.count} positions show another peak by {missed:.3g}{unit}. "
            f"{advice}; analysis.allow_coarse lets it pass"
        ).finer_by(ANSWERED, **({} if enough is None else {"sub_intervals": enough}))


def between_stations(strain: Array) -> Array:
    """By how much parabolas through three stations surpass the largest strain at the stations, ``(members,)``."""
    size = np.abs(strain)
    highest = size.max(axis=(0, 2, 3))
    if strain.shape[2] < 3:
        return np.zeros_like(highest)
    before, middle, after = strain[:, :, :-2], strain[:, :, 1:-1], strain[:, :, 2:]
    bend, slope = after - 2 * middle + before, (after - before) / 2
    inside = (np.abs(slope) < np.abs(bend)) & (bend != 0)
    vertex = middle - np.where(inside, slope**2 / (2 * np.where(inside, bend, 1.0)), 0.0)
    return np.maximum(np.abs(vertex).max(axis=(0, 2, 3)) - highest, 0.0)
