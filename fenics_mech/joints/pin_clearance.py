"""Radial clearance of a pin: journal and bearing touch where the journal has crossed the clearance.

Source: Flores, Ambrosio, Claro and Lankarani, Kinematics and Dynamics of Multibody Systems
with Imperfect Joints (2008), chapter 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.joints.contact_force import contact_force, rubbing
from fenics_mech.joints.joint_state import JointPlace, JointState, Touching, Wrench
from fenics_mech.joints.link_states import quarter
from fenics_mech.scene import Clearance
from fenics_mech.terms.causes import Cause


@dataclass(frozen=True)
class JournalContact:
    """A journal of the second body in a bearing of the first."""

    joint: JointPlace  # where it is
    stated: Clearance  # what the scene states
    cause = Cause.CONTACTS
    begins_open = True
    contacts = 1

    def depths(self, state: JointState) -> tuple[Array, Array]:
        """Give how far the journal is in the bearing's wall, and the rate of that, ``(1, states)`` each."""
        size, normal = _polar(state.gap)
        return (size - self.stated.radial)[None], np.sum(normal * state.gap_rate, axis=-1)[None]

    def wrench(self, time: Array, state: JointState, touching: Touching) -> Wrench:
        """Give what the bearing exerts on the journal: normal force and friction at the bearing's wall."""
        size, normal = _polar(state.gap)
        if not touching.closed[0]:
            return Wrench(np.zeros_like(normal), np.zeros_like(size), np.zeros_like(normal))
        (depth,), (rate,) = self.depths(state)
        push = contact_force(self.stated.contact, depth, rate, float(touching.speed[0]))
        tangent, (first, second) = quarter(normal), state.turning
        # speed of the journal's surface along the wall, at the one place on the wall where both touch
        sliding = np.sum(tangent * state.gap_rate, axis=-1)
        sliding += second * (self.stated.radius - size) - first * self.stated.radius
        force = -push[:, None] * normal - rubbing(self.stated, push, sliding)[:, None] * tangent
        return Wrench(force, np.zeros_like(size), (self.stated.radius - size)[:, None] * normal)


def _polar(gap: Array) -> tuple[Array, Array]:
    """Size of a gap (m), ``(states,)``, and its direction, ``(states, 2)``."""
    size = np.hypot(*gap.T)
    return size, gap / np.maximum(size, TINY)[:, None]
