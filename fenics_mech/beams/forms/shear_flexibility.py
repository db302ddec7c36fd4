"""Shear of a beam whose sections do not stay normal to its axis (Timoshenko)."""

from typing import Any

from fenics_mech._fenicsx import ufl


def shear(space: Any, stiffness: Any) -> Any:
    """Give ``int G A_s gamma gamma~ dx``; `stiffness` is G A_s (N), gamma the shear angle, constant in an element."""
    # stiffness (N)
    # The rotation of the sections is phi = w' - gamma, and phi' = w'', so that the stiffness of bending stays as it
    # is. Source: Timoshenko, Phil. Mag. 41 (1921) 744.
    *_, angle = ufl.TrialFunctions(space)
    *_, virtual = ufl.TestFunctions(space)
    return stiffness * angle * virtual * ufl.dx
