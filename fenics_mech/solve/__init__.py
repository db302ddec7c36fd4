"""Solvers of one residual: statics, motion in time, periodic motion, frequencies, stability. None knows what moves."""

from fenics_mech.solve.frequencies import frequencies, tangents_at
from fenics_mech.solve.in_time import Course, march
from fenics_mech.solve.periodic import Cycle, Path, periodic
from fenics_mech.solve.rigid import rigid_cycle
from fenics_mech.solve.statics import equilibrium

__all__ = ["Course", "Cycle", "Path", "equilibrium", "frequencies", "march", "periodic", "rigid_cycle", "tangents_at"]
