"""The motion of links that do not bend."""

from fenics_mech.kinematics.motion import Motion, coordinates

__all__ = ["Motion", "coordinates"]
