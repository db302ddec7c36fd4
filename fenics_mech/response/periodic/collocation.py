"""Periodic response by collocation in time, of the whole equation of motion, linear or not.

In each step of the cycle the accelerations at the collocation points are the unknowns; velocities and displacements
are their integrals. Solving for them gives how the state at the end of a step depends on that at its start. The
block-cyclic system closes the cycle. A nonlinear law is linearised about the last answer (Newton's method).
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.newton import Beginning, Orbit, improved, orbit_of, solve_nonlinear
from fenics_mech.response.periodic.tableau import Tableau

logger = logging.getLogger(__name__)


def solve_collocation(
    equation: Equation,
    tableau: Tableau,
    step: float | Array,
    options: Mapping[str, Any],
    tension: Array | None = None,
    jump: Array | None = None,
    beginnings: Iterable[Beginning] = (),
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
        A rough axial force of each element (N), ``(points, elements)``; None where the links have no nonlinear law.
    jump
        Change of q' by impulses at the starts of the steps, ``(steps, coordinates)``; the orbit's starts are after it.
    beginnings
        Motions beside the one that is sought, under a nonlinear law. Each is asked for if those before it fail.

    Raises
    ------
    SolverError
        When the cycle cannot be closed, or Newton's method does not converge, with the drive angle where it fails.
    """
    if tension is None:
        return periodic_orbit(Flow(equation.linear, tableau, step, options), jump)

    guess: Array | None = None

    def solve(matrices: Matrices) -> Orbit:
        nonlocal guess
        flow = Flow(matrices, tableau, step, options)
        orbit = periodic_orbit(flow, jump, guess)
        guess = flow.states(orbit.start[:1], orbit.start_velocity[:1])[0]
        return orbit

    for near in beginnings:
        if jump is None and tableau.points[-1] == 1:  # the last point is the start of the next cycle
            guess = np.append(near.displacement[-1], np.mean(step) * near.velocity[-1])
        try:
            return improved(equation, solve, near)
        except (SolverError, FloatingPointError) as error:
            logger.info("no motion beside the known one: %s", error)
            guess = None
    return solve_nonlinear(equation, solve, tension)


def periodic_orbit(flow: Flow, jump: Array | None = None, guess: Array | None = None) -> Orbit:
    """Solve ``M q'' + C q' + K q = f``, given at the collocation points of steps.

    Parameters
    ----------
    flow
        The steps of the equation.
    jump
        Change of q' by impulses at the starts of the steps, ``(steps, coordinates)``.
    guess
        State at the start of the cycle to begin from, ``(2n,)``.

    Raises
    ------
    SolverError
        When the cycle cannot be closed.
    """
    added = flow.added
    if jump is not None:
        added = added.copy()
        added[:, flow.size :] += flow.mean_step * np.roll(jump, -1, axis=0)  # of a step's end to the next one's start
    return replace(orbit_of(flow, flow.cycle.solve(added, guess), flow.matrices.load), flow=flow)


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
