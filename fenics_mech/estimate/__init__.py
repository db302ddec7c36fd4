"""How wrong an answer may be: by its steps, the mesh, the theory, and between positions and stations."""

from fenics_mech.estimate.cycles import finer_chart, finer_mesh, finer_steps, more_stages

__all__ = ["finer_chart", "finer_mesh", "finer_steps", "more_stages"]
