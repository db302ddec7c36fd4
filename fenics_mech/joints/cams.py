"""Cam and follower: a contact on one side, whose force acts on the follower and turns the cam back.

Source: Norton, Cam Design and Manufacturing Handbook (2009), chapter 10.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects.causes import Cause
from fenics_mech.joints.joint_state import JointPlace, JointState, Touching, Wrench
from fenics_mech.scene import Cam


@dataclass(frozen=True)
class CamSide:
    """One side of a cam and its follower, of which the indentation is ``d = h(a) - s``.

    Parameters
    ----------
    joint, other
        Where this side acts, and where the other one does.
    stated
        What the scene states.
    follows
        Whether this side is that of the stroke s, and not that of the cam's angle a.
    """

    joint: JointPlace
    other: JointPlace
    stated: Cam
    follows: bool
    cause = Cause.CONTACTS
    begins_open = False

    @property
    def contacts(self) -> int:
        """Number of contacts: the follower's side has it."""
        return int(self.follows)

    def depths(self, state: JointState) -> tuple[Array, Array]:
        """Give how far the cam is in the follower, and the rate of that, ``(contacts, states)`` each.

        Parameters
        ----------
        state
            How the bodies move.
        """
        if not self.follows:
            none = np.zeros((0, len(state.place)))
            return none, none
        depth, rate, _ = self._indentation(state)
        return depth[None], rate[None]

    def wrench(self, time: Array, state: JointState, touching: Touching) -> Wrench:
        """Give the force on the follower, or the moment on the cam.

        Parameters
        ----------
        time, state, touching
            As of `JointLaw`.
        """
        depth, rate, slope = self._indentation(state)
        push = self.stated.stiffness * np.maximum(depth, 0.0) * np.maximum(1 + self.stated.damping * rate, 0.0)
        return self.joint.effort(state, push if self.follows else -slope * push)  # virtual work of d

    def _indentation(self, state: JointState) -> tuple[Array, Array, Array]:
        """Indentation, its rate, and the slope of the lift, ``(states,)`` each."""
        there = self.other.state(state.links)
        cam, follower = (there, state) if self.follows else (state, there)
        lift = self.stated.lift_at(cam.place)
        return lift.value - follower.place, lift.first * cam.rate - follower.rate, lift.first


def both_sides_of_cam(stated: Cam, joints: tuple[JointPlace, JointPlace]) -> tuple[CamSide, CamSide]:
    """Give the sides of a cam at its joint, and at that of its follower.

    Parameters
    ----------
    stated
        What the scene states.
    joints
        Its joint, and the one that it drives.
    """
    return CamSide(joints[0], joints[1], stated, follows=False), CamSide(joints[1], joints[0], stated, follows=True)
