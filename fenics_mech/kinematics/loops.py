"""Loop equations of a linkage, their Jacobian, and the right-hand sides for velocity and acceleration.

Each moving link has the coordinates (x, y, phi) of its frame; a revolute joint demands that its points coincide, and
the drive fixes one relative angle (Nikravesh, Computer-Aided Analysis of Mechanical Systems, 1988, chapter 4). All
functions work on many positions at once: coordinates have shape ``(positions, 3 links)``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fenics_mech.scene import Scene

Array = NDArray[np.float64]
GROUND = -1


@dataclass(frozen=True)
class Loops:
    """The joints of a scene as arrays: one row a pair of coinciding points, then the drive.

    Parameters
    ----------
    links
        Names of the moving links, in the order of their coordinates.
    joint
        Name of the joint of each pair.
    body
        The two bodies of each pair, as index into `links` or `GROUND`, shape ``(pairs, 2)``.
    point
        The two points in their bodies' frames (m), shape ``(pairs, 2, 2)``.
    driven
        The two bodies whose relative angle is driven.
    """

    links: tuple[str, ...]
    joint: tuple[str, ...]
    body: NDArray[np.int64]
    point: Array
    driven: tuple[int, int]

    @classmethod
    def of(cls, scene: Scene) -> Loops:
        """Collect the pairs of a scene: a pin through n bodies gives n - 1 pairs with its first body."""
        links = tuple(scene.links)
        index = {"ground": GROUND} | {name: i for i, name in enumerate(links)}
        joints, bodies, points = [], [], []
        for name, joint in scene.joints.items():
            places = [scene.point(point) for point in joint.connect]
            for place in places[1:]:
                joints.append(name)
                bodies.append([index[places[0][0]], index[place[0]]])
                points.append([places[0][1], place[1]])
        first, second = (index[point.split(".")[0]] for point in scene.joints[scene.drive.joint].connect)
        return cls(links, tuple(joints), np.array(bodies), np.array(points), (first, second))

    def frames(self, q: Array) -> tuple[Array, Array]:
        """Origins ``(positions, links + 1, 2)`` and angles ``(positions, links + 1)``; the ground's are the last."""
        poses = np.concatenate([q.reshape(len(q), -1, 3), np.zeros((len(q), 1, 3))], axis=1)
        return poses[..., :2], poses[..., 2]

    def arms(self, q: Array) -> Array:
        """Arms of the pairs' points, turned into the fixed frame (m), shape ``(positions, pairs, 2, 2)``."""
        angle = self.frames(q)[1][:, self.body]
        c, s = np.cos(angle), np.sin(angle)
        x, y = self.point[..., 0], self.point[..., 1]
        return np.stack([c * x - s * y, s * x + c * y], axis=-1)

    def residual(self, q: Array, theta: Array) -> Array:
        """What is left open of each loop equation (m, and rad for the drive), shape ``(positions, 2 pairs + 1)``."""
        origin, angle = self.frames(q)
        points = origin[:, self.body] + self.arms(q)
        gaps = points[:, :, 1] - points[:, :, 0]
        turn = angle[:, self.driven[1]] - angle[:, self.driven[0]] - theta
        return np.concatenate([gaps.reshape(len(q), -1), turn[:, None]], axis=1)

    def jacobian(self, q: Array) -> Array:
        """Derivative of the residual by the coordinates, shape ``(positions, 2 pairs + 1, 3 links)``."""
        arms = self.arms(q)
        constant, rows, columns = self._pattern
        jacobian = np.broadcast_to(constant, (len(q), *constant.shape)).copy()
        jacobian[:, rows, columns] = np.array([-1.0, 1.0]) * -arms[..., 1]
        jacobian[:, rows + 1, columns] = np.array([-1.0, 1.0]) * arms[..., 0]
        return jacobian[..., :-3]

    @cached_property
    def _pattern(self) -> tuple[Array, NDArray[np.int64], NDArray[np.int64]]:
        """Constant part of the Jacobian, with the ground's columns last, and where the arms enter it."""
        column = 3 * np.where(self.body == GROUND, len(self.links), self.body)
        row = np.broadcast_to(2 * np.arange(len(self.joint))[:, None], column.shape)
        constant = np.zeros((2 * len(self.joint) + 1, 3 * len(self.links) + 3))
        for i in (0, 1):
            constant[row + i, column + i] = [-1.0, 1.0]
        first, second = (3 * (body if body != GROUND else len(self.links)) + 2 for body in self.driven)
        constant[-1, first], constant[-1, second] = -1.0, 1.0
        return constant, row, column + 2

    def convective(self, q: Array, velocity: Array) -> Array:
        """Right-hand side of the acceleration equations: minus the centripetal part of the pairs' accelerations."""
        spin = np.concatenate([velocity[:, 2::3], np.zeros((len(q), 1))], axis=1)[:, self.body]
        centripetal = -(spin**2)[..., None] * self.arms(q)
        rows = -(centripetal[:, :, 1] - centripetal[:, :, 0])
        return np.concatenate([rows.reshape(len(q), -1), np.zeros((len(q), 1))], axis=1)
