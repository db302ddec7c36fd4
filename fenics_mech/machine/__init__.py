"""A machine of poses: coordinates, rows of joints, and the one residual with its sparse tangents."""

from fenics_mech.joints import Row
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.machine import Machine
from fenics_mech.machine.mobility import Mobility, hold_idle, loosen, mobility
from fenics_mech.machine.pattern import Pattern

__all__ = ["Evaluation", "Machine", "Mobility", "Pattern", "Row", "hold_idle", "loosen", "mobility"]
