"""Torques and forces at joints by laws of other packages."""

from __future__ import annotations

from dataclasses import dataclass

from fenics_mech._arrays import Array
from fenics_mech.joints.joint_state import JointPlace, JointState, Touching, WithoutContact, Wrench
from fenics_mech.scene.joint_laws import PluggedEffort
from fenics_mech.terms.causes import Cause


@dataclass(frozen=True)
class GivenEffort(WithoutContact):
    """An effort at a joint."""

    joint: JointPlace  # where it acts
    stated: PluggedEffort  # what the scene states
    cause = Cause.EFFORTS

    def wrench(self, time: Array, state: JointState, touching: Touching) -> Wrench:
        """Give the effort on the second body."""
        return self.joint.effort(state, self.stated.effort_at(time, state.place, state.rate))
