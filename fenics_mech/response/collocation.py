"""Periodic response by collocation in time, of the whole equation of motion, linear or not.

In each step of the cycle the accelerations at the collocation points are the unknowns; velocities and displacements
are their integrals. Solving for them gives how the state at the end of a step depends on that at its start, and the
block-cyclic system closes the cycle. A nonlinear law is linearised about the last answer (Newton's method).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fenics_mech.errors import SolverError
from fenics_mech.mechanism.equation import Array, Equation, Matrices
from fenics_mech.response.cyclic import solve_cycle
from fenics_mech.response.tableau import Tableau

MOST_ITERATIONS = 30
SMALLEST_RISE = 1 / 64  # of the load, before it is given up
TOLERANCE = 1e-9  # of the change of the displacement, relative


@dataclass(frozen=True)
class Orbit:
    """A periodic motion at the collocation points, ``(points, coordinates)``, and at the starts of the steps.

    Parameters
    ----------
    displacement, velocity, acceleration
        q, q' and q'' at the points.
    start, start_velocity
        q and q' at the starts, ``(steps, coordinates)``.
    """

    displacement: Array
    velocity: Array
    acceleration: Array
    start: Array
    start_velocity: Array


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
    return _Newton(equation, tableau, step, options).solve(tension)


def _solve_linear(matrices: Matrices, tableau: Tableau, step: float, options: Mapping[str, Any]) -> Orbit:
    """Solve ``M q'' + C q' + K q = f``, given at the collocation points."""
    c, s, n = tableau.points, len(tableau.points), matrices.load.shape[1]
    mass, damping, stiffness = (m.reshape(-1, s, n, n) for m in (matrices.mass, matrices.damping, matrices.stiffness))
    load = matrices.load.reshape(-1, s, n)
    first, second = step * tableau.inner, step**2 * tableau.inner @ tableau.inner  # q' and q from q'' at the points
    lead = np.zeros((len(load), s, n, s, n))
    for i in range(s):
        for j in range(s):
            lead[:, i, :, j] = first[i, j] * damping[:, i] + second[i, j] * stiffness[:, i]
        lead[:, i, :, i] += mass[:, i]
    by_velocity = -(damping / step + c[:, None, None] * stiffness)  # the state is q and step times q'
    right = np.concatenate([-stiffness, by_velocity, load[..., None]], axis=-1).reshape(-1, s * n, 2 * n + 1)
    response = np.linalg.solve(lead.reshape(-1, s * n, s * n), right).reshape(-1, s, n, 2 * n + 1)
    ends = step**2 * np.stack([tableau.weights @ tableau.inner, tableau.weights])
    change = np.einsum("ri,kinm->krnm", ends, response).reshape(-1, 2 * n, 2 * n + 1)
    free = np.eye(2 * n)
    free[:n, n:] = np.eye(n)
    states = solve_cycle(change[..., :-1] + free, change[..., -1], options)
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


class _Newton:
    """Newton's method; where it fails, the load is brought up little by little."""

    def __init__(self, equation: Equation, tableau: Tableau, step: float, options: Mapping[str, Any]) -> None:
        self.equation, self.tableau, self.step, self.options = equation, tableau, step, options
        self.weight = np.sqrt(np.einsum("tii->ti", equation.linear.stiffness))  # makes energies of forces and moments

    def solve(self, tension: Array) -> Orbit:
        """Bring the load up from nothing, at once if that works.

        Parameters
        ----------
        tension
            Rough axial force of each element under the whole load (N), ``(points, elements)``.
        """
        zero = np.zeros_like(self.equation.linear.load)
        count = len(zero) // len(self.tableau.points)
        orbit = Orbit(zero, zero, zero, zero[:count], zero[:count])
        done, rise = 0.0, 1.0
        while done < 1:
            factor = min(done + rise, 1.0)
            try:
                start = factor * tension if done == 0 else tension
                orbit, tension, done = *self._at_load(factor, orbit, start), factor
            except SolverError:
                rise /= 2
                if rise < SMALLEST_RISE:
                    raise
        return orbit

    def _at_load(self, factor: float, orbit: Orbit, tension: Array) -> tuple[Orbit, Array]:
        """Iterate at a share of the load until nothing changes."""
        lowered = (factor - 1) * self.equation.linear.load
        changes: list[float] = []
        while not changes or changes[-1] > TOLERANCE:
            if len(changes) == MOST_ITERATIONS or (len(changes) > 4 and changes[-1] > 2 * min(changes[:-1])):
                raise self._failure(orbit, factor, lowered, len(changes))
            tangents = self.equation.linearised(orbit.displacement, orbit.velocity, tension)
            matrices = replace(tangents, load=tangents.load + lowered)
            found = _solve_linear(matrices, self.tableau, self.step, self.options)
            old, new = ((o.displacement, o.velocity) for o in (orbit, found))
            tension = self.equation.predicted_tension(*old, *new)
            change, size = self.weight * (found.displacement - orbit.displacement), self.weight * found.displacement
            changes.append(float(np.linalg.norm(change)) / max(float(np.linalg.norm(size)), 1e-300))
            orbit = found
        return orbit, tension

    def _failure(self, orbit: Orbit, factor: float, lowered: Array, iterations: int) -> SolverError:
        lack = self.equation.residual(orbit.displacement, orbit.velocity, orbit.acceleration) - lowered
        worst = int(np.linalg.norm(lack / self.weight, axis=1).argmax())
        theta = np.degrees(self.equation.system.motion.theta[worst])
        left = np.linalg.norm(lack / self.weight) / np.linalg.norm(self.equation.linear.load / self.weight)
        return SolverError(
            f"no periodic motion found: Newton's method stopped after {iterations} iterations at {factor:.3g} of the "
            f"load, with a relative residual of {left:.1e}, largest at drive angle {theta:.6g} deg. Give more damping, "
            "a lower speed, or more sub_intervals"
        )
