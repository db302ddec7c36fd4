"""What lies between two bodies, for springs and dampers: a line between two points, or a relative rotation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array, Index, summed
from fenics_mech.beams.attachment import QUARTER, Attachment
from fenics_mech.effects.rotation_forces import RotationForces, cosine, of_sines, rotated
from fenics_mech.effects.terms import Entries
from fenics_mech.errors import AssemblyError
from fenics_mech.kinematics import Motion
from fenics_mech.scene import Scene
from fenics_mech.scene.numbering import GROUND
from fenics_mech.scene.springs_dampers import Hinge, Line

if TYPE_CHECKING:
    from fenics_mech.beams.mesh import BeamMesh


@dataclass(frozen=True)
class SeparationLimits:
    """Limits of springs and dampers between two points or links."""

    shortest: float = 1e-9  # length of a line, of its longest over the cycle: below it the line has no direction
    stiffest: int = 30  # of the rotational stiffness of an element's end, 4EI/h, for a torsional spring: measured


SEPARATION = SeparationLimits()


@dataclass(frozen=True)
class Separation:
    """Displacement, or rotation, of one body against another; n is 2 for a line in the fixed frame, 1 for a rotation.

    It is linear in the elastic displacement v, as all of the joints' equations: points of a rigid link move with its
    small rotation times their arm. A rotation is that of which v has the sine, with large rotations.

    Parameters
    ----------
    dofs
        Nodal dofs of both bodies that take part, ``(k,)``.
    reach
        What the dofs in link axes add to it, ``(angles, n, k)``.
    turning
        The time derivative of `reach`, as the links turn (1/s), ``(angles, n, k)``.
    value, rate
        That of the rigid motion, and its time derivative, ``(angles, n)`` (m or rad).
    of_sines
        Whether the dofs are the sines of rotations.
    """

    dofs: Index
    reach: Array
    turning: Array
    value: Array
    rate: Array
    of_sines: bool = False

    @classmethod
    def of(cls, scene: Scene, mesh: BeamMesh, motion: Motion, part: Line | Hinge) -> Separation:
        """Find what lies between the two bodies of a spring or a damper.

        Parameters
        ----------
        scene
            The scene.
        mesh
            The mesh of its members.
        motion
            Its rigid motion.
        part
            The spring or damper.
        """
        if isinstance(part, Hinge):
            return cls._of_rotation(scene, mesh, motion, part)
        reaches, turnings, places, velocities = [], [], [], []
        ends = [Attachment.of(scene.links, scene.joints, mesh, point) for point in part.between]
        for end, name, sign in zip(ends, part.between, (-1.0, 1.0)):
            body, point = scene.point(name)
            place, velocity, _ = motion.of_point(body, point)
            angle, omega = (_of_body(array, end.link) for array in (motion.angle, motion.omega))
            c, s = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
            shift = sign * (c * np.eye(2) + s * QUARTER) @ end.shift  # (7.3)
            reaches.append(shift)
            turnings.append(omega[:, None, None] * (QUARTER @ shift))
            places.append(sign * place)
            velocities.append(sign * velocity)
        return cls(
            dofs=np.concatenate([end.dofs for end in ends]),
            reach=np.concatenate(reaches, axis=-1),
            turning=np.concatenate(turnings, axis=-1),
            value=places[0] + places[1],
            rate=velocities[0] + velocities[1],
        )

    @classmethod
    def _of_rotation(cls, scene: Scene, mesh: BeamMesh, motion: Motion, hinge: Hinge) -> Separation:
        points = {point.split(".")[0]: point for point in scene.joints[hinge.joint].connect}
        bodies = hinge.bodies or tuple(points)
        first, second = (Attachment.of(scene.links, scene.joints, mesh, points[body]) for body in bodies)
        angle, omega = (_of_body(a, second.link) - _of_body(a, first.link) for a in (motion.angle, motion.omega))
        signs = np.concatenate([-np.ones(len(first.dofs[2:])), np.ones(len(second.dofs[2:]))])
        reach = np.broadcast_to(signs, (len(angle), 1, len(signs)))
        dofs = np.concatenate([first.dofs[2:], second.dofs[2:]])
        return cls(dofs, reach, np.zeros_like(reach), angle[:, None], omega[:, None], of_sines(scene.named_effects))

    @property
    def length(self) -> Array:
        """Length of a line (m), ``(angles,)``; 1 for a rotation."""
        return np.linalg.norm(self.value, axis=1) if self.value.shape[1] > 1 else np.ones(len(self.value))

    def direction(self, motion: Motion, name: str) -> Array:
        """Direction of a line from its first to its second point, ``(angles, 2)``; 1 for a rotation.

        Parameters
        ----------
        motion
            The rigid motion, for the drive angle in the message.
        name
            Path of the spring or damper in the scene, for the message.

        Raises
        ------
        AssemblyError
            When its ends meet at some angle.
        """
        if self.value.shape[1] == 1:
            return np.ones_like(self.value)
        length = self.length
        k = int(length.argmin())
        if length[k] <= SEPARATION.shortest * length.max():
            raise AssemblyError(
                f"the ends of {name} meet at drive angle {np.degrees(motion.theta[k]):.6g} deg, where it has no "
                "direction: put them elsewhere"
            )
        return self.value / length[:, None]

    def turned(self, direction: Array, change: Array) -> Array:
        """Change of the direction by a change of the separation, both ``(angles, n)``; nothing for a rotation.

        Parameters
        ----------
        direction
            Unit vectors, ``(angles, n)``.
        change
            Change of the separation, or its rate, ``(angles, n)`` (m, m/s).
        """
        return (across(direction) @ change[..., None])[..., 0] / self.length[:, None]

    def force(self, pull: Array, size: int) -> Array:
        """Forces on the nodal dofs, ``(angles, size)``: `pull`, ``(angles, n)``, draws the second body to the first.

        Parameters
        ----------
        pull
            Force of a line (N), or moment of a rotation (N m), ``(angles, n)``.
        size
            Number of nodal dofs.
        """
        return summed(-np.einsum("tnk,tn->tk", self.reach, pull), self.dofs, size)

    def entries(self, tangent: Array, by: Array | None = None) -> Entries:
        """Matrix ``reach^T tangent reach`` of a tangent ``(angles, n, n)``, or with another right factor `by`.

        Parameters
        ----------
        tangent
            Stiffness or damping by the separation (N/m, N s/m; of a rotation N m/rad, N m s/rad), ``(angles, n, n)``.
        by
            The right factor, ``(angles, n, k)``; by default `reach`.
        """
        return Entries.of_blocks(self.dofs[None], self._onto(tangent, self.reach if by is None else by)[:, None])

    def _onto(self, tangent: Array, by: Array) -> Array:
        return np.asarray(self.reach.transpose(0, 2, 1) @ tangent @ by)

    def couples(
        self, pull: Array, stiffness: Array | float = 0.0, damping: Array | float = 0.0
    ) -> tuple[RotationForces, ...]:
        """Give what the moments of `force` and of `entries` are beyond linear theory, where v has sines.

        Parameters
        ----------
        pull
            Moment of a rotation (N m), ``(angles, 1)``.
        stiffness, damping
            Its changes by the rotation and its rate (N m/rad, N m s/rad), ``(angles, 1, 1)``.
        """
        if not self.of_sines:
            return ()
        moment = -np.einsum("tnk,tn->tk", self.reach, pull)
        one = self._onto(np.ones((len(pull), 1, 1)), self.reach)
        return (RotationForces.of_couples(self.dofs, moment, stiffness * one, damping * one),)

    def elastic(self, v: Array) -> Array:
        """What a displacement in link axes, ``(angles, nodal dofs)``, adds to the separation, ``(angles, n)``.

        Parameters
        ----------
        v
            The displacement, ``(angles, nodal dofs)``.
        """
        part = v[:, self.dofs]
        return np.einsum("tnk,tk->tn", self.reach, rotated(part) if self.of_sines else part)

    def elastic_rate(self, v: Array, rate: Array) -> Array:
        """What it and its velocity in link axes add to the separation's rate, ``(angles, n)``.

        Parameters
        ----------
        v, rate
            The displacement and its velocity, ``(angles, nodal dofs)``.
        """
        part, speed = v[:, self.dofs], rate[:, self.dofs]
        if self.of_sines:
            speed = speed / cosine(part)
        return np.einsum("tnk,tk->tn", self.turning, part) + np.einsum("tnk,tk->tn", self.reach, speed)


def across(direction: Array) -> Array:
    """Projection at right angles to a direction, ``(angles, n, n)``; nothing for a rotation.

    Parameters
    ----------
    direction
        Unit vectors, ``(angles, n)``.
    """
    return np.eye(direction.shape[1]) - direction[:, :, None] * direction[:, None, :]


def _of_body(by_link: Array, link: int) -> Array:
    return by_link[:, link] if link != GROUND else np.zeros(len(by_link))
