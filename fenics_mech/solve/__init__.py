"""Solvers of one residual: statics, motions, frequencies, stability, derivatives. None knows what moves."""

from fenics_mech.solve.compiled_steps import accelerated
from fenics_mech.solve.continuation import Driven, Family, Point, continued
from fenics_mech.solve.derivatives import Beside, cycle_change, rest_change, running_change
from fenics_mech.solve.frequencies import frequencies, tangents_at
from fenics_mech.solve.held_modes import About, FollowedModes, damp_modes, followed_modes, held_damping, held_modes
from fenics_mech.solve.in_time import Course, march, steps_in_time
from fenics_mech.solve.linear import Iterate, StaticIteration, axial_forces, quasi_static, stiffening_stresses
from fenics_mech.solve.path import Path
from fenics_mech.solve.periodic import Cycle, Iteration, periodic
from fenics_mech.solve.rigid import rigid_cycle
from fenics_mech.solve.running_frequencies import BESIDE, about_motion, forces_about
from fenics_mech.solve.stability import RunningModes, running_modes
from fenics_mech.solve.statics import equilibria, equilibrium
from fenics_mech.solve.step import States, Step

__all__ = [
    "BESIDE",
    "About",
    "Beside",
    "Course",
    "Cycle",
    "Driven",
    "Family",
    "FollowedModes",
    "Iterate",
    "Iteration",
    "Path",
    "Point",
    "RunningModes",
    "States",
    "StaticIteration",
    "Step",
    "about_motion",
    "accelerated",
    "axial_forces",
    "continued",
    "cycle_change",
    "damp_modes",
    "equilibria",
    "equilibrium",
    "followed_modes",
    "forces_about",
    "frequencies",
    "held_damping",
    "held_modes",
    "march",
    "periodic",
    "quasi_static",
    "rest_change",
    "rigid_cycle",
    "running_change",
    "running_modes",
    "steps_in_time",
    "stiffening_stresses",
    "tangents_at",
]
