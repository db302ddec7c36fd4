"""Answers of the elastic mechanism over a cycle."""

from fenics_mech.forces.history import History
from fenics_mech.response.periodic.sub_intervals import solve_periodic
from fenics_mech.response.static.quasi_static import solve_static

__all__ = ["History", "solve_periodic", "solve_static"]
