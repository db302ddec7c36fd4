"""Consistent mass."""

from typing import Any

import ufl


def mass(space: Any, line_density: Any) -> Any:
    """Give ``int rho A (u v + w z) dx``, the mass matrix (7.1); `line_density` is rho A (kg/m)."""
    u, w, *_ = ufl.TrialFunctions(space)
    v, z, *_ = ufl.TestFunctions(space)
    return line_density * (u * v + w * z) * ufl.dx
