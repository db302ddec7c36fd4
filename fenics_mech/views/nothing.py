"""What is nothing but rounding in a result: of errors, powers and efforts, on a scale of the result's forces."""

from __future__ import annotations

import numpy as np

from fenics_mech._constants import ROUNDING
from fenics_mech.recovery import Result
from fenics_mech.recovery.result import kept
from fenics_mech.scene.joints import size_at

ROUNDED_POWER = 1e-13  # the same of powers, whose means are small parts of what passes: 3e-5 of one was 1e-9 of it
FORCES = "joint_force", "axial_force", "shear_force"


@kept
def largest_force(result: Result) -> float:
    """Give the largest force in joints and members (N): a balanced rotor has none in its joint."""
    data = result.data
    return max((float(np.abs(data[name]).max()) for name in FORCES if name in data and data[name].size), default=0.0)


def least_moment(result: Result) -> float:
    """Give the torque (N m), or the force along a slide (N), below which one is rounding: by that force and a link."""
    return ROUNDING * largest_force(result) * _size(result)


def least_power(result: Result) -> float:
    """Give the power (W) below which one is rounding: that of the largest force at the fastest link."""
    rates = result.data["link_omega"].to_numpy() if "link_omega" in result.data else np.zeros(1)
    return ROUNDED_POWER / ROUNDING * least_moment(result) * float(np.abs(rates).max(initial=0.0))


def _size(result: Result) -> float:
    """Size of the largest link at a joint (m)."""
    return max((size_at(result.scene, joint) for joint in result.scene.joints), default=0.0)
