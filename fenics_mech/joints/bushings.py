"""Bushings: a soft bearing in place of a pin, with stiffness and damping along two directions and in rotation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.joints.joint_state import JointPlace, JointState, Touching, WithoutContact, Wrench
from fenics_mech.joints.link_states import quarter
from fenics_mech.scene import Bushing
from fenics_mech.terms.causes import Cause


@dataclass(frozen=True)
class SoftBearing(WithoutContact):
    """A bushing between two bodies; its axes turn with the first."""

    joint: JointPlace  # where it is
    stated: Bushing  # what the scene states
    cause = Cause.BUSHINGS

    def wrench(self, time: Array, state: JointState, touching: Touching) -> Wrench:
        """Give what the bushing exerts on the second body, at its point."""
        axes = state.along, quarter(state.along)  # x and y of the first body
        seen = state.gap_rate - state.turning[0][:, None] * quarter(state.gap)
        force = np.zeros_like(state.gap)
        for axis, stiffness, damping in zip(axes, self.stated.stiffness, self.stated.damping):
            pull = stiffness * np.sum(axis * state.gap, axis=-1) + damping * np.sum(axis * seen, axis=-1)
            force -= pull[:, None] * axis
        moment = -self.stated.turning_stiffness * (state.place - self.stated.turned)
        return Wrench(force, moment - self.stated.turning_damping * state.rate, np.zeros_like(force))
