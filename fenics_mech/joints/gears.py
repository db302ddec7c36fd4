"""Gear pairs, belts and chains between two pins: the stiffness and damping of their teeth or strands.

Source: Norton, Machine Design (2006), section 12.2, for the force of teeth by their pressure angle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.joints.joint_state import JointPlace, JointState, Touching, WithoutContact, Wrench
from fenics_mech.joints.link_states import quarter
from fenics_mech.scene import GearPair
from fenics_mech.terms.causes import Cause


@dataclass(frozen=True)
class GearSide(WithoutContact):
    """One side of a gear pair: its moments are minus the derivatives of ``k e^2/2`` with ``e = b - i a - e0``."""

    joint: JointPlace  # where this side acts, and where the other one does
    other: JointPlace
    stated: GearPair  # what the scene states
    driven: bool  # whether this side is that of the angle b, and not that of a
    at_start: float  # e0 (rad), of the angles at the start
    cause = Cause.GEARS

    def wrench(self, time: Array, state: JointState, touching: Touching) -> Wrench:
        """Give the moment on the second body."""
        there = self.other.state(state.links)
        a, b = (there, state) if self.driven else (state, there)
        error = b.place - self.stated.ratio * a.place - self.at_start
        rate = b.rate - self.stated.ratio * a.rate
        moment = -self.stated.stiffness * error - self.stated.damping * rate
        own = moment if self.driven else -self.stated.ratio * moment
        if self.stated.pressure_angle is None:
            return self.joint.effort(state, own)
        first, second = (self.other, self.joint) if self.driven else (self.joint, self.other)
        force = self._of_teeth(second.pin(b) - first.pin(a), moment)  # on the driven gear
        return Wrench(force if self.driven else -force, own, np.zeros_like(force))

    def _of_teeth(self, way: Array, moment: Array) -> Array:
        """Force on the driven gear (N), ``(states, 2)``, by the way from the other pin to its own and its moment."""
        assert self.stated.pressure_angle is not None
        share = self.stated.ratio / (self.stated.ratio - 1)  # of the way, at which the pitch circles touch
        distance = np.linalg.norm(way, axis=-1)
        towards = way / distance[:, None]
        along = moment / ((share - 1) * distance)  # the pitch circles
        # teeth push a gear towards its own centre, but for one with inner teeth: the larger of two on one side
        sense = np.sign(1 - share) if abs(1 - share) < abs(share) else np.sign(share)
        apart = sense * np.abs(along) * np.tan(self.stated.pressure_angle)
        return np.asarray(along[:, None] * quarter(towards) + apart[:, None] * towards)


def both_sides(stated: GearPair, joints: tuple[JointPlace, JointPlace], start: JointState) -> tuple[GearSide, GearSide]:
    """Give the sides of a gear pair at its joint, and at the one that it drives."""
    if stated.pressure_angle is not None:  # gears push each other, and not the bodies that bear them
        joints = replace(joints[0], elsewhere=True), replace(joints[1], elsewhere=True)
    free = float(np.asarray(joints[1].state(start.links).place - stated.ratio * start.place)[0])
    return (
        GearSide(joints[0], joints[1], stated, driven=False, at_start=free),
        GearSide(joints[1], joints[0], stated, driven=True, at_start=free),
    )
