"""Where the members are, and curves over one turn of the drive."""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.errors import ResultError
from fenics_mech.kinematics import Motion, solve_motion
from fenics_mech.recovery import Result
from fenics_mech.recovery.rigid_places import ends_in
from fenics_mech.scene import Scene


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
    knots, values = one_turn(theta, values)
    place = np.mod(np.round(wanted, 12), TURN)
    before = np.clip(np.searchsorted(knots, place, side="right") - 1, 0, len(knots) - 2)
    weight = (place - knots[before]) / (knots[before + 1] - knots[before])
    weight = weight.reshape(-1, *[1] * (values.ndim - 1))
    return (1 - weight) * values[before] + weight * values[before + 1]
