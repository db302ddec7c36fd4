"""Rigid-body motion of any planar linkage of links and revolute joints."""

from fenics_mech.kinematics.motion import Motion, solve_motion

__all__ = ["Motion", "solve_motion"]
