"""Cam and follower: a contact on one side, whose force acts on the follower and turns the cam back.

A follower that slides has a flat face across its guide. By the slope h' of the lift it touches the cam beside the line
through the cam's pin, at h' from it: the virtual work of the lift is that of the force there.

Source: Norton, Cam Design and Manufacturing Handbook (2009), chapter 10.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.joints.joint_state import JointPlace, JointState, Touching, Wrench
from fenics_mech.joints.link_states import quarter
from fenics_mech.scene import Cam
from fenics_mech.terms.causes import Cause


@dataclass(frozen=True)
class CamSide:
    """One side of a cam and its follower, of which the indentation is ``d = h(a) - s``."""

    joint: JointPlace  # where this side acts, and where the other one does
    other: JointPlace
    stated: Cam  # what the scene states
    follows: bool  # whether this side is that of the stroke s, and not that of the cam's angle a
    cause = Cause.CONTACTS
    begins_open = False

    @property
    def contacts(self) -> int:
        """Number of contacts: the follower's side has it."""
        return int(self.follows)

    def depths(self, state: JointState) -> tuple[Array, Array]:
        """Give how far the cam is in the follower, and the rate of that, ``(contacts, states)`` each."""
        if not self.follows:
            none = np.zeros((0, len(state.place)))
            return none, none
        depth, rate, _ = self._indentation(state)
        return depth[None], rate[None]

    def wrench(self, time: Array, state: JointState, touching: Touching) -> Wrench:
        """Give the force on the follower, or the moment on the cam."""
        depth, rate, slope = self._indentation(state)
        push = self.stated.stiffness * np.maximum(depth, 0.0) * np.maximum(1 + self.stated.damping * rate, 0.0)
        if not self.joint.elsewhere:
            return self.joint.effort(state, push if self.follows else -slope * push)  # virtual work of d
        cam, follower = self._both(state)
        tangent, away = follower.along, (self.stated.radius or 0.0) + self.stated.lift_at(cam.place).value
        sideways = quarter(tangent)  # along the follower's face
        rubs = self.stated.friction * push * np.tanh(cam.rate * away / self.stated.width)
        force = push[:, None] * tangent + rubs[:, None] * sideways  # on the follower
        if not self.follows:
            return Wrench(-force, -slope * push - rubs * away, np.zeros_like(force))
        at = self.other.pin(cam) + away[:, None] * tangent - slope[:, None] * sideways  # where they touch
        return Wrench(force, np.zeros_like(push), at - self.joint.pin(follower))

    def _both(self, state: JointState) -> tuple[JointState, JointState]:
        """State of the cam's joint, and of the follower's."""
        there = self.other.state(state.links)
        return (there, state) if self.follows else (state, there)

    def _indentation(self, state: JointState) -> tuple[Array, Array, Array]:
        """Indentation, its rate, and the slope of the lift, ``(states,)`` each."""
        cam, follower = self._both(state)
        lift = self.stated.lift_at(cam.place)
        return lift.value - follower.place, lift.first * cam.rate - follower.rate, lift.first


def both_sides_of_cam(
    stated: Cam, joints: tuple[JointPlace, JointPlace], keeps_direction: bool
) -> tuple[CamSide, CamSide]:
    """Give the sides of a cam at its joint, and at that of its follower."""
    if keeps_direction and all(joint.bodies[1] >= 0 for joint in joints):
        joints = replace(joints[0], elsewhere=True), replace(joints[1], elsewhere=True)
    return CamSide(joints[0], joints[1], stated, follows=False), CamSide(joints[1], joints[0], stated, follows=True)
