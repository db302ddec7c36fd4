"""Gear pairs, belts and chains between two pins: the stiffness and damping of their teeth or strands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects.causes import Cause
from fenics_mech.joints.joint_state import JointPlace, JointState, Touching, WithoutContact, Wrench
from fenics_mech.scene import GearPair


@dataclass(frozen=True)
class GearSide(WithoutContact):
    """One side of a gear pair: its moments are minus the derivatives of ``k e^2/2`` with ``e = b - i a - e0``.

    Parameters
    ----------
    joint, other
        Where this side acts, and where the other one does.
    stated
        What the scene states.
    driven
        Whether this side is that of the angle b, and not that of a.
    at_start
        e0 (rad), of the angles at the start.
    """

    joint: JointPlace
    other: JointPlace
    stated: GearPair
    driven: bool
    at_start: float
    cause = Cause.GEARS

    def wrench(self, time: Array, state: JointState, touching: Touching) -> Wrench:
        """Give the moment on the second body.

        Parameters
        ----------
        time, state, touching
            As of `JointLaw`.
        """
        there = self.other.state(state.links)
        a, b = (there, state) if self.driven else (state, there)
        error = b.place - self.stated.ratio * a.place - self.at_start
        rate = b.rate - self.stated.ratio * a.rate
        moment = -self.stated.stiffness * error - self.stated.damping * rate
        return self.joint.effort(state, moment if self.driven else -self.stated.ratio * moment)


def both_sides(stated: GearPair, joints: tuple[JointPlace, JointPlace], start: JointState) -> tuple[GearSide, GearSide]:
    """Give the sides of a gear pair at its joint, and at the one that it drives.

    Parameters
    ----------
    stated
        What the scene states.
    joints
        Its joint, and the one that it drives.
    start
        State of its joint at the start.
    """
    free = float(np.asarray(joints[1].state(start.links).place - stated.ratio * start.place)[0])
    return (
        GearSide(joints[0], joints[1], stated, driven=False, at_start=free),
        GearSide(joints[1], joints[0], stated, driven=True, at_start=free),
    )
