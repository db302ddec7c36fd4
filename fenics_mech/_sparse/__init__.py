"""Sparse matrices of one pattern, one at each position: sums, products, factors."""

from fenics_mech._sparse.congruence import Congruence, ProductPairs
from fenics_mech._sparse.few_modes import FewModes
from fenics_mech._sparse.kernels import LANES, kernels, pointer
from fenics_mech._sparse.pattern import Pattern
from fenics_mech._sparse.stack import DENSE, Factors, SingularError, Stack

__all__ = [
    "DENSE",
    "LANES",
    "Congruence",
    "Factors",
    "FewModes",
    "Pattern",
    "ProductPairs",
    "SingularError",
    "Stack",
    "kernels",
    "pointer",
]
