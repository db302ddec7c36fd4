"""Answers of the elastic mechanism over a cycle."""

from fenics_mech.response.history import History
from fenics_mech.response.periodic import solve_periodic
from fenics_mech.response.quasi_static import solve_static

__all__ = ["History", "solve_periodic", "solve_static"]
