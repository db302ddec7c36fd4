"""From a solution to what an engineer reads: strains, stresses, section forces and joint forces, in one dataset."""

from fenics_mech.recovery.result import Result

__all__ = ["Result"]
