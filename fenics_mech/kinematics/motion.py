"""Position, velocity and acceleration of all links at all drive angles."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace

import numpy as np

from fenics_mech._arrays import Array


@dataclass(frozen=True)
class Motion:
    """Rigid-body motion of the links' frames. Arrays are ``(angles, links)``; vectors have x, y (fixed frame) last.

    Parameters
    ----------
    theta
        Drive coordinate (rad), shape ``(angles,)``.
    time
        Time (s), theta over the cycle's rate, shape ``(angles,)``.
    links
        Names of the links.
    position, velocity, acceleration
        Of the frames' origins (m, m/s, m/s^2), shape ``(angles, links, 2)``.
    angle, omega, alpha
        Angle, angular velocity and acceleration (rad, rad/s, rad/s^2); angles are continuous, not wrapped.
    free
        Small motions of the frames (m, m, rad) that the joints of a linkage at rest leave, ``(motions, links, 3)``; see
        `free_motions`. With drives there are none.
    """

    theta: Array
    time: Array
    links: tuple[str, ...]
    position: Array
    velocity: Array
    acceleration: Array
    angle: Array
    omega: Array
    alpha: Array
    free: Array = field(default_factory=lambda: np.zeros((0, 0, 3)))

    def part(self, angles: slice) -> Motion:
        """Give the motion at some of the angles."""
        if angles.indices(len(self.theta)) == (0, len(self.theta), 1):
            return self
        whole = ("links", "free")
        arrays = {f.name: getattr(self, f.name)[angles] for f in fields(self) if f.name not in whole}
        return replace(self, **arrays)

    def held(self) -> Motion:
        """Give the same positions at rest."""
        rates = {name: np.zeros_like(getattr(self, name)) for name in ("velocity", "acceleration", "omega", "alpha")}
        return replace(self, **rates)

    def of_point(self, link: str, point: tuple[float, float]) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration of a point of a link or the ground, each of shape ``(angles, 2)``."""
        # point (m)
        if link == "ground":
            place = np.broadcast_to(np.array(point, dtype=float), (len(self.theta), 2))
            return place, np.zeros_like(place), np.zeros_like(place)
        i = self.links.index(link)
        c, s = np.cos(self.angle[:, i]), np.sin(self.angle[:, i])
        arm = np.stack([c * point[0] - s * point[1], s * point[0] + c * point[1]], axis=-1)
        normal = np.stack([-arm[:, 1], arm[:, 0]], axis=-1)
        omega, alpha = self.omega[:, i, None], self.alpha[:, i, None]
        return (
            self.position[:, i] + arm,
            self.velocity[:, i] + omega * normal,
            self.acceleration[:, i] + alpha * normal - omega**2 * arm,  # (6.29)
        )


def coordinates(vectors: Array, angles: Array) -> Array:
    """Put x, y ``(angles, links, 2)`` and angles ``(angles, links)``, or their rates, into ``(angles, 3 links)``."""
    # vectors (m); angles (rad)
    return np.concatenate([vectors, angles[..., None]], axis=-1).reshape(len(angles), -1)
