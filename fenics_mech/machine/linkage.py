"""Positions of the links of a scene at drive angles, and their motion, as if no link bent."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.kinematics import Motion
from fenics_mech.machine.drawn_from_scene import Bodies, bodies_of, put_together
from fenics_mech.machine.free_motions import describe, free_motions
from fenics_mech.machine.led_from_scene import Led, led_motion
from fenics_mech.scene import Scene


class Linkage:
    """The links of a scene as its drives move them, followed as far as anyone asks."""

    def __init__(self, scene: Scene) -> None:
        self.scene, self.bodies = scene, put_together(scene, scene.constraints, scene.freedoms)
        self._led: Led | None = None

    def led(self, theta: Array) -> Led:
        """Give the motion over the range of some drive angles (rad), or over more."""
        t, known = theta / self.scene.cycle_rate, self._led
        if known is None or t.min() < known.t[0] or t.max() > known.t[-1]:
            refuse_free(self.bodies)
            self._led = known = led_motion(self.bodies, t.min(initial=0.0), t.max(initial=0.0))
        return known

    def motion(self, theta: Array) -> Motion:
        """Give the motion at drive angles ``(angles,)`` (rad)."""
        t = theta / self.scene.cycle_rate
        return as_motion(self.bodies, theta, t, *self.led(theta).at(t))


def refuse_free(bodies: Bodies) -> None:
    """Raise `SceneError` where rows are fewer than coordinates, and name what moves while the drives stand still."""
    scene = bodies.scene
    if len(bodies.machine.rows) >= bodies.machine.n:
        return
    left, count = describe(scene, bodies.links, free_motions(bodies)), len(scene.moved_joints)
    drives, freedoms = ("1 drive" if count == 1 else f"{count} drives"), "freedom" + "s" * (len(left) > 1)
    raise SceneError(
        f"the linkage is under-driven: with its {drives} held it has {len(left)} {freedoms} left: {'; '.join(left)}",
        place="drive",
        hint="Add a drive or a joint. A spring does not say where a driven linkage is",
    )


def as_motion(bodies: Bodies, theta: Array, t: Array, q: Array, v: Array, a: Array) -> Motion:
    """Label coordinates of links beside where they are drawn, their rates and accelerations ``(angles, size)``."""
    count = 3 * len(bodies.scene.links)
    place, rate, second = (x[:, :count].reshape(len(x), -1, 3) for x in (q[:, :count] + bodies.drawn, v, a))
    vectors = (place[..., :2], rate[..., :2], second[..., :2])
    return Motion(theta, t, tuple(bodies.scene.links), *vectors, place[..., 2], rate[..., 2], second[..., 2])


def solve_motion(scene: Scene, theta: Array) -> Motion:
    """Give the motion of the links of a scene at drive angles ``(angles,)`` (rad), in any order.

    Without a drive it is the linkage at rest, and the small motions that its joints leave.
    """
    theta = np.asarray(theta, dtype=float)
    if scene.drives:
        return Linkage(scene).motion(theta)
    bodies = put_together(scene, scene.constraints, scene.freedoms)
    return replace(_held(bodies, theta), free=free_motions(bodies))


def start_motion(scene: Scene) -> Motion:
    """Give the links at the start, at rest; joints with a clearance or a bushing are tight where they can be."""
    return _held(bodies_of(scene), np.zeros(1))


def _held(bodies: Bodies, theta: Array) -> Motion:
    q = np.tile(bodies.q, (len(theta), 1))
    return as_motion(bodies, theta, np.zeros_like(theta), q, 0 * q, 0 * q)
