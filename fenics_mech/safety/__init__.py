"""Is the machine safe? Factors of safety of its members by every way in which they may fail, and what would help."""

from fenics_mech.safety.check import KEYS, Check
from fenics_mech.safety.side_buckling import buckled_sideways
from fenics_mech.safety.verdict import Cure, Verdict, judge

__all__ = ["KEYS", "Check", "Cure", "Verdict", "buckled_sideways", "judge"]
