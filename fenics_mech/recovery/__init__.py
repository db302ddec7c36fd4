"""From displacement histories to what an engineer reads: strain, stress, section forces, joint forces."""

from fenics_mech.recovery.joints import input_torque, joint_forces
from fenics_mech.recovery.members import MemberState, recover_members
from fenics_mech.recovery.result import Result

__all__ = ["MemberState", "Result", "input_torque", "joint_forces", "recover_members"]
