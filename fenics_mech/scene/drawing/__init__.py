"""A mechanism drawn in gmsh, or written as lines and named sets for Abaqus, as part of a scene."""

from fenics_mech.scene.drawing.data import completed

__all__ = ["completed"]
