"""Rigid-body motion of any planar linkage, and its singular positions."""

from fenics_mech.kinematics.corners import missed_corner, positions_for_corners, refuse_unresolved
from fenics_mech.kinematics.linkage import Linkage, solve_motion, start_motion
from fenics_mech.kinematics.motion import Motion
from fenics_mech.kinematics.singular import Critical, Range, reachable_range
from fenics_mech.kinematics.start import assembly_notices

__all__ = [
    "Critical",
    "Linkage",
    "Motion",
    "Range",
    "assembly_notices",
    "missed_corner",
    "positions_for_corners",
    "reachable_range",
    "refuse_unresolved",
    "solve_motion",
    "start_motion",
]
