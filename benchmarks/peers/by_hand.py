"""The seed four-bar with full coupling as one would program it by hand, on the matrices of `reference`.

The equation (4.66) is a first-order system ``z' = A(theta) z + b(theta)`` of z = (q, q'). Its coefficients are kept
constant in each sub-interval, as in chapter 5, which then has an exact answer by a matrix exponential; or SciPy
integrates it until it is periodic.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.linalg import expm

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError
from tests.validation.reference import NineElementModel, link_strain
from tests.validation.reference.nine_element import modes_of, turning_strain

TABLE_ANGLES = 1440  # angles at which SciPy's integrator knows the matrices; between them, cubic splines
MOST_CYCLES = 40


@dataclass(frozen=True)
class _FirstOrder:
    """``z' = A z + b`` at crank angles theta (rad), ``(angles,)``.

    `damped` times z is M^-1 times the forces of damping: strains are from q'' plus it.
    """

    theta: Array
    matrix: Array
    load: Array
    damped: Array


def _first_order(model: NineElementModel, theta: Array, damping: float) -> _FirstOrder:
    """Give the equation (4.66) at crank angles (rad), ``(angles,)``, with a damping ratio of all modes."""
    mass, stiffness = model.mass_stiffness(theta)
    omega, shapes = modes_of(mass, stiffness)
    momentum, coupling = mass @ shapes, model.coupling(theta)
    modal = (momentum * (2 * damping * omega)[:, None, :]) @ momentum.swapaxes(1, 2)  # (E.12)
    inverse = np.linalg.inv(mass)
    n = model.size
    damped = inverse @ modal @ np.concatenate([turning_strain(model, theta), np.broadcast_to(np.eye(n), mass.shape)], 2)
    matrix = np.zeros((len(theta), 2 * n, 2 * n))
    matrix[:, :n, n:] = np.eye(n)
    matrix[:, n:, :n] = -inverse @ (stiffness + coupling.stiffness)
    matrix[:, n:, n:] = -inverse @ coupling.damping
    matrix[:, n:] -= damped
    load = np.zeros((len(theta), 2 * n))
    load[:, n:] = np.einsum("tij,tj->ti", inverse, model.load(theta))
    return _FirstOrder(theta, matrix, load, damped)


def _strain_of(model: NineElementModel, equation: _FirstOrder, state: Array) -> Array:
    """Mid-span strains of the + fibres, ``(angles, links)``, of states (m, rad, and rates), ``(angles, 2 dofs)``."""
    n = model.size
    rate = np.einsum("tij,tj->ti", equation.matrix, state) + equation.load
    acceleration = rate[:, n:] + np.einsum("tij,tj->ti", equation.damped, state)
    return link_strain(model, equation.theta, state[:, :n], acceleration).total


def by_exponentials(intervals: int, elements: int, damping: float = 0.02) -> Array:
    """Mid-span strains in sub-intervals with constant coefficients, joined to a cycle.

    Each has the answer of an augmented matrix exponential; the cycle is closed as (5.15) does it.

    Parameters
    ----------
    intervals
        Number of sub-intervals in the cycle.
    elements
        Elements per link.
    damping
        Damping ratio of all modes.

    Returns
    -------
    numpy.ndarray
        Strains of the + fibres at the middles of the sub-intervals, ``(intervals, links)``.
    """
    model = NineElementModel(elements=elements)
    equation = _first_order(model, 2 * np.pi * np.arange(intervals) / intervals, damping)
    half = np.pi / model.parameters.omega1 / intervals
    size = 2 * model.size
    augmented = np.zeros((intervals, size + 1, size + 1))
    augmented[:, :size, :size], augmented[:, :size, size] = equation.matrix, equation.load
    halves = np.array([expm(half * each) for each in augmented])
    steps = halves @ halves
    cycle = np.eye(size + 1)
    for step in steps:
        cycle = step @ cycle
    start = np.linalg.solve(np.eye(size) - cycle[:size, :size], cycle[:size, size])
    state, middles = np.append(start, 1.0), np.empty((intervals, size))
    for k in range(intervals):
        middles[k] = (halves[k] @ state)[:size]
        state = steps[k] @ state
    return _strain_of(model, equation, middles)


def by_solve_ivp(tolerance: float, elements: int, angles: int = 240, damping: float = 0.02) -> Array:
    """Mid-span strains of the cycle at which SciPy's Radau integration, from rest, has become periodic.

    Periodic is what differs from the cycle before by less than the relative tolerance.

    Parameters
    ----------
    tolerance
        Relative tolerance of the integration.
    elements
        Elements per link.
    angles
        Number of equal steps of the cycle at which strains are given.
    damping
        Damping ratio of all modes.

    Returns
    -------
    numpy.ndarray
        Strains of the + fibres, ``(angles, links)``.

    Raises
    ------
    SolverError
        When SciPy gives up, or the motion does not become periodic.
    """
    model = NineElementModel(elements=elements)
    table = _first_order(model, 2 * np.pi * np.arange(TABLE_ANGLES + 1) / TABLE_ANGLES, damping)
    omega, n = model.parameters.omega1, model.size
    lower, load = (_spline(table.theta, part) for part in (table.matrix[:, n:], table.load[:, n:]))

    def jacobian(t: float, z: Array) -> Array:
        matrix = np.zeros((2 * n, 2 * n))
        matrix[:n, n:], matrix[n:] = np.eye(n), lower(omega * t)
        return matrix

    def rate(t: float, z: Array) -> Array:
        return np.concatenate([z[n:], lower(omega * t) @ z + load(omega * t)])

    equation = _first_order(model, 2 * np.pi * np.arange(angles) / angles, damping)
    times, state, before = equation.theta / omega, np.zeros(2 * n), None
    period = 2 * np.pi / omega
    for _ in range(MOST_CYCLES):
        scale = np.where(np.arange(2 * n) < n, 1e-3, 1e-3 * 300)  # m, rad; over the first mode's rate
        found = solve_ivp(
            rate, (0, period), state, "Radau", np.append(times, period), rtol=tolerance, atol=tolerance * scale,
            jac=jacobian,
        )  # fmt: skip
        if not found.success:
            raise SolverError(f"SciPy's integration failed: {found.message}")
        state = found.y[:, -1]
        strain = _strain_of(model, equation, found.y[:, :-1].T)
        if before is not None and np.abs(strain - before).max() < tolerance * np.abs(strain).max():
            return strain
        before = strain
    raise SolverError(f"the motion is not periodic after {MOST_CYCLES} cycles")


def _spline(theta: Array, values: Array) -> Callable[[float], Array]:
    """Interpolate values over a turn, the last of which is the first."""
    values = values.copy()
    values[-1] = values[0]
    return CubicSpline(theta, values, bc_type="periodic")
