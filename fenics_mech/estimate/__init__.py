"""How wrong a periodic motion may be: by its steps, by the mesh of its members, between its instants."""

from fenics_mech.estimate.cycles import finer_chart, finer_mesh, finer_steps, more_stages

__all__ = ["finer_chart", "finer_mesh", "finer_steps", "more_stages"]
