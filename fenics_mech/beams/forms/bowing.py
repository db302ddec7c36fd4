"""Shortening of a beam by the slope of its axis."""

from typing import Any

from fenics_mech._fenicsx import ufl


def bowing(space: Any, tension: Any) -> Any:
    """Give ``int N w' z' dx``: for a tension of 1 N twice the shortening by w'^2/2, in general geometric stiffness."""
    # tension (N)
    _, w, *_ = ufl.TrialFunctions(space)
    _, z, *_ = ufl.TestFunctions(space)
    return tension * w.dx(0) * z.dx(0) * ufl.dx
