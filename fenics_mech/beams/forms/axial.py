"""Axial stiffness."""

from typing import Any

from fenics_mech._fenicsx import ufl


def axial(space: Any, stiffness: Any) -> Any:
    """Give ``int EA u' v' dx``, the axial part of (7.2); `stiffness` is EA (N)."""
    # stiffness (N)
    u, *_ = ufl.TrialFunctions(space)
    v, *_ = ufl.TestFunctions(space)
    return stiffness * u.dx(0) * v.dx(0) * ufl.dx
