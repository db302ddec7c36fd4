"""Dry friction of pins and sliders: Coulomb's law with Stribeck's fall, regularised.

The friction is a share of the joint's force, which it changes in turn. It enters the balance as an unknown of its own.
Source: Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994); Threlfall, Mech. Mach. Theory 13 (1978).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects.causes import Cause
from fenics_mech.joints.joint_state import JointPlace, JointState, Touching, WithoutContact, Wrench
from fenics_mech.scene import Friction


@dataclass(frozen=True)
class DryFriction(WithoutContact):
    """Dry friction at a joint, with its viscous share.

    Parameters
    ----------
    joint
        Where it acts.
    stated
        What the scene states.
    """

    joint: JointPlace
    stated: Friction
    cause = Cause.FRICTION

    @property
    def arm(self) -> float:
        """Radius at which a pin rubs (m); 1 of a slider."""
        return 1.0 if self.stated.radius is None else self.stated.radius

    def share(self, state: JointState) -> Array:
        """Friction on the second body over the joint's force (m of a pin, 1 of a slider), ``(states,)``.

        Parameters
        ----------
        state
            How the bodies move.
        """
        return -self.arm * coefficient(self.stated, self.arm * state.rate - self.stated.belt_speed)

    def wrench(self, time: Array, state: JointState, touching: Touching) -> Wrench:
        """Give the viscous share, which needs no force of the joint.

        Parameters
        ----------
        time, state, touching
            As of `JointLaw`.
        """
        return self.joint.effort(state, -self.stated.viscous * state.rate)


def coefficient(stated: Friction, speed: Array) -> Array:
    """Coefficient of friction with its sign, ``(states,)``.

    Parameters
    ----------
    stated
        The law.
    speed
        Sliding speed (m/s), ``(states,)``.
    """
    size = np.full_like(speed, stated.coefficient)
    if stated.static is not None and stated.stribeck is not None:
        size += (stated.static - stated.coefficient) * np.exp(-((speed / stated.stribeck) ** 2))
    return size * np.tanh(speed / stated.width)
