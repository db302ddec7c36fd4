"""Frames that joint laws act on: where bodies that bend have their joints, how these move, and forces on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array, Index, summed, turned
from fenics_mech.beams.attachment import Attachment
from fenics_mech.effects.rotation_forces import cosine, rotated
from fenics_mech.joints.link_states import LinkStates, quarter
from fenics_mech.kinematics import Motion
from fenics_mech.scene import Scene
from fenics_mech.terms.causes import Cause

if TYPE_CHECKING:
    from fenics_mech.beams.mesh import BeamMesh


@dataclass(frozen=True)
class JointFrames:
    """Frames at points of links, each fixed to the node there and turned as its link where that does not bend.

    As everywhere, points of a rigid link move with its small rotation times their arm.

    Parameters
    ----------
    links
        Link of each frame, ``(frames,)``.
    points
        The points in the frames of their links (m), ``(frames, 2)``.
    dofs
        Nodal dofs that move each, ``(frames, 3)``.
    shifts
        The points' displacements by these, ``(frames, 2, 3)``; their rotations are the third.
    of_sines
        Whether rotational dofs are the sines of rotations.
    """

    links: Index
    points: Array
    dofs: Index
    shifts: Array
    of_sines: bool

    @classmethod
    def of(cls, scene: Scene, mesh: BeamMesh, names: Sequence[str], of_sines: bool) -> JointFrames:
        """Find the frames at points "link.point", and at nodes "member@0.3".

        Parameters
        ----------
        scene
            The scene.
        mesh
            The mesh of its members.
        names
            The points; none of them is on the ground.
        of_sines
            As of the class.
        """
        found = [Attachment.of(scene.links, scene.joints, mesh, name) for name in names]
        return cls(
            np.array([at.link for at in found]),
            np.array([scene.place(name)[1] for name in names], dtype=float),
            np.array([at.dofs for at in found]),
            np.array([at.shift for at in found]),
            of_sines,
        )

    def __len__(self) -> int:
        return len(self.links)

    def states(self, motion: Motion, v: Array, rate: Array) -> LinkStates:
        """Give place and velocity of the frames, as those of bodies.

        Parameters
        ----------
        motion
            The rigid motion, or one with virtual rates.
        v, rate
            Elastic displacement and its rate in link axes, ``(angles, nodal dofs)`` each.
        """
        angle, omega = motion.angle[:, self.links], motion.omega[:, self.links]
        arms = turned(self.points + self._of_points(v), angle)
        moved = motion.velocity[:, self.links] + omega[..., None] * quarter(arms)
        sine, speed = v[:, self.dofs[:, 2]], rate[:, self.dofs[:, 2]]
        turn = rotated(sine) if self.of_sines else sine
        pose, rates = np.zeros((2, len(v), len(self) + 1, 3))  # the ground is the last body
        pose[:, :-1, :2] = motion.position[:, self.links] + arms
        pose[:, :-1, 2] = angle + turn
        rates[:, :-1, :2] = moved + turned(self._of_points(rate), angle)
        rates[:, :-1, 2] = omega + speed / self._cosine(sine)
        return LinkStates(pose, rates)

    def on_nodes(self, motion: Motion, v: Array, forces: Array) -> Array:
        """Give forces on the frames as forces on the nodal dofs, which do the same work, ``(..., angles, nodal dofs)``.

        Parameters
        ----------
        motion
            The rigid motion.
        v
            Elastic displacement in link axes, ``(angles, nodal dofs)``.
        forces
            Force along X and Y (N) and moment (N m) on each frame, ``(..., angles, frames, 3)``.
        """
        own = turned(forces[..., :2], -motion.angle[:, self.links])
        on_dofs = np.einsum("fij,...fi->...fj", self.shifts, own)
        on_dofs[..., 2] += forces[..., 2] / self._cosine(v[:, self.dofs[:, 2]])
        return summed(on_dofs.reshape(*forces.shape[:-2], -1), self.dofs.ravel(), v.shape[1])

    def reach(self, motion: Motion, v: Array, moved: Array) -> Array:
        """Give how the frames move by coordinates that move the nodes, ``(angles, 3 frames, coordinates)``.

        Parameters
        ----------
        motion
            The rigid motion.
        v
            Elastic displacement in link axes, ``(angles, nodal dofs)``.
        moved
            The nodal dofs by each coordinate, ``(angles, coordinates, nodal dofs)``.
        """
        at = moved[:, :, self.dofs]
        along = np.einsum("fij,tcfj->tcfi", self.shifts, at)
        turn = at[..., 2] / self._cosine(v[:, self.dofs[:, 2]])[:, None]
        angle = np.broadcast_to(motion.angle[:, None, self.links], turn.shape)
        found = np.concatenate([turned(along, angle), turn[..., None]], axis=-1)
        return np.moveaxis(found.reshape(*found.shape[:2], -1), 1, 2)

    def _of_points(self, v: Array) -> Array:
        return np.einsum("fij,tfj->tfi", self.shifts, v[:, self.dofs])

    def _cosine(self, sine: Array) -> Array:
        return cosine(sine) if self.of_sines else np.ones_like(sine)


@dataclass(frozen=True)
class LawForces:
    """What a joint law exerts on the frames of its joint.

    Parameters
    ----------
    joint
        Name of the joint, or of the other one that a gear pair drives; empty where the joint has no part of it.
    bodies
        Indices of the frames of its two bodies; -1 is the ground.
    cause
        Under which cause its power is listed.
    frames
        The frames.
    values
        Force along X and Y (N) and moment about the frame's origin (N m), on the ground last,
        ``(angles, frames + 1, 3)``.
    nodal
        The same on the nodal dofs in link axes, ``(angles, nodal dofs)``.
    """

    joint: str
    bodies: tuple[int, int]
    cause: Cause
    frames: JointFrames
    values: Array
    nodal: Array

    @property
    def force(self) -> Array:
        """Force on the joint's second body (N), ``(angles, 2)``."""
        return self.values[:, self.bodies[1], :2]

    def power(self, motion: Motion, v: Array, rate: Array) -> Array:
        """Give its power in rates of the mechanism (W), ``(angles,)``.

        Parameters
        ----------
        motion, v, rate
            As of `JointFrames.states`.
        """
        return np.asarray(np.sum(self.values * self.frames.states(motion, v, rate).rate, axis=(1, 2)))
