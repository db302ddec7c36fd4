"""Stretching of a beam whose axis turns as it bends."""

from typing import Any

from fenics_mech._fenicsx import fem, ufl


def stretching(space: Any, tension: Any, xi: Any) -> tuple[Any, Any, Any]:
    """Give ``int N (u' + w'^2/2) dx`` of a state: its work with the tension N (N), constant in each element.

    With ``- N^2/(2 EA)`` it is the mixed energy of von Karman's strain (Hellinger and Reissner). Stationary in N, that
    energy says that N is EA times the strain's mean over the element, so that a bent element does not lock.

    Parameters
    ----------
    space
        Broken space of u and w.
    tension
        N as UFL coefficient (N).
    xi
        Place 0..1 in each element, as UFL coefficient.

    Returns
    -------
    tuple
        The first derivative at the straight state, a linear form ``int N v' dx``, and the second derivative, the
        bilinear form ``int N w' z' dx`` of the geometric stiffness. Last that form with a tension that changes from
        - N to N along the element, ``int N (2 xi - 1) w' z' dx``.
    """
    state = fem.Function(space)
    u, w, *_ = ufl.split(state)
    test, trial, strain = ufl.TestFunction(space), ufl.TrialFunction(space), u.dx(0) + w.dx(0) ** 2 / 2
    even, uneven = (ufl.derivative(part * strain * ufl.dx, state, test) for part in (tension, tension * (2 * xi - 1)))
    return even, ufl.derivative(even, state, trial), ufl.derivative(uneven, state, trial)
