"""Periodic response by collocation in time, of the whole equation of motion, linear or not.

In each step of the cycle the accelerations at the collocation points are the unknowns; velocities and displacements
are their integrals. Solving for them gives how the state at the end of a step depends on that at its start, and the
block-cyclic system closes the cycle. A nonlinear law is linearised about the last answer (Newton's method).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fenics_mech.mechanism.equation import Array, Equation, Matrices
from fenics_mech.response.cyclic import solve_cycle
from fenics_mech.response.newton import Orbit, solve_nonlinear
from fenics_mech.response.tableau import Tableau


def solve_collocation(
    equation: Equation,
    tableau: Tableau,
    step: float,
    options: Mapping[str, Any],
    tension: Array | None = None,
) -> Orbit:
    """Solve for the periodic motion.

    Parameters
    ----------
    equation
        The equation of motion at the collocation points of all steps of a cycle.
    tableau
        The points.
    step
        Duration of a step (s).
    options
        PETSc options with the prefix "periodic_".
    tension
        A rough axial force of each element (N), ``(points, elements)``, where the equation is not linear.

    Raises
    ------
    SolverError
        When the cycle cannot be closed, or Newton's method does not converge, with the drive angle where it fails.
    """
    if equation.system.terms.law is None or tension is None:
        return _solve_linear(equation.linear, tableau, step, options)
    return solve_nonlinear(equation, lambda matrices: _solve_linear(matrices, tableau, step, options), tension)


def _solve_linear(matrices: Matrices, tableau: Tableau, step: float, options: Mapping[str, Any]) -> Orbit:
    """Solve ``M q'' + C q' + K q = f``, given at the collocation points."""
    c, n = tableau.points, matrices.load.shape[1]
    first, second = step * tableau.inner, step**2 * tableau.inner @ tableau.inner  # q' and q from q'' at the points
    response, transitions = linear_steps(matrices, tableau, step)
    states = solve_cycle(transitions[..., :-1], transitions[..., -1], options)
    q, rate = states[:, :n], states[:, n:] / step
    acceleration = np.einsum("kinm,km->kin", response[..., :-1], states) + response[..., -1]
    velocity = rate[:, None] + np.einsum("ij,kjn->kin", first, acceleration)
    displacement = q[:, None] + step * c[:, None] * rate[:, None] + np.einsum("ij,kjn->kin", second, acceleration)
    return Orbit(
        displacement=displacement.reshape(-1, n),
        velocity=velocity.reshape(-1, n),
        acceleration=acceleration.reshape(-1, n),
        start=q,
        start_velocity=rate,
    )


def linear_steps(matrices: Matrices, tableau: Tableau, step: float) -> tuple[Array, Array]:
    """Solve for the accelerations inside every step, and how its end follows from its start.

    The state at a start is ``(q, step q')``.

    Returns
    -------
    tuple
        q'' at the points, ``(steps, s, n, 2n + 1)``, and the state at the end, ``(steps, 2n, 2n + 1)``: the columns are
        for a state at the start, the last one for the load.
    """
    c, s, n = tableau.points, len(tableau.points), matrices.load.shape[1]
    mass, damping, stiffness = (m.reshape(-1, s, n, n) for m in (matrices.mass, matrices.damping, matrices.stiffness))
    load = matrices.load.reshape(-1, s, n)
    first, second = step * tableau.inner, step**2 * tableau.inner @ tableau.inner
    lead = np.zeros((len(load), s, n, s, n))
    for i in range(s):
        for j in range(s):
            lead[:, i, :, j] = first[i, j] * damping[:, i] + second[i, j] * stiffness[:, i]
        lead[:, i, :, i] += mass[:, i]
    by_velocity = -(damping / step + c[:, None, None] * stiffness)
    right = np.concatenate([-stiffness, by_velocity, load[..., None]], axis=-1).reshape(-1, s * n, 2 * n + 1)
    response = np.linalg.solve(lead.reshape(-1, s * n, s * n), right).reshape(-1, s, n, 2 * n + 1)
    ends = step**2 * np.stack([tableau.weights @ tableau.inner, tableau.weights])
    transitions = np.einsum("ri,kinm->krnm", ends, response).reshape(-1, 2 * n, 2 * n + 1)
    transitions[..., : 2 * n] += np.eye(2 * n)
    transitions[:, :n, n : 2 * n] += np.eye(n)
    return response, transitions
