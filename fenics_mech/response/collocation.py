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
    step: float | Array,
    options: Mapping[str, Any],
    tension: Array | None = None,
    jump: Array | None = None,
) -> Orbit:
    """Solve for the periodic motion.

    Parameters
    ----------
    equation
        The equation of motion at the collocation points of all steps of a cycle.
    tableau
        The points.
    step
        Duration of all steps, or of each of them (s).
    options
        PETSc options with the prefix "periodic_".
    tension
        A rough axial force of each element (N), ``(points, elements)``, where the equation is not linear.
    jump
        Change of q' by impulses at the starts of the steps, ``(steps, coordinates)``; the orbit's starts are after it.

    Raises
    ------
    SolverError
        When the cycle cannot be closed, or Newton's method does not converge, with the drive angle where it fails.
    """
    if equation.system.terms.law is None or tension is None:
        return _solve_linear(equation.linear, tableau, step, options, jump)

    def solve(matrices: Matrices) -> Orbit:
        return _solve_linear(matrices, tableau, step, options, jump)

    return solve_nonlinear(equation, solve, tension)


def _solve_linear(
    matrices: Matrices, tableau: Tableau, step: float | Array, options: Mapping[str, Any], jump: Array | None
) -> Orbit:
    """Solve ``M q'' + C q' + K q = f``, given at the collocation points."""
    n = matrices.load.shape[1]
    response, transitions = linear_steps(matrices, tableau, step)
    added = transitions[..., -1]
    if jump is not None:
        added[:, n:] += np.mean(step) * np.roll(jump, -1, axis=0)  # of a step's end to the next one's start
    states = solve_cycle(transitions[..., :-1], added, options)
    q, rate = states[:, :n], states[:, n:] / np.mean(step)
    h = np.broadcast_to(step, len(q))[:, None, None]
    acceleration = np.einsum("kinm,km->kin", response[..., :-1], states) + response[..., -1]
    velocity = rate[:, None] + h * (tableau.inner @ acceleration)
    displacement = q[:, None] + h * tableau.points[:, None] * rate[:, None]
    displacement += h**2 * (tableau.inner @ tableau.inner @ acceleration)
    return Orbit(
        displacement=displacement.reshape(-1, n),
        velocity=velocity.reshape(-1, n),
        acceleration=acceleration.reshape(-1, n),
        start=q,
        start_velocity=rate,
    )


def linear_steps(matrices: Matrices, tableau: Tableau, step: float | Array) -> tuple[Array, Array]:
    """Solve for the accelerations inside every step, and how its end follows from its start.

    The state at a start is ``(q, step q')``, with the mean of the steps where they differ.

    Returns
    -------
    tuple
        q'' at the points, ``(steps, s, n, 2n + 1)``, and the state at the end, ``(steps, 2n, 2n + 1)``: the columns are
        for a state at the start, the last one for the load.
    """
    s, n = len(tableau.points), matrices.load.shape[1]
    mass, damping, stiffness = (m.reshape(-1, s, n, n) for m in (matrices.mass, matrices.damping, matrices.stiffness))
    load = matrices.load.reshape(-1, s, n)
    pace = np.mean(step)
    h = np.broadcast_to(step, len(load))[:, None, None]
    first, second = (part[..., None, None] for part in (h * tableau.inner, h**2 * (tableau.inner @ tableau.inner)))
    lead = np.zeros((len(load), s, n, s, n))
    for i in range(s):
        for j in range(s):
            lead[:, i, :, j] = first[:, i, j] * damping[:, i] + second[:, i, j] * stiffness[:, i]
        lead[:, i, :, i] += mass[:, i]
    by_velocity = -(damping + (h * tableau.points[:, None])[..., None] * stiffness) / pace
    right = np.concatenate([-stiffness, by_velocity, load[..., None]], axis=-1).reshape(-1, s * n, 2 * n + 1)
    response = np.linalg.solve(lead.reshape(-1, s * n, s * n), right).reshape(-1, s, n, 2 * n + 1)
    to_ends = h * (tableau.weights @ tableau.inner), np.full_like(h, pace) * tableau.weights
    ends = h * np.concatenate(to_ends, axis=1)
    transitions = np.einsum("kri,kinm->krnm", ends, response).reshape(-1, 2 * n, 2 * n + 1)
    transitions[..., : 2 * n] += np.eye(2 * n)
    transitions[:, :n, n : 2 * n] += h / pace * np.eye(n)
    return response, transitions


def between(orbit: Orbit, tableau: Tableau, step: float | Array, places: Array) -> tuple[Array, Array]:
    """Give q and q' at places 0..1 in every step, on the collocation polynomials, ``(steps x places, coordinates)``.

    Parameters
    ----------
    orbit, tableau, step
        A motion by collocation, its points, and the duration of its steps (s).
    places
        Where in a step.
    """
    s, n = len(tableau.points), orbit.start.shape[1]
    h = np.broadcast_to(step, len(orbit.start))[:, None, None] * tableau.integrals(places)
    q = orbit.start[:, None] + h @ orbit.velocity.reshape(-1, s, n)
    rate = orbit.start_velocity[:, None] + h @ orbit.acceleration.reshape(-1, s, n)
    return q.reshape(-1, n), rate.reshape(-1, n)
