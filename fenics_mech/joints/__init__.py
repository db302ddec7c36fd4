"""Joints: kinds, which hold measures of two ends; and laws of friction, contact and soft bearings, one a file."""

from fenics_mech.joints.kinds import IN_SPACE, KINDS, Kind, kind_of
from fenics_mech.joints.rows import Ride, Riding, Row

__all__ = ["IN_SPACE", "KINDS", "Kind", "Ride", "Riding", "Row", "kind_of"]
