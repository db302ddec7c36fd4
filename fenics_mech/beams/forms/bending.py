"""Bending stiffness."""

from typing import Any

from fenics_mech._fenicsx import ufl


def bending(space: Any, stiffness: Any) -> Any:
    """Give ``int EI w'' z'' dx``, the bending part of (7.2); `stiffness` is EI (N m^2)."""
    _, w, *_ = ufl.TrialFunctions(space)
    _, z, *_ = ufl.TestFunctions(space)
    return stiffness * w.dx(0).dx(0) * z.dx(0).dx(0) * ufl.dx
