"""Coupling of the two displacements by the rotation of their axes."""

from typing import Any

from fenics_mech._fenicsx import ufl
from fenics_mech.beams.forms.rotary import section_rotation


def gyroscopic(space: Any, line_density: Any) -> Any:
    """Give ``s = int rho A (u z - w v) dx``; `line_density` is rho A (kg/m)."""
    # line_density (kg/m)
    # With it the matrices of (4.29) and (4.30) of a link that turns at omega are m_v = omega s and m_a = alpha s -
    # omega^2 m, as T^T T' = omega [0, -1; 1, 0].
    u, w, *_ = ufl.TrialFunctions(space)
    v, z, *_ = ufl.TestFunctions(space)
    return line_density * (u * z - w * v) * ufl.dx


def offset_gyroscopic(space: Any, moment: Any) -> Any:
    """Give ``int rho A e (w psi - phi z) dx``: the form of `gyroscopic` with ``u - e phi`` less that with u."""
    # moment (kg)
    # `moment` is rho A e (kg), e the place of the centre of mass beside the neutral line; see `offset_mass`.
    (u, w, *others), (v, z, *virtual) = ufl.TrialFunctions(space), ufl.TestFunctions(space)
    return moment * (w * section_rotation(v, z, *virtual) - section_rotation(u, w, *others) * z) * ufl.dx
