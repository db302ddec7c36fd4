"""Sparse matrices of one pattern, one at each position: sums, products, factors."""

from fenics_mech._sparse.kernels import LANES, kernels, pointer
from fenics_mech._sparse.pattern import Pattern
from fenics_mech._sparse.stack import DENSE, Factors, SingularError, Stack

__all__ = [
    "DENSE",
    "LANES",
    "Factors",
    "Pattern",
    "SingularError",
    "Stack",
    "kernels",
    "pointer",
]
