"""Strains of an axis that turns far: its arc length, and the curvature along that."""

from typing import Any

from fenics_mech._fenicsx import ufl

QUADRATURE_DEGREE = 7  # of the quadrature, four points: the integrands are no polynomials


def shortening(w: Any) -> Any:
    """Give ``int 1 - sqrt(1 - w'^2) dx``, by which an axis of that length is longer than its chord."""
    # w (m)
    # The slope w' is the sine of the rotation, as it is the derivative along the axis itself.
    return (1 - ufl.sqrt(1 - w.dx(0) ** 2)) * ufl.dx(degree=QUADRATURE_DEGREE)


def curvature(w: Any) -> Any:
    """Give the curvature ``w''/sqrt(1 - w'^2)``: the derivative of the rotation, the arc sine of w'."""
    # w (m)
    return w.dx(0).dx(0) / ufl.sqrt(1 - w.dx(0) ** 2)


def bending_energy(w: Any, stiffness: Any) -> Any:
    """Give the strain energy of bending."""
    # w (m)
    return stiffness * curvature(w) ** 2 / 2 * ufl.dx(degree=QUADRATURE_DEGREE)


def bending(w: Any, rate: Any, stiffness: Any, test: Any) -> Any:
    """Give the work of the bending moment."""
    bent = curvature(w)
    moment = bent + ufl.derivative(bent, w, rate)
    return stiffness * moment * ufl.derivative(bent, w, test) * ufl.dx(degree=QUADRATURE_DEGREE)
