"""Poses and ends: what a term or a joint sees of a machine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fenics_mech._arrays import Array


@dataclass(frozen=True)
class End:
    """A place and axes fixed to a pose: a rigid arm, a hub, a weld, the axes of a member, a point of a rigid body.

    Parameters
    ----------
    pose
        Number of the pose.
    offset
        From the pose's place, in its axes ``(d,)`` (m).
    turn
        Its axes in those of the pose, ``(d, d)``.
    """

    pose: int
    offset: Array
    turn: Array


@dataclass
class PoseMotion:
    """Known motion of all poses at some instants.

    Parameters
    ----------
    r, v, a
        Places (m), velocities and accelerations, ``(instants, poses, d)``.
    R
        Rotations, ``(instants, poses, d, d)``.
    w, al
        Spins (rad/s) and angular accelerations, ``(instants, poses, turns)``.
    """

    r: Array
    R: Array
    v: Array
    w: Array
    a: Array
    al: Array

    @property
    def arrays(self) -> tuple[Array, ...]:
        """Its fields, in their order."""
        return self.r, self.R, self.v, self.w, self.a, self.al

    def part(self, which: Any) -> PoseMotion:
        """Give the motion at some of the instants."""
        return PoseMotion(*(x[which] for x in self.arrays))

    @classmethod
    def joined(cls, parts: Sequence[PoseMotion]) -> PoseMotion:
        """Put motions one after the other."""
        return cls(*map(np.concatenate, zip(*(one.arrays for one in parts))))
