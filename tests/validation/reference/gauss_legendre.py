"""Periodic solution by implicit Gauss-Legendre collocation: the reference that `periodic` is measured against.

Shares the matrices of the hand-coded model with it and nothing else: no sub-intervals of constant coefficients, no
joins, no modes left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .nine_element import Array, NineElementModel, modes_of, turning_strain

ROOT = np.sqrt(15.0)
NODES = np.array([0.5 - ROOT / 10, 0.5, 0.5 + ROOT / 10])
WEIGHTS = np.array([5 / 18, 4 / 9, 5 / 18])
STAGES = np.array(
    [
        [5 / 36, 2 / 9 - ROOT / 15, 5 / 36 - ROOT / 30],
        [5 / 36 + ROOT / 24, 2 / 9, 5 / 36 - ROOT / 24],
        [5 / 36 + ROOT / 30, 2 / 9 + ROOT / 15, 5 / 36],
    ]
)
"""Butcher tableau of the three-stage Gauss method, of order six."""

REFINEMENTS = 2
"""Corrections of the initial state by the gap that rounding leaves at the end of the cycle."""


@dataclass(frozen=True)
class CollocationResponse:
    """Periodic motion at N equally spaced crank angles.

    Parameters
    ----------
    theta
        Crank angles (rad), shape ``(N,)``.
    displacement, velocity
        q (m, rad) and q' (m/s, rad/s), shape ``(N, dofs)``.
    second_derivative
        q'' (m/s^2, rad/s^2), shape ``(N, dofs)``.
    acceleration
        q'' + M^-1 times the forces of damping, what strain recovery needs, shape ``(N, dofs)``.
    """

    theta: Array
    displacement: Array
    velocity: Array
    second_derivative: Array
    acceleration: Array


@dataclass(frozen=True)
class _Equation:
    """``M q'' + C q' + K q = f`` at a number of crank angles.

    The damping's share of C is `modal_damping`, and that of K is `modal_damping` times `turning`.
    """

    mass: Array
    damping: Array
    stiffness: Array
    load: Array
    modal_damping: Array
    turning: Array


def gauss_legendre_periodic(
    model: NineElementModel, steps: int, *, damping: float = 0.02, coupling: bool = False
) -> CollocationResponse:
    """Periodic solution of ``M q'' + C q' + K q = f`` with all modes, to sixth order in the step.

    C = M Phi diag(2 zeta omega) Phi^T M, the modal damping (E.12) as a matrix. It acts on the rate at which the links
    are strained, q' + K^-1 P^T k P' q.

    Parameters
    ----------
    model
        The linkage.
    steps
        Time steps N in the cycle.
    damping
        Damping ratio zeta of every mode.
    coupling
        Solve the full equation (4.66) instead of (5.1): 2 (Md + Mv) joins C, and Mdd + 2 Mdv + Ma joins K.

    Returns
    -------
    CollocationResponse
        Displacement, velocity and accelerations at theta_k = 2 pi k / N.
    """
    size, step = model.size, 2 * np.pi / model.parameters.omega1 / steps
    theta = 2 * np.pi * np.arange(steps) / steps
    transfer = np.empty((steps, 2 * size, 2 * size + 1))
    for chunk in np.array_split(np.arange(steps), max(1, steps // 64)):
        stages = theta[chunk, None] + 2 * np.pi / steps * NODES
        transfer[chunk] = _transfer(_equation(model, stages.ravel(), damping, coupling), step)
    state = _closed_cycle(transfer)
    displacement, velocity = state[:, :size], state[:, size:]
    here = _equation(model, theta, damping, coupling)
    internal = np.einsum("kij,kj->ki", here.damping, velocity) + np.einsum("kij,kj->ki", here.stiffness, displacement)
    second = np.linalg.solve(here.mass, (here.load - internal)[..., None])[..., 0]
    strained = velocity + np.einsum("kij,kj->ki", here.turning, displacement)
    damped = np.einsum("kij,kj->ki", here.modal_damping, strained)
    acceleration = second + np.linalg.solve(here.mass, damped[..., None])[..., 0]
    return CollocationResponse(theta, displacement, velocity, second, acceleration)


def _equation(model: NineElementModel, theta: Array, damping: float, coupling: bool) -> _Equation:
    """Matrices and load of the equation of motion at crank angles `theta` (rad)."""
    mass, stiffness = model.mass_stiffness(theta)
    omega, shapes = modes_of(mass, stiffness)
    momentum = mass @ shapes
    modal_damping = (momentum * (2 * damping * omega)[:, None, :]) @ momentum.swapaxes(1, 2)  # (E.12)
    turning = turning_strain(model, theta)
    rates, stiffness = modal_damping, stiffness + modal_damping @ turning
    if coupling:
        terms = model.coupling(theta)
        rates, stiffness = rates + terms.damping, stiffness + terms.stiffness  # (4.66)
    return _Equation(mass, rates, stiffness, model.load(theta), modal_damping, turning)


def _transfer(equation: _Equation, step: float) -> Array:
    """``[q, q'](t + h) = G [q, q'](t) + g`` of each step, as ``[G, g]``, shape ``(steps, 2 size, 2 size + 1)``.

    The unknowns are the accelerations a_i of the three stages: q_i = q + c_i h q' + h^2 sum (A A)_ij a_j and
    q'_i = q' + h sum A_ij a_j, with the equation of motion fulfilled at each of them.
    """
    mass, rates, stiffness, load = (
        part.reshape(-1, 3, *part.shape[1:])
        for part in (equation.mass, equation.damping, equation.stiffness, equation.load)
    )
    steps, size = load.shape[0], load.shape[2]
    twice = STAGES @ STAGES
    system = (
        np.einsum("ij,kiab->kiajb", np.eye(3), mass)
        + step * np.einsum("ij,kiab->kiajb", STAGES, rates)
        + step**2 * np.einsum("ij,kiab->kiajb", twice, stiffness)
    ).reshape(steps, 3 * size, 3 * size)
    known = np.empty((steps, 3, size, 2 * size + 1))
    known[..., :size] = -stiffness
    known[..., size:-1] = -rates - step * NODES[:, None, None] * stiffness
    known[..., -1] = load
    stages = np.linalg.solve(system, known.reshape(steps, 3 * size, -1)).reshape(known.shape)
    answer = np.zeros((steps, 2 * size, 2 * size + 1))
    answer[:, :size] = step**2 * np.einsum("j,kjab->kab", WEIGHTS @ STAGES, stages)
    answer[:, size:] = step * np.einsum("j,kjab->kab", WEIGHTS, stages)
    answer[:, : 2 * size, : 2 * size] += np.eye(2 * size)
    answer[:, :size, size : 2 * size] += step * np.eye(size)
    return answer


def _closed_cycle(transfer: Array) -> Array:
    """State at the beginning of each step of the periodic solution, shape ``(steps, 2 size)``.

    The map of the whole cycle is contracting for a damped linkage, so marching forward is stable; what rounding leaves
    of a gap at the end of the cycle is taken back into the initial state.
    """
    cycle = np.eye(transfer.shape[1])
    for matrix in transfer:
        cycle = matrix[:, :-1] @ cycle
    closing = np.eye(len(cycle)) - cycle
    state = np.zeros((len(transfer) + 1, len(cycle)))
    for _ in range(1 + REFINEMENTS):
        for k, matrix in enumerate(transfer):
            state[k + 1] = matrix[:, :-1] @ state[k] + matrix[:, -1]
        state[0] += np.linalg.solve(closing, state[-1] - state[0])
    for k, matrix in enumerate(transfer):
        state[k + 1] = matrix[:, :-1] @ state[k] + matrix[:, -1]
    return state[:-1]
