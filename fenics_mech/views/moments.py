"""Instants of a result that are shown: curves and positions interpolated there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.kinematics import Motion, solve_motion
from fenics_mech.recovery import Result
from fenics_mech.views.geometry import at_angles, motion_of
from fenics_mech.views.words import in_degrees, short


@dataclass(frozen=True)
class Moments:
    """Instants of a result."""

    result: Result  # the result
    at: Array  # drive angles (rad), or times (s) of a motion in time

    @property
    def in_time(self) -> bool:
        """Whether the instants are times."""
        return self.result.scene.analysis.method == "transient"

    @property
    def labels(self) -> tuple[str, ...]:
        """Each instant in words."""
        if self.in_time:
            return tuple(f"time {short(float(time))} s" for time in self.at)
        return tuple(f"drive angle {in_degrees(float(angle))}" for angle in self.at)

    def of(self, values: Array) -> Array:
        """Interpolate values at the positions of the result, ``(positions, ...)``, linearly."""
        if not self.in_time:
            return at_angles(self.result.data["theta"].to_numpy(), values, self.at)
        time = self.result.data["time"].to_numpy()
        before = np.clip(np.searchsorted(time, self.at, side="right") - 1, 0, max(len(time) - 2, 0))
        after = np.minimum(before + 1, len(time) - 1)
        span = time[after] - time[before]
        share = np.divide(self.at - time[before], span, out=np.zeros(len(self.at)), where=span > 0)
        share = share.reshape(-1, *[1] * (values.ndim - 1))
        return np.asarray((1 - share) * values[before] + share * values[after])

    @cached_property
    def motion(self) -> Motion:
        """Give the rigid positions of the links there."""
        if not self.in_time:
            return solve_motion(self.result.scene, self.at)
        given = motion_of(self.result)
        place, angle = self.of(given.position), self.of(given.angle)
        still, held = np.zeros_like(place), np.zeros_like(angle)
        return Motion(self.of(given.theta), self.at, given.links, place, still, still, angle, held, held)
