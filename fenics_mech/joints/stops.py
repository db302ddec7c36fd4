"""Stops: limits of a joint's angle or stroke, at which its bodies touch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.joints.contact_force import contact_force
from fenics_mech.joints.joint_state import JointPlace, JointState, Touching, Wrench
from fenics_mech.scene import Stop
from fenics_mech.terms.causes import Cause


@dataclass(frozen=True)
class StopContact:
    """The stops of a joint."""

    joint: JointPlace  # where they are
    stated: Stop  # what the scene states
    cause = Cause.CONTACTS
    begins_open = True

    @property
    def _limits(self) -> list[tuple[float, float]]:
        """Sign of the way on which each stop lies, and its place."""
        both = (-1.0, self.stated.lower), (1.0, self.stated.upper)
        return [(sign, limit) for sign, limit in both if limit is not None]

    @property
    def contacts(self) -> int:
        """Number of stops."""
        return len(self._limits)

    def depths(self, state: JointState) -> tuple[Array, Array]:
        """Give how far the joint is beyond each stop, and the rate of that, ``(contacts, states)`` each."""
        beyond = [sign * (state.place - limit) for sign, limit in self._limits]
        return np.array(beyond), np.array([sign * state.rate for sign, _ in self._limits])

    def wrench(self, time: Array, state: JointState, touching: Touching) -> Wrench:
        """Give what the stops exert on the second body."""
        pushed = np.zeros_like(state.place)
        depths, rates = self.depths(state)
        for (sign, _), depth, rate, closed, speed in zip(self._limits, depths, rates, touching.closed, touching.speed):
            if closed:
                pushed -= sign * contact_force(self.stated.contact, depth, rate, speed)
        return self.joint.effort(state, pushed)
