"""Places and velocities of points of the links at many states, and forces on them as forces on the coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array


@dataclass(frozen=True)
class LinkStates:
    """Coordinates of the links and their rates; the ground, which does not move, is the last body."""

    pose: Array  # x, y and angle of each body's frame (m, m, rad) and their rates, (states, links + 1, 3) each
    rate: Array

    @classmethod
    def of(cls, q: Array, velocity: Array) -> LinkStates:
        """Take coordinates of the links, ``(states, 3 links)``, and put the ground behind them."""
        whole = np.zeros((2, len(q), q.shape[1] // 3 + 1, 3))
        whole[0, :, :-1] = q.reshape(len(q), -1, 3)
        whole[1, :, :-1] = velocity.reshape(len(q), -1, 3)
        return cls(whole[0], whole[1])

    @cached_property
    def axes(self) -> tuple[Array, Array]:
        """Cosine and sine of each body's angle, ``(states, links + 1)`` each."""
        return np.cos(self.pose[..., 2]), np.sin(self.pose[..., 2])

    def turned(self, body: int, vector: Array | tuple[float, float]) -> Array:
        """Give a vector of a body's frame in the fixed frame, ``(states, 2)``."""
        # vector (2,)
        c, s = (part[:, body] for part in self.axes)
        return np.stack([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]], axis=-1)

    def point(self, body: int, arm: Array) -> tuple[Array, Array]:
        """Give place (m) and velocity (m/s) of a point that moves with a body, ``(states, 2)`` each."""
        # arm (states, 2) (m)
        return self.pose[:, body, :2] + arm, self.rate[:, body, :2] + self.rate[:, body, 2:] * quarter(arm)


def quarter(vectors: Array) -> Array:
    """Turn vectors ``(..., 2)`` by a quarter counter-clockwise."""
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)


def cross(first: Array, second: Array) -> Array:
    """Give the cross product of vectors in the plane, ``(...,)``."""
    # first, second (..., 2) each
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])


@dataclass(frozen=True)
class BodyForces:
    """Forces and moments on all bodies: what they do on the coordinates of the links."""

    # force along X and Y (N) and moment about each body's origin (N m), (states, links + 1, 3); what is added changes
    # it
    values: Array

    @classmethod
    def none(cls, states: int, links: int) -> BodyForces:
        """Give no forces yet."""
        return cls(np.zeros((states, links + 1, 3)))

    def add(self, body: int, arm: Array, force: Array) -> None:
        """Add a force at a point of a body."""
        # arm (states, 2) (m); force (states, 2) (N)
        self.values[:, body, :2] += force
        self.values[:, body, 2] += cross(arm, force)

    def turn(self, body: int, moment: Array) -> None:
        """Add a moment on a body (N m), ``(states,)``."""
        self.values[:, body, 2] += moment
