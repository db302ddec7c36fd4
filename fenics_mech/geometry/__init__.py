"""Poses: places and rotations, their charts, and what is fixed to them; the plane and space behind one interface."""

from fenics_mech.geometry.charts import Chart, Fourier, Given, Rest, harmonics
from fenics_mech.geometry.poses import End, PoseMotion
from fenics_mech.geometry.spaces import PLANE, SPACE, Geometry

__all__ = ["PLANE", "SPACE", "Chart", "End", "Fourier", "Geometry", "Given", "PoseMotion", "Rest", "harmonics"]
