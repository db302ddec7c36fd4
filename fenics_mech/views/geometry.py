"""Where the members are, curves over one turn of the drive, and instants between the positions of a result."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.errors import ResultError
from fenics_mech.kinematics import Motion, solve_motion
from fenics_mech.recovery import Result
from fenics_mech.recovery.rigid_places import ends_in
from fenics_mech.scene import Scene
from fenics_mech.views.words import in_degrees, short


def ends_of(result: Result) -> Array:
    """Give the members' two ends in the rigid linkage (m), ``(angles, members, 2, 2)``, as the result holds them."""
    if "position" not in result.data:
        raise ResultError("the result has no positions: an older version wrote it. Analyse its scene again")
    return result.data["position"].transpose("theta", "member", "end", "component").to_numpy()


def motion_of(result: Result) -> Motion:
    """Give the rigid positions of a result's links, at rest."""
    data = result.data
    position = data["link_position"].transpose("theta", "link", "component").to_numpy()
    angle = data["link_angle"].transpose("theta", "link").to_numpy()
    still, links = np.zeros_like(position), tuple(str(name) for name in data["link"].to_numpy())
    theta, time = data["theta"].to_numpy(), data["time"].to_numpy()
    return Motion(theta, time, links, position, still, still, angle, still[..., 0], still[..., 0])


def member_ends(scene: Scene, theta: Array) -> Array:
    """Rigid-body positions of the members' two ends (m), ``(angles, members, 2, 2)`` with x, y last."""
    # theta: drive angles (rad), shape ``(angles,)``
    return ends_in(scene, solve_motion(scene, theta))


def one_turn(theta: Array, values: Array) -> tuple[Array, Array]:
    """Sort a periodic history by the drive angle in [0, 2 pi), with one more point before and one after it."""
    # theta: drive angles (rad) in any order and any turn, shape ``(angles,)``; values: shape ``(angles, ...)``
    angle = np.mod(np.round(theta, 12), TURN)
    order = np.argsort(angle, kind="stable")
    angle, values = angle[order], values[order]
    around = np.concatenate([angle[-1:] - TURN, angle, angle[:1] + TURN])
    return around, np.concatenate([values[-1:], values, values[:1]])


def at_angles(theta: Array, values: Array, wanted: Array) -> Array:
    """Interpolate a periodic history linearly at the angles `wanted` (rad), ``(wanted, ...)``."""
    return interpolated(*one_turn(theta, values), np.mod(np.round(wanted, 12), TURN))


def interpolated(knots: Array, values: Array, at: Array) -> Array:
    """Interpolate values ``(knots, ...)`` at ascending knots linearly, which may coincide, ``(at, ...)``."""
    before = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, max(len(knots) - 2, 0))
    after = np.minimum(before + 1, len(knots) - 1)
    span = knots[after] - knots[before]
    share = np.divide(at - knots[before], span, out=np.zeros(len(at)), where=span > 0)
    share = share.reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray((1 - share) * values[before] + share * values[after])


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
        return interpolated(self.result.data["time"].to_numpy(), values, self.at)

    @cached_property
    def motion(self) -> Motion:
        """Give the rigid positions of the links there."""
        if not self.in_time:
            return solve_motion(self.result.scene, self.at)
        given = motion_of(self.result)
        place, angle = self.of(given.position), self.of(given.angle)
        still, held = np.zeros_like(place), np.zeros_like(angle)
        return Motion(self.of(given.theta), self.at, given.links, place, still, still, angle, held, held)
