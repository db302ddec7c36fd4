"""Position, velocity and acceleration of all links at all drive angles, on the scene's assembly branch."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from fenics_mech.errors import AssemblyError
from fenics_mech.kinematics.assembly import assemble, follow
from fenics_mech.kinematics.loops import Array, Loops
from fenics_mech.scene import Scene


@dataclass(frozen=True)
class Motion:
    """Rigid-body motion of the links' frames. Arrays are ``(angles, links)``; vectors have x, y (fixed frame) last.

    Parameters
    ----------
    theta
        Drive angle (rad), shape ``(angles,)``.
    time
        Time (s), theta/speed, shape ``(angles,)``.
    links
        Names of the links.
    position, velocity, acceleration
        Of the frames' origins (m, m/s, m/s^2), shape ``(angles, links, 2)``.
    angle, omega, alpha
        Angle, angular velocity and acceleration (rad, rad/s, rad/s^2); angles are continuous, not wrapped.
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

    def part(self, angles: slice) -> Motion:
        """Give the motion at some of the angles."""
        arrays = {field.name: getattr(self, field.name)[angles] for field in fields(self) if field.name != "links"}
        return Motion(links=self.links, **arrays)

    def of_point(self, link: str, point: tuple[float, float]) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration of a point of a link's frame, each of shape ``(angles, 2)``."""
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


def solve_motion(scene: Scene, theta: Array) -> Motion:
    """Solve the loop equations of a scene and their two time derivatives.

    Parameters
    ----------
    scene
        The linkage and its drive, which turns at constant speed.
    theta
        Drive angles (rad), in any order, shape ``(angles,)``.

    Raises
    ------
    AssemblyError
        When the links cannot be assembled at the start, or the drive cannot reach one of the angles.
    """
    theta = np.asarray(theta, dtype=float)
    loops = Loops.of(scene)
    q = follow(loops, assemble(scene, loops), theta)
    jacobian = loops.jacobian(q)
    driven = np.zeros((*jacobian.shape[:2], 1))
    driven[:, -1] = scene.drive.speed
    try:
        velocity = np.linalg.solve(jacobian, driven)[..., 0]  # (6.2) for all loops
        acceleration = np.linalg.solve(jacobian, loops.convective(q, velocity)[..., None])[..., 0]  # (6.3)
    except np.linalg.LinAlgError as error:
        raise AssemblyError("the linkage is at a dead centre: its velocities are not determined") from error
    poses, rates, seconds = (array.reshape(len(q), -1, 3) for array in (q, velocity, acceleration))
    return Motion(
        theta=theta,
        time=theta / scene.drive.speed,
        links=loops.links,
        position=poses[..., :2],
        velocity=rates[..., :2],
        acceleration=seconds[..., :2],
        angle=poses[..., 2],
        omega=rates[..., 2],
        alpha=seconds[..., 2],
    )
