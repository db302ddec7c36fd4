"""Rotations of the plane and of space behind one interface; the kernels have the same two in `rotations.hpp`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array


@dataclass(frozen=True)
class Geometry:
    """The plane or space.

    Parameters
    ----------
    name
        "plane" or "space", as in the names of the kernels.
    d, turns
        Components of a place, and of a spin.
    """

    name: str
    d: int
    turns: int

    @property
    def size(self) -> int:
        """Coordinates of a pose."""
        return self.d + self.turns

    def skew(self, w: Array) -> Array:
        """Matrix of a spin: its product with a vector is the vector's rate, ``(..., d, d)``."""
        made = np.zeros((*w.shape[:-1], self.d, self.d))
        for k, (i, j) in enumerate([(0, 1)] if self.d == 2 else [(1, 2), (2, 0), (0, 1)]):
            made[..., j, i], made[..., i, j] = w[..., k], -w[..., k]
        return made

    def axial(self, W: Array) -> Array:
        """Spin of a skew matrix."""
        pairs = [(0, 1)] if self.d == 2 else [(1, 2), (2, 0), (0, 1)]
        return np.stack([(W[..., j, i] - W[..., i, j]) / 2 for i, j in pairs], axis=-1)

    def turn(self, c: Array) -> Array:
        """Rotation of a chart vector: an angle in the plane, 2 tan(angle/2) times the axis in space (Cayley)."""
        if self.d == 2:
            angle = c[..., 0].copy()  # rounding of functions over strides depends on where arrays lie
            cos, sin = np.cos(angle), np.sin(angle)
            return np.stack([np.stack([cos, -sin], axis=-1), np.stack([sin, cos], axis=-1)], axis=-2)
        C = self.skew(c)
        return np.eye(3) + (C + C @ C / 2) / (1 + np.sum(c * c, axis=-1) / 4)[..., None, None]

    def vector(self, R: Array) -> Array:
        """Chart vector of a rotation, the inverse of `turn`."""
        if self.d == 2:
            sin, cos = R[..., 1, 0].copy(), R[..., 0, 0].copy()  # as in `turn`
            return np.arctan2(sin, cos)[..., None]
        return np.asarray(4 * self.axial(R) / (1 + np.trace(R, axis1=-2, axis2=-1))[..., None])

    def spin(self, c: Array, rate: Array) -> Array:
        """Spin by the rate of a chart vector."""
        if self.d == 2:
            return rate
        return (rate + np.cross(c, rate) / 2) / (1 + np.sum(c * c, axis=-1) / 4)[..., None]

    def spin_rate(self, c: Array, rate: Array, second: Array) -> Array:
        """Angular acceleration by the first two rates of a chart vector."""
        if self.d == 2:
            return second
        w: Array = self.spin(c, rate)
        n: Array = 1 / (1 + np.sum(c * c, axis=-1) / 4)[..., None]
        return np.asarray(n * (second + np.cross(c, second) / 2 - np.sum(c * rate, axis=-1)[..., None] / 2 * w))

    def moment(self, arm: Array, force: Array) -> Array:
        """Moment of a force on an arm, ``(..., turns)``."""
        if self.d == 2:
            return np.asarray(arm[..., 0] * force[..., 1] - arm[..., 1] * force[..., 0])[..., None]
        return np.cross(arm, force)

    def from_chart(self, c: Array, force: Array) -> Array:
        """Moment whose power is that of a generalised force on the rate of a chart vector, ``(..., turns)``."""
        if self.d == 2:
            return force
        spins = np.stack([self.spin(c, np.broadcast_to(e, c.shape)) for e in np.eye(3)], axis=-2)  # transposed
        return np.asarray(np.linalg.solve(spins, force[..., None])[..., 0])

    def about(self, axis: Array, angle: Array) -> Array:
        """Rotation about an axis (in the plane about its normal) by angles ``(...)``: ``(..., d, d)`` (Rodrigues)."""
        n = np.ones(1) if self.d == 2 else np.asarray(axis, dtype=float) / np.linalg.norm(axis)
        K, angle = self.skew(n), np.asarray(angle)[..., None, None]
        return np.asarray(np.eye(self.d) + np.sin(angle) * K + (1 - np.cos(angle)) * (K @ K), dtype=np.float64)

    def axes(self, first: Array, second: Array | None = None) -> Array:
        """Rotation whose first axis is `first` and whose second lies towards `second` from it."""
        # In the plane the second axis is 90 degrees counter-clockwise of the first. In space it is any without
        # `second`.
        e = np.asarray(first, dtype=np.float64)
        e = e / np.linalg.norm(e)
        if self.d == 2:
            return np.asarray(np.stack([e, [-e[1], e[0]]], axis=1), dtype=np.float64)
        towards = np.eye(3)[np.argmin(np.abs(e))] if second is None else np.asarray(second, dtype=float)
        n = towards - e * (e @ towards)
        n /= np.linalg.norm(n)
        return np.stack([e, n, np.cross(e, n)], axis=1)


PLANE, SPACE = Geometry("plane", 2, 1), Geometry("space", 3, 3)
