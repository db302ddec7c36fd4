"""From displacement histories to what an engineer reads: strain, stress, section forces, joint forces."""

from fenics_mech.forces.joint_forces import joint_forces, reactions
from fenics_mech.forces.section_forces import MemberState, recover_members
from fenics_mech.recovery.result import Result

__all__ = ["MemberState", "Result", "joint_forces", "reactions", "recover_members"]
