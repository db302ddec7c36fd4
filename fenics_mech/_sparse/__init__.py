"""Sparse matrices of one pattern, one at each position: sums, products, factors."""

from fenics_mech._sparse.congruence import Congruence
from fenics_mech._sparse.kernels import kernels, pointer
from fenics_mech._sparse.pattern import Pattern
from fenics_mech._sparse.stack import DENSE, Factors, SingularError, Stack

__all__ = ["DENSE", "Congruence", "Factors", "Pattern", "SingularError", "Stack", "kernels", "pointer"]
