"""Links as beams: gmsh mesh, broken space, UFL forms, matrices in link axes."""

from fenics_mech.beams.element_matrices import Beams, assemble_beams
from fenics_mech.beams.mesh import BeamMesh, mesh_scene

__all__ = ["BeamMesh", "Beams", "assemble_beams", "mesh_scene"]
