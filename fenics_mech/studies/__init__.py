"""Studies: the program against its references, refinement, cost."""

from fenics_mech.studies.check import CHECKS, Finding
from fenics_mech.studies.rigid_body import rigid_body_strains

__all__ = ["CHECKS", "Finding", "rigid_body_strains"]
