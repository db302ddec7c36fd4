"""Natural frequencies and modes at every position, tracked over the cycle."""

from fenics_mech.eigenmodes.eigen import modes_kept, natural, solve_modes
from fenics_mech.eigenmodes.simply_supported import simply_supported_frequencies
from fenics_mech.eigenmodes.tracking import Modes

__all__ = ["Modes", "modes_kept", "natural", "simply_supported_frequencies", "solve_modes"]
