"""Solvers of one residual: statics, motion in time, periodic motion, frequencies, stability. None knows what moves."""

from fenics_mech.solve.compiled_steps import accelerated
from fenics_mech.solve.frequencies import frequencies, tangents_at
from fenics_mech.solve.held_modes import damp_modes, followed_modes, held_modes
from fenics_mech.solve.in_time import Course, States, Step, march, steps_in_time
from fenics_mech.solve.linear import Iterate, StaticIteration, axial_forces, iterates, quasi_static
from fenics_mech.solve.periodic import Cycle, Iteration, Path, converged, periodic
from fenics_mech.solve.rigid import rigid_cycle
from fenics_mech.solve.running_frequencies import about_motion
from fenics_mech.solve.stability import running_modes
from fenics_mech.solve.statics import equilibria, equilibrium

__all__ = [
    "Course",
    "Cycle",
    "Iterate",
    "Iteration",
    "Path",
    "States",
    "StaticIteration",
    "Step",
    "about_motion",
    "accelerated",
    "axial_forces",
    "converged",
    "damp_modes",
    "equilibria",
    "equilibrium",
    "followed_modes",
    "frequencies",
    "held_modes",
    "iterates",
    "march",
    "periodic",
    "quasi_static",
    "rigid_cycle",
    "running_modes",
    "steps_in_time",
    "tangents_at",
]
