"""Clearance of a slider in its guide: both ends of the slider may touch either wall.

Source: Flores, Leine and Glocker, Multibody System Dynamics 23 (2010), for a slider of four corners between two walls.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.joints.contact_force import contact_force, rubbing
from fenics_mech.joints.joint_state import JointPlace, JointState, Touching, Wrench
from fenics_mech.joints.link_states import cross, quarter
from fenics_mech.scene import GuideClearance
from fenics_mech.terms.causes import Cause


@dataclass(frozen=True)
class SliderContact:
    """A slider of the second body between the walls of the first."""

    joint: JointPlace  # where it is
    stated: GuideClearance  # what the scene states
    cause = Cause.CONTACTS
    begins_open = True
    contacts = 4  # both ends at the lower wall, then at the upper one

    def _ends(self, state: JointState) -> Iterator[tuple[Array, Array, Array]]:
        """Each end of the slider, from the second body's point (m), its way from the guide's middle, its velocity."""
        # The last two are seen from the first body, (states, 2) each.
        turned = (state.angle - self.joint.turn)[:, None]
        axis = np.cos(turned) * state.along + np.sin(turned) * quarter(state.along)
        for side in (-0.5, 0.5):
            arm = side * self.stated.length * axis
            way = state.gap + arm
            moving = state.gap_rate + state.turning[1][:, None] * quarter(arm)
            yield arm, way, moving - state.turning[0][:, None] * quarter(way)

    def depths(self, state: JointState) -> tuple[Array, Array]:
        """Give how far each end is in each wall, and the rate of that, ``(4, states)`` each."""
        normal, depths, rates = quarter(state.along), [], []
        ends = list(self._ends(state))
        for wall in (-1.0, 1.0):
            for _, way, speed in ends:
                depths.append(wall * np.sum(normal * way, axis=-1) - self.stated.play)
                rates.append(wall * np.sum(normal * speed, axis=-1))
        return np.array(depths), np.array(rates)

    def wrench(self, time: Array, state: JointState, touching: Touching) -> Wrench:
        """Give what the walls exert on the slider."""
        normal, (depths, rates) = quarter(state.along), self.depths(state)
        force, moment = np.zeros_like(state.gap), np.zeros_like(state.place)
        ends = list(self._ends(state))
        for i in np.flatnonzero(touching.closed):
            wall, (arm, _, speed) = (-1.0 if i < len(ends) else 1.0), ends[i % len(ends)]
            push = contact_force(self.stated.contact, depths[i], rates[i], float(touching.speed[i]))
            friction = rubbing(self.stated, push, np.sum(state.along * speed, axis=-1))
            here = -wall * push[:, None] * normal - friction[:, None] * state.along
            force += here
            moment += cross(arm, here)
        return Wrench(force, moment, np.zeros_like(force))
