"""Inertia of the sections' rotation."""

from typing import Any

from fenics_mech._fenicsx import ufl


def rotary(space: Any, inertia: Any) -> Any:
    """Give ``int rho I phi psi dx``, phi and psi the rotations of the sections; `inertia` is rho I (kg m)."""
    # Source: Rayleigh, The Theory of Sound, section 162; with shear Timoshenko, Phil. Mag. 41 (1921) 744.
    phi, psi = (section_rotation(*functions(space)) for functions in (ufl.TrialFunctions, ufl.TestFunctions))
    return inertia * phi * psi * ufl.dx


def section_rotation(u: Any, w: Any, angle: Any = 0) -> Any:
    """Rotation of the sections: the slope of the axis less the angle of shear."""
    # u, w (m); angle (rad)
    return w.dx(0) - angle
