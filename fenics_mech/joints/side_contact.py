"""Contact on one side of a guide: a pin that may lift off the line or the member on which it slides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.joints.contact_force import contact_force, rubbing
from fenics_mech.joints.joint_state import JointPlace, JointState, Touching, Wrench
from fenics_mech.joints.link_states import quarter
from fenics_mech.scene import SideContact
from fenics_mech.terms.causes import Cause


@dataclass(frozen=True)
class OneSide:
    """A pin of the second body on one side of a guide of the first."""

    joint: JointPlace  # where it is
    stated: SideContact  # what the scene states
    cause = Cause.CONTACTS
    begins_open = True
    contacts = 1

    def _seen(self, state: JointState) -> tuple[Array, Array]:
        """Normal of the guide on the side of the pin, and the pin's velocity seen from the guide, ``(states, 2)``."""
        normal = (1.0 if self.stated.side == "left" else -1.0) * quarter(state.along)
        return normal, state.gap_rate - state.turning[0][:, None] * quarter(state.gap)

    def depths(self, state: JointState) -> tuple[Array, Array]:
        """Give how far the pin is beyond the guide, and the rate of that, ``(1, states)`` each."""
        (normal, speed), (lower, upper) = self._seen(state), self.joint.ends
        # beyond an end of the guide nothing touches
        depths = np.stack([-np.sum(normal * state.gap, axis=-1), state.place - lower, upper - state.place])
        rates = np.stack([-np.sum(normal * speed, axis=-1), state.rate, -state.rate])
        least = depths.argmin(axis=0)[None]
        return np.take_along_axis(depths, least, axis=0), np.take_along_axis(rates, least, axis=0)

    def wrench(self, time: Array, state: JointState, touching: Touching) -> Wrench:
        """Give what the guide exerts on the pin: normal force and friction."""
        none = np.zeros_like(state.gap)
        if not touching.closed[0]:
            return Wrench(none, np.zeros_like(state.place), none)
        (normal, speed), ((depth,), (rate,)) = self._seen(state), self.depths(state)
        push = contact_force(self.stated.contact, depth, rate, float(touching.speed[0]))
        friction = rubbing(self.stated, push, np.sum(state.along * speed, axis=-1))
        return Wrench(push[:, None] * normal - friction[:, None] * state.along, np.zeros_like(push), none)
