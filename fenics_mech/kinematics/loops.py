"""Loop equations of a linkage, their Jacobian, and the right-hand sides for velocity and acceleration.

Each moving link has the coordinates (x, y, phi) of its frame. Every joint is made of equations between two bodies a and
b, of three kinds: a point of b coincides with one of a; a point of b lies on a line of a; the angle from a to b is
given. A drive gives the angle, or the distance along the line, as a function of the drive coordinate. All functions
work on many positions at once: coordinates have shape ``(positions, 3 links)``.

Source: Nikravesh, Computer-Aided Analysis of Mechanical Systems (1988), chapter 4.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.scene import Prismatic, Scene, Slot
from fenics_mech.scene.formulas.expression import Jet
from fenics_mech.scene.numbering import GROUND

Row = tuple[str, int, int, tuple[float, float], tuple[float, float], float]


@dataclass(frozen=True)
class LoopEquations:
    """Equations of one kind between pairs of bodies."""

    name: tuple[str, ...]  # joint of each
    body: Index  # the bodies a and b, as index into the links or `GROUND`, (pairs, 2)
    point: Array  # a point in each body's frame (m), (pairs, 2, 2)
    angle: Array  # direction of the line in a's frame, or the given angle (rad), (pairs,)

    @classmethod
    def of(cls, rows: list[Row]) -> LoopEquations:
        """Make the arrays from a list of (joint, body a, body b, point of a, point of b, angle)."""
        names = tuple(row[0] for row in rows)
        body = np.array([row[1:3] for row in rows], dtype=np.int64).reshape(-1, 2)
        point = np.array([row[3:5] for row in rows], dtype=float).reshape(-1, 2, 2)
        return cls(names, body, point, np.array([row[5] for row in rows], dtype=float))

    def __len__(self) -> int:
        return len(self.name)


@dataclass(frozen=True)
class Loops:
    """All equations of a scene: points, then lines, then angles, then drives and freedoms (angles, then strokes)."""

    scene: Scene  # the linkage; its links give the order of the coordinates
    points: LoopEquations  # equations of the joints
    lines: LoopEquations
    angles: LoopEquations
    driven_angles: LoopEquations  # equations of the drives, and of the freedoms
    driven_strokes: LoopEquations
    drive_order: tuple[int, ...]  # which of the scene's `moved_joints` each driven equation is of

    @classmethod
    def of(cls, scene: Scene) -> Loops:
        """Collect the equations of a scene's joints and drives."""
        index = {"ground": GROUND} | {name: i for i, name in enumerate(scene.links)}
        points: list[Row] = []
        lines: list[Row] = []
        angles: list[Row] = []
        for name, joint in scene.constraints.items():
            (first, at), *others = ((index[body], point) for body, point in map(scene.point, joint.connect))
            for second, pin in others:
                row = (name, first, second, at, pin)
                if isinstance(joint, Slot | Prismatic):
                    lines.append((*row, scene.guide_angle(joint)))
                else:
                    points.append((*row, 0.0))
                if joint.kind == "weld":
                    angles.append((*row, joint.angle))
                elif joint.kind == "prismatic":
                    angles.append((*row, joint.turn))
        turning: list[Row] = []
        sliding: list[Row] = []
        order: list[int] = []
        for i, name in enumerate(scene.moved_joints):
            moved = scene.joints[name]
            (first, at), (second, pin) = ((index[body], point) for body, point in map(scene.point, moved.connect))
            if isinstance(moved, Slot | Prismatic):
                sliding.append((name, first, second, at, pin, scene.guide_angle(moved)))
                order.append(i)
            else:
                turning.append((name, first, second, at, pin, 0.0))
                order.insert(len(turning) - 1, i)
        joined = LoopEquations.of(points), LoopEquations.of(lines), LoopEquations.of(angles)
        return cls(scene, *joined, LoopEquations.of(turning), LoopEquations.of(sliding), tuple(order))

    @cached_property
    def links(self) -> tuple[str, ...]:
        """Names of the moving links, in the order of their coordinates."""
        return tuple(self.scene.links)

    @property
    def drives(self) -> int:
        """Number of drives and freedoms."""
        return len(self.drive_order)

    def drive(self, theta: Array) -> Jet:
        """Angles (rad) and strokes (m) of the drives and two derivatives by theta, ``(positions, drives)`` each."""
        # theta (positions,) (rad)
        # Freedoms stand as drives that stay where they start.
        if not self.drives:
            return Jet(*(np.zeros((len(theta), 0)),) * 3)
        jets = [drive.jet(theta, self.scene.cycle_rate) for drive in self.scene.drives]
        jets += [freedom.held(theta) for freedom in self.scene.freedoms.values()]
        return Jet(*(np.stack(parts, axis=-1) for parts in zip(*((j.value, j.first, j.second) for j in jets))))

    @property
    def size(self) -> float:
        """Largest coordinate of a joint's point in its body (m), or 1 m where all are at their bodies' origins."""
        parts = [np.abs(pairs.point).max() for pairs in (self.points, self.lines) if len(pairs)]
        return float(max(parts, default=0.0)) or 1.0

    @cached_property
    def scale(self) -> Array:
        """Size of a unit of each equation, ``(equations,)``: `size` for lengths, 1 for angles."""
        lengths, angles = 2 * len(self.points) + len(self.lines), len(self.angles) + len(self.driven_angles)
        return np.concatenate(
            [np.full(lengths, self.size), np.ones(angles), np.full(len(self.driven_strokes), self.size)]
        )

    @cached_property
    def unit(self) -> Array:
        """Size of a unit of each coordinate, ``(3 links,)``: `size` for lengths, 1 for angles."""
        return np.tile([self.size, self.size, 1.0], len(self.links))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Joint of each equation."""
        doubled = [name for name in self.points.name for _ in range(2)]
        rest = (self.lines, self.angles, self.driven_angles, self.driven_strokes)
        return (*doubled, *(name for pairs in rest for name in pairs.name))

    def residual(self, q: Array, drive: Array) -> Array:
        """What is left open of each equation (m or rad), ``(positions, equations)``, for ``(positions, drives)``."""
        # q (positions, 3 links); drive (positions, drives)
        poses = _with_ground(q)
        given = drive[:, self.drive_order]
        turned, slid = given[:, : len(self.driven_angles)], given[:, len(self.driven_angles) :]
        parts = [_gap(poses, self.points).reshape(len(q), -1)]
        if len(self.lines):
            parts.append(_dot(_direction(poses, self.lines)[1], _gap(poses, self.lines)))
        for pairs, angle in ((self.angles, self.angles.angle), (self.driven_angles, turned)):
            if len(pairs):
                parts.append(np.diff(poses[:, pairs.body, 2], axis=-1)[..., 0] - angle)
        if len(self.driven_strokes):
            strokes = self.driven_strokes
            parts.append(_dot(_direction(poses, strokes)[0], _gap(poses, strokes)) - slid)
        return np.concatenate(parts, axis=1)

    def jacobian(self, q: Array) -> Array:
        """Derivative of the residual by the coordinates, ``(positions, equations, 3 links)``."""
        # q (positions, 3 links)
        poses = _with_ground(q)
        constant, rows, columns = self._pattern
        jacobian = np.broadcast_to(constant, (len(q), *constant.shape)).copy()
        arms = _arms(poses, self.points) * np.array([-1.0, 1.0])[:, None]
        jacobian[:, rows, columns] = -arms[..., 1]
        jacobian[:, rows + 1, columns] = arms[..., 0]
        start = 2 * len(self.points)
        if len(self.lines):
            tangent, normal = _direction(poses, self.lines)
            _add_projection(jacobian, start, poses, self.lines, normal, -tangent)
        start = len(self.names) - len(self.driven_strokes)
        if len(self.driven_strokes):
            tangent, normal = _direction(poses, self.driven_strokes)
            _add_projection(jacobian, start, poses, self.driven_strokes, tangent, normal)
        return jacobian[..., :-3]

    def without_units(self, q: Array) -> Array:
        """Give the Jacobian of equations and coordinates in their units, ``(positions, equations, 3 links)``."""
        return self.jacobian(q) * self.unit / self.scale[:, None]

    @cached_property
    def _pattern(self) -> tuple[Array, Index, Index]:
        """Constant part of the Jacobian, with the ground's columns last, and where the points' arms enter it."""
        links = len(self.links)
        constant = np.zeros((len(self.names), 3 * links + 3))
        column = _columns(self.points.body, links)
        row = np.broadcast_to(2 * np.arange(len(self.points))[:, None], column.shape)
        for i in (0, 1):
            constant[row + i, column + i] = [-1.0, 1.0]
        start = 2 * len(self.points) + len(self.lines)
        for pairs in (self.angles, self.driven_angles):
            for sign, bodies in zip((-1.0, 1.0), pairs.body.T):
                constant[start + np.arange(len(pairs)), _columns(bodies, links) + 2] += sign
            start += len(pairs)
        return constant, row, column + 2

    def driven(self, rates: Array) -> Array:
        """Right-hand side of the velocity equations for the drives' rates ``(positions, drives)``."""
        # rates (positions, drives)
        right = np.zeros((len(rates), len(self.names)))
        if self.drives:
            right[:, -self.drives :] = rates[:, self.drive_order]
        return right

    def convective(self, q: Array, velocity: Array) -> Array:
        """What the second time derivative of the residual has beside ``jacobian @ acceleration`` and the drive's."""
        # q, velocity (positions, 3 links) each
        poses, rates = _with_ground(q), _with_ground(velocity)
        squared = rates[..., 2] ** 2
        still = np.zeros((len(q), len(self.angles) + len(self.driven_angles)))
        parts = [-_relative(poses, self.points, squared).reshape(len(q), -1), still]
        if len(self.lines):
            parts.insert(1, self._turning(poses, rates, self.lines, -_relative(poses, self.lines, squared), 1))
        if len(self.driven_strokes):
            strokes = self.driven_strokes
            parts.append(self._turning(poses, rates, strokes, -_relative(poses, strokes, squared), 0))
        return np.concatenate(parts, axis=1)

    def _turning(self, poses: Array, rates: Array, pairs: LoopEquations, centripetal: Array, which: int) -> Array:
        """Convective part of the gap along a turning direction e of body a: e.c + 2 e'.gap' - omega^2 e.gap."""
        directions = _direction(poses, pairs)
        across = (directions[1], -directions[0])[which]  # derivative of the direction by a's angle
        omega = rates[:, pairs.body[:, 0], 2]
        drift = np.diff(rates[:, pairs.body, :2], axis=2)[:, :, 0] + _turned(_relative(poses, pairs, rates[..., 2]))
        gap = _gap(poses, pairs)
        return (
            _dot(directions[which], centripetal)
            + 2 * omega * _dot(across, drift)
            - omega**2 * _dot(directions[which], gap)
        )

    def places(self, q: Array, pairs: LoopEquations) -> Array:
        """Points of pairs in the fixed frame (m), ``(positions, pairs, 2, 2)``."""
        # q (positions, 3 links)
        poses = _with_ground(q)
        return poses[:, pairs.body, :2] + _arms(poses, pairs)

    def tangents(self, q: Array, pairs: LoopEquations) -> Array:
        """Directions of the pairs' lines in the fixed frame, ``(positions, pairs, 2)``."""
        # q (positions, 3 links)
        return _direction(_with_ground(q), pairs)[0]

    def gaps(self, q: Array) -> dict[str, float]:
        """Distance between each joint's points at one position (m), by joint."""
        # q (3 links,)
        poses = _with_ground(q[None])
        found: dict[str, float] = {}
        for name, gap in zip(self.points.name, np.linalg.norm(_gap(poses, self.points)[0], axis=-1)):
            found[name] = max(found.get(name, 0.0), float(gap))
        for name, gap in zip(self.lines.name, _dot(_direction(poses, self.lines)[1], _gap(poses, self.lines))[0]):
            found[name] = max(found.get(name, 0.0), abs(float(gap)))
        return found


def _with_ground(q: Array) -> Array:
    """Coordinates as ``(positions, links + 1, 3)``, the ground's being zero and the last."""
    return np.concatenate([q.reshape(len(q), -1, 3), np.zeros((len(q), 1, 3))], axis=1)


def _columns(body: Index, links: int) -> Index:
    return 3 * np.where(body == GROUND, links, body)


def _arms(poses: Array, pairs: LoopEquations) -> Array:
    """Points of the pairs seen from their bodies' origins, in the fixed frame, ``(positions, pairs, 2, 2)``."""
    angle = poses[:, pairs.body, 2]
    c, s = np.cos(angle), np.sin(angle)
    x, y = pairs.point[..., 0], pairs.point[..., 1]
    arms = np.empty((*angle.shape, 2))
    arms[..., 0] = c * x - s * y
    arms[..., 1] = s * x + c * y
    return arms


def _relative(poses: Array, pairs: LoopEquations, factor: Array) -> Array:
    """Arm of b times b's factor less that of a; factor is ``(positions, links + 1)``."""
    weighted = _arms(poses, pairs) * factor[:, pairs.body, None]
    return weighted[:, :, 1] - weighted[:, :, 0]


def _gap(poses: Array, pairs: LoopEquations) -> Array:
    """From the point of a to that of b, ``(positions, pairs, 2)``."""
    places = poses[:, pairs.body, :2] + _arms(poses, pairs)
    return places[:, :, 1] - places[:, :, 0]


def _direction(poses: Array, pairs: LoopEquations) -> tuple[Array, Array]:
    """Tangent and normal of the pairs' lines, which turn with a, each ``(positions, pairs, 2)``."""
    angle = poses[:, pairs.body[:, 0], 2] + pairs.angle
    tangent = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return tangent, _turned(tangent)


def _turned(vectors: Array) -> Array:
    """Vectors turned by 90 degrees counter-clockwise."""
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)


def _dot(a: Array, b: Array) -> Array:
    return np.sum(a * b, axis=-1)


def _add_projection(
    jacobian: Array, start: int, poses: Array, pairs: LoopEquations, along: Array, slope: Array
) -> None:
    """Add the derivative of ``along . gap``; slope is the derivative of `along` by a's angle."""
    rows, links = start + np.arange(len(pairs)), poses.shape[1] - 1
    turning = _turned(_arms(poses, pairs))
    for end, sign in ((0, -1.0), (1, 1.0)):
        column = _columns(pairs.body[:, end], links)
        jacobian[:, rows, column] += sign * along[..., 0]
        jacobian[:, rows, column + 1] += sign * along[..., 1]
        jacobian[:, rows, column + 2] += sign * _dot(along, turning[:, :, end])
    jacobian[:, rows, _columns(pairs.body[:, 0], links) + 2] += _dot(slope, _gap(poses, pairs))
