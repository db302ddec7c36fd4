"""Stretching of a beam whose axis turns as it bends."""

from typing import Any

from fenics_mech._fenicsx import fem, ufl


def stretching(space: Any, tension: Any, xi: Any) -> tuple[Any, Any, Any]:
    """Give ``int N (u' + w'^2/2) dx`` of a state: its work with the tension N (N), constant in each element."""
    # tension (N)
    # With - N^2/(2 EA) it is the mixed energy of von Karman's strain (Hellinger and Reissner). Stationary in N, that
    # energy says that N is EA times the strain's mean over the element, so that a bent element does not lock.
    state = fem.Function(space)
    u, w, *_ = ufl.split(state)
    test, trial, strain = ufl.TestFunction(space), ufl.TrialFunction(space), u.dx(0) + w.dx(0) ** 2 / 2
    even, uneven = (ufl.derivative(part * strain * ufl.dx, state, test) for part in (tension, tension * (2 * xi - 1)))
    return even, ufl.derivative(even, state, trial), ufl.derivative(uneven, state, trial)
