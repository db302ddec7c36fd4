"""The whole linkage: P(theta), system matrices and load."""

from fenics_mech.mechanism.rigid import RigidModes
from fenics_mech.mechanism.system import System, build_system
from fenics_mech.mechanism.transformation import Transformation

__all__ = ["RigidModes", "System", "Transformation", "build_system"]
