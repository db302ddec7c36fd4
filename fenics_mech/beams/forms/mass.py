"""Consistent mass."""

from typing import Any

from fenics_mech._fenicsx import ufl
from fenics_mech.beams.forms.rotary import section_rotation


def mass(space: Any, line_density: Any) -> Any:
    """Give ``int rho A (u v + w z) dx``, the mass matrix (7.1); `line_density` is rho A (kg/m)."""
    # line_density (kg/m)
    u, w, *_ = ufl.TrialFunctions(space)
    v, z, *_ = ufl.TestFunctions(space)
    return line_density * (u * v + w * z) * ufl.dx


def offset_mass(space: Any, moment: Any) -> Any:
    """Give ``-int rho A e (u psi + phi v) dx``, what mass beside the neutral line adds but for its ``(rho A e^2)``."""
    # moment (kg)
    # The centre of mass, e beside the neutral line along the normal, has the displacement u - e phi along the member.
    # phi and psi are the rotations of the sections; `moment` is rho A e (kg). The share rho A e^2 is a moment of
    # inertia of the sections' rotation, see `rotary`.
    (u, *others), (v, *virtual) = ufl.TrialFunctions(space), ufl.TestFunctions(space)
    return -moment * (u * section_rotation(v, *virtual) + section_rotation(u, *others) * v) * ufl.dx
