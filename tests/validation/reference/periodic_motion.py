"""Steady-state response of the truncated equation (5.1) by sub-intervals, Kaminski (1989), chapter 5, generalised.

The cycle of period T is cut into N sub-intervals, the k-th centred at theta_k = 2 pi k / N. In each of them M, K, the
modes and their frequencies are those of its middle; the modal equations (E.13) are solved exactly and joined to those
of the next sub-interval, the last to those of the first. Numbers in parentheses are the dissertation's equations.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from .nine_element import Array, NineElementModel, as_angles, modes_of, turning_strain

Join = Literal["physical", "projected", "modal"]
Load = Literal["constant", "linear"]

CLOSURE_TOLERANCE = 1e-9
"""Largest gap between the end of the cycle and its beginning, relative to the largest modal state."""


@dataclass(frozen=True)
class PeriodicResponse:
    """Elastic motion of the linkage over one cycle.

    Parameters
    ----------
    theta
        Crank angles (rad), shape ``(angles,)``.
    displacement
        q (m, rad), shape ``(angles, dofs)``.
    acceleration
        q'' plus the damping's share (m/s^2, rad/s^2), what strain recovery needs, shape ``(angles, dofs)``.
    omega
        Angular frequencies of the modes kept (rad/s), ascending, shape ``(angles, modes)``.
    """

    theta: Array
    displacement: Array
    acceleration: Array
    omega: Array


@dataclass(frozen=True)
class _Intervals:
    """The constants of every sub-interval (first axis), `static`, q of the modes left out, and `turning`.

    `turning` is Phi^T M K^-1 P^T k P' Phi: rates at which the turning of the links strains the modes.
    """

    theta: Array
    step: float
    mass: Array
    shapes: Array
    omega: Array
    load_start: Array
    load_middle: Array
    load_end: Array
    static: Array
    turning: Array


@dataclass(frozen=True)
class _Oscillators:
    """``z(t) = A z(0) + b`` of each modal oscillator, z = (y, y'); shapes ``(N, modes, 2, 2)``, ``(N, modes, 2)``."""

    matrix: Array
    forced: Array


def quasi_static_response(model: NineElementModel, theta: ArrayLike) -> PeriodicResponse:
    """Deflection q = K^-1 f at crank angles `theta` (rad), as if the links had no elastic inertia."""
    angles = as_angles(theta)
    _, stiffness = model.mass_stiffness(angles)
    displacement: Array = np.linalg.solve(stiffness, model.load(angles)[..., None])[..., 0].astype(np.float64)
    return PeriodicResponse(angles, displacement, np.zeros_like(displacement), np.empty((angles.size, 0)))


def periodic_response(
    model: NineElementModel,
    intervals: int,
    *,
    modes: int | None = None,
    damping: float = 0.02,
    load: Load = "linear",
    join: Join = "physical",
    static_correction: bool = True,
) -> PeriodicResponse:
    """Periodic solution of ``M q'' + C q' + K q = f``, (5.1) with modal damping, by sub-intervals.

    Parameters
    ----------
    model
        The linkage.
    intervals
        Number N of sub-intervals in the cycle.
    modes
        Modes kept, lowest first; all of them when left out.
    damping
        Damping ratio of every mode (E.12), 0 <= damping < 1.
    load
        Modal load inside a sub-interval: "constant", that of the middle, or "linear" through it, with the slope between
        the two ends.
    join
        "projected": displacement and velocity go on in physical coordinates, as far as the modes kept can follow.
        "physical": the same, and these modes take up the momentum of the displacement that they cannot follow; with all
        modes there is none.
        "modal": each modal coordinate goes on by itself, as printed in (5.14)-(5.16).
    static_correction
        Add the quasi-static response of the modes left out to the answer.

    Returns
    -------
    PeriodicResponse
        The motion at the middle of each sub-interval, theta_k = 2 pi k / N.

    Raises
    ------
    ValueError
        If an option is outside its range.
    ArithmeticError
        If the periodic solution does not close.
    """
    modes = model.size if modes is None else modes
    _check(model.size, intervals, modes, damping, load, join)
    data = _intervals(model, intervals, modes, load)
    whole = _oscillators(data, damping, data.step)
    start = _closed_cycle(*_joins(data, join, damping), whole)
    half = _oscillators(data, damping, data.step / 2)
    middle = np.einsum("kmij,kmj->kmi", half.matrix, start) + half.forced
    displacement = np.einsum("kim,km->ki", data.shapes, middle[..., 0])  # (E.14)
    if static_correction:
        displacement += data.static
    acceleration = np.einsum("kim,km->ki", data.shapes, data.load_middle - data.omega**2 * middle[..., 0])
    return PeriodicResponse(data.theta, displacement, acceleration, data.omega)


def _check(size: int, intervals: int, modes: int, damping: float, load: str, join: str) -> None:
    """Raise on an option of `periodic_response` that is outside its range."""
    if intervals < 1:
        raise ValueError(f"the cycle needs at least one sub-interval, got {intervals}")
    if not 1 <= modes <= size:
        raise ValueError(f"modes must be 1 to {size}, got {modes}")
    if not 0 <= damping < 1:
        raise ValueError(f"the damping ratio must be in [0, 1), got {damping}")
    if load not in get_args(Load) or join not in get_args(Join):
        raise ValueError(f"unknown load {load!r} or join {join!r}")


def _intervals(model: NineElementModel, count: int, modes: int, load: Load) -> _Intervals:
    """Everything that is constant in each sub-interval."""
    theta = 2 * np.pi * np.arange(count) / count
    mass, stiffness = model.mass_stiffness(theta)
    omega, shapes = modes_of(mass, stiffness, modes)
    middle = model.load(theta)
    rise = np.zeros_like(middle)
    if load == "linear":
        end = model.load(theta + np.pi / count)
        rise = end - np.roll(end, 1, axis=0)
    modal = shapes.swapaxes(1, 2) @ np.stack([middle, middle - rise / 2, middle + rise / 2], axis=2)  # (5.2)
    kept = np.einsum("kim,km->ki", shapes, modal[..., 0] / omega**2)
    static = np.linalg.solve(stiffness, middle[..., None])[..., 0] - kept
    step = 2 * np.pi / model.parameters.omega1 / count  # (5.11)
    turning = shapes.swapaxes(1, 2) @ mass @ turning_strain(model, theta) @ shapes
    return _Intervals(theta, step, mass, shapes, omega, modal[..., 1], modal[..., 0], modal[..., 2], static, turning)


def _oscillators(data: _Intervals, damping: float, time: float) -> _Oscillators:
    """Exact solution of (E.13) a `time` (s) after the beginning of each sub-interval, load linear in it."""
    omega = data.omega
    decay, omega_d = damping * omega, omega * np.sqrt(1 - damping**2)
    envelope = np.exp(-decay * time)
    cos, sin = envelope * np.cos(omega_d * time), envelope * np.sin(omega_d * time) / omega_d
    matrix = np.empty((*omega.shape, 2, 2))
    matrix[..., 0, 0] = cos + decay * sin  # (5.12)
    matrix[..., 0, 1] = sin
    matrix[..., 1, 0] = -(omega**2) * sin  # (5.13)
    matrix[..., 1, 1] = cos - decay * sin
    slope = (data.load_end - data.load_start) / data.step
    particular = np.empty((*omega.shape, 2))  # y = (p0 + p1 t)/omega^2 - 2 zeta p1/omega^3 solves (E.13)
    particular[..., 0] = data.load_start / omega**2 - 2 * damping * slope / omega**3
    particular[..., 1] = slope / omega**2
    forced = particular - np.einsum("kmij,kmj->kmi", matrix, particular)
    forced[..., 0] += slope * time / omega**2
    return _Oscillators(matrix, forced)


def _joins(data: _Intervals, join: Join, damping: float) -> tuple[Array, Array]:
    """``y_{k+1}(0) = J_k y_k(h)``, ``y'_{k+1}(0) = J_k y'_k(h) - G_k y_k(h)``; after the last sub-interval the first.

    The modes kept turn with the crank. What they lose of the displacement at a join, (1 - Phi Phi^T M) Phi_k y_k,
    happens in no time and so takes momentum with it; G_k gives that back. Without it the sub-intervals converge to an
    equation that lacks (Phi^T M)' (1 - Phi Phi^T M) Phi' y, a change of stiffness of about one per cent here.

    Damping acts on the rate at which the links are strained. What their turning adds to y', inside the sub-intervals,
    acts as an impulse at the joins: half of it each of the sub-intervals before and after.

    Returns
    -------
    matrices : ndarray
        J_k, shape ``(N, modes, modes)``.
    kicks : ndarray
        G_k (1/s), shape ``(N, modes, modes)``.
    """
    following, mass = np.roll(data.shapes, -1, axis=0), np.roll(data.mass, -1, axis=0)
    weighted = following.swapaxes(1, 2) @ mass
    matrices = weighted @ data.shapes
    drag = damping * data.step * data.omega[..., None] * data.turning
    kicks = matrices @ drag + np.roll(drag, -1, axis=0) @ matrices
    if join == "modal":
        sizes = np.einsum("kim,kij,kjm->km", data.shapes, mass, data.shapes, optimize=True)
        matrices = np.array([_tracking(product, size) for product, size in zip(matrices, sizes, strict=True)])
        kicks = np.zeros_like(matrices)
    if join == "physical":
        lost = data.shapes - following @ matrices
        kicks += (weighted - matrices @ data.shapes.swapaxes(1, 2) @ data.mass) @ lost / data.step
    return matrices, kicks


def _tracking(product: Array, size: Array) -> Array:
    """Signed permutation that follows each mode into the next position, (5.14).

    `product` is Phi_next^T M_next Phi, ``(modes, modes)``, and `size` the diagonal of Phi^T M_next Phi.
    """
    criterion = product**2 / size  # modal assurance criterion, weighted by the next position's mass
    rows, columns = linear_sum_assignment(criterion, maximize=True)
    answer = np.zeros_like(product)
    answer[rows, columns] = np.where(product[rows, columns] < 0, -1.0, 1.0)
    return answer


def _advance(state: Array, join: Array, kick: Array, matrix: Array, forced: Array) -> Array:
    """Bring modal states from the beginning of a sub-interval to that of the next.

    A state has columns of (y, y'), ``(modes, 2, columns)``; `forced` acts on the last. See `_joins` for J_k and G_k.
    """
    end = matrix @ state  # (5.17), (5.18), (5.20), (5.21)
    end[..., -1] += forced  # (5.19), (5.22)
    modes = len(state)
    answer = (join @ end.reshape(modes, -1)).reshape(state.shape)  # (5.14)
    answer[:, 1] -= kick @ end[:, 0]
    return answer


def _closed_cycle(joins: Array, kicks: Array, whole: _Oscillators) -> Array:
    """Modal state at the beginning of each sub-interval of the periodic solution, shape ``(N, modes, 2)``.

    The cyclic system (5.16) is condensed to the first sub-interval's unknowns by multiplying the transfer matrices.
    They are those of damped oscillators, so neither the product nor the march that follows lets errors grow.
    """
    count, modes = whole.matrix.shape[:2]
    steps = list(zip(joins, kicks, whole.matrix, whole.forced, strict=True))
    transfer = np.eye(2 * modes, 2 * modes + 1).reshape(modes, 2, -1)  # last column: the inhomogeneous part
    for step in steps:
        transfer = _advance(transfer, *step)
    cycle = transfer.reshape(2 * modes, -1)
    start = np.empty((count + 1, modes, 2))
    start[0] = np.linalg.solve(np.eye(2 * modes) - cycle[:, :-1], cycle[:, -1]).reshape(modes, 2)  # (5.15)
    for k, step in enumerate(steps):
        start[k + 1] = _advance(start[k, ..., None], *step)[..., 0]
    gap = np.abs(start[-1] - start[0]).max(axis=0) / np.abs(start).max(axis=(0, 1))
    if not np.all(gap < CLOSURE_TOLERANCE):
        raise ArithmeticError(
            f"the periodic solution does not close: relative gap {gap.max():.1e}, allowed {CLOSURE_TOLERANCE:.0e}"
        )
    return start[:-1]
