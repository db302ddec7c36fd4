"""Natural frequencies and modes at every position, tracked over the cycle."""

from fenics_mech.eigenmodes.eigen import modes_kept, natural, solve_modes
from fenics_mech.eigenmodes.tracking import Modes

__all__ = ["Modes", "modes_kept", "natural", "solve_modes"]
