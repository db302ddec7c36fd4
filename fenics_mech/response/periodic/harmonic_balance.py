"""Periodic response as a truncated Fourier series: harmonic balance, of the whole equation of motion, linear or not.

The coordinates are ``q = B Q`` with B the sines and cosines of all harmonics at equal steps of the cycle. The residual
of the equation is taken at these steps. Carried back to the harmonics by ``B^T`` it has to vanish (alternating
frequency and time). Between the harmonics kept the residual does not vanish, and estimates the error.

Source: Krack and Gross, Harmonic Balance for Nonlinear Vibration Problems, ch. 2 and 3.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech._petsc import PETSc
from fenics_mech._sparse import Stack
from fenics_mech.errors import SolverError, UnresolvedError
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.response.periodic.cyclic import CYCLIC, not_closed
from fenics_mech.response.periodic.krylov import krylov
from fenics_mech.response.periodic.newton import Orbit, solve_nonlinear

KRYLOV = {"ksp_pc_side": "right", "ksp_rtol": 1e-12, "ksp_gmres_restart": 400, "ksp_max_it": 2000}


@dataclass(frozen=True)
class Series:
    """A Fourier series of the coordinates over the cycle.

    Parameters
    ----------
    coefficients
        Mean, then cosine and sine of harmonic 1, 2 and so on, ``(1 + 2 harmonics, coordinates)``.
    rate
        Circular frequency of harmonic 1 (rad/s).
    error
        Estimate of the error of q, the largest over the largest q, each coordinate weighed as in the strain energy.
    condition
        How many times a relative error of the equation comes out in the motion, by estimate.
    """

    coefficients: Array
    rate: float
    error: float
    condition: float

    def at(self, phase: Array) -> tuple[Array, Array]:
        """Give q and q' at places of the cycle, 0 to 2 pi in the order of time, each ``(places, coordinates)``.

        Parameters
        ----------
        phase
            Places (rad), ``(places,)``.
        """
        basis = _basis(phase, len(self.coefficients) // 2, self.rate)
        return basis[0] @ self.coefficients, basis[1] @ self.coefficients


def solve_harmonic_balance(
    equation: Equation, harmonics: int, period: float, options: Mapping[str, Any], tension: Array | None = None
) -> Series:
    """Solve for the periodic motion.

    Parameters
    ----------
    equation
        The equation of motion at equal steps of a cycle, at least ``4 harmonics + 1`` of them.
    harmonics
        Number of harmonics kept.
    period
        Duration of the cycle (s).
    options
        PETSc options with the prefix "periodic_".
    tension
        A rough axial force of each element (N), ``(angles, elements)``; None where the links have no nonlinear law.

    Raises
    ------
    SolverError
        When the linear solver or Newton's method does not converge, or the harmonics are too few.
    """
    count = len(equation.linear.load)
    if count <= 4 * harmonics:
        raise UnresolvedError(
            f"{harmonics} harmonics need more than {4 * harmonics} sub_intervals, and there are {count}: give more "
            "sub_intervals or fewer harmonics"
        ).finer_by(sub_intervals=4 * harmonics + 2)
    rate = 2 * np.pi / period
    basis = _basis(2 * np.pi * np.arange(count) / count, harmonics, rate)
    series: Series | None = None

    def solve(matrices: Matrices) -> Orbit:
        nonlocal series
        series = _solve_linear(matrices, basis, rate, options)
        q, velocity, acceleration = basis @ series.coefficients
        return Orbit(q, velocity, acceleration, q, velocity)

    if tension is None:
        solve(equation.linear)
    else:
        solve_nonlinear(equation, solve, tension)
    assert series is not None
    if series.error > CYCLIC.largest_series_error:
        raise UnresolvedError(
            f"{harmonics} harmonics are too few: the error is about {series.error:.1e} of the motion. Give more "
            "analysis.harmonics (and sub_intervals)"
        ).finer_by(harmonics=2 * harmonics, sub_intervals=max(count, 8 * harmonics + 2))
    return series


def _basis(phase: Array, harmonics: int, rate: float) -> Array:
    """Mean, cosines and sines and their first two time derivatives, ``(3, places, 1 + 2 harmonics)``."""
    order = np.arange(1, harmonics + 1)
    angle = phase[:, None] * order
    cosine, sine, speed = np.cos(angle), np.sin(angle), rate * order
    pairs = [(cosine, sine), (-speed * sine, speed * cosine), (-(speed**2) * cosine, -(speed**2) * sine)]
    basis = np.zeros((3, len(phase), 1 + 2 * harmonics))
    basis[0, :, 0] = 1
    basis[:, :, 1::2], basis[:, :, 2::2] = (np.stack(part) for part in zip(*pairs))
    return basis


def _solve_linear(matrices: Matrices, basis: Array, rate: float, options: Mapping[str, Any]) -> Series:
    """Solve ``B^T (M B'' + C B' + K B) Q = B^T f`` by a KSP."""
    count, kept = basis.shape[1:]
    n = matrices.load.shape[1]
    weight = np.sqrt(np.abs(matrices.stiffness.diagonal.mean(axis=0)))  # axial and bending made alike
    parts = [part.scaled(1 / weight) for part in (matrices.whole_stiffness, matrices.whole_damping, matrices.mass)]
    load, back = matrices.load / weight, basis[0].T * (2 / count)

    def force(series: Array) -> Array:
        return np.sum([part.times(motion) for part, motion in zip(parts, basis @ series.reshape(kept, n))], axis=0)

    differences = _Differences(parts, basis)

    def solved(load: Array) -> Array:
        return _balanced(lambda series: (back @ force(series)).ravel(), (back @ load).ravel(), differences, options)

    answer = solved(load)
    motion = basis @ answer.reshape(kept, n)
    size = max(np.abs(motion[0]).max(), TINY)
    left = differences.solve(load - force(answer))  # the harmonics left out, and what they do to the others
    parts_of = np.sum([part.magnitude.times(np.abs(term) / size) for part, term in zip(parts, motion)], axis=0)
    try:  # as in `magnification`
        changed = solved(np.random.default_rng(0).choice([-1.0, 1.0], load.shape) * parts_of)
        condition = float(np.abs(basis[0] @ changed.reshape(kept, n)).max())
    except SolverError:
        condition = np.inf
    return Series(answer.reshape(kept, n) / weight, rate, float(np.abs(left).max() / size), condition)


def _balanced(
    apply: Callable[[Array], Array], right: Array, differences: _Differences, options: Mapping[str, Any]
) -> Array:
    """Solve the balance of the harmonics."""
    answer, reason = krylov(apply, right, KRYLOV, options, differences)
    residual = float(np.linalg.norm(apply(answer) - right)) / max(float(np.linalg.norm(right)), TINY)
    if reason <= 0 or not residual < CYCLIC.largest_residual:
        raise not_closed(reason, residual, what="the harmonics cannot be balanced")
    return answer


class _Differences:
    """Preconditioner: the equation with central differences between the angles, one sparse block-cyclic system.

    Source: Orszag, J. Comput. Phys. 37 (1980) 70: differences make good preconditioners of spectral derivatives. The
    mean matrices of harmonic balance as usual do not, as the links' stiff directions turn with the drive.
    """

    def __init__(self, parts: Sequence[Stack], basis: Array) -> None:
        pattern = parts[0].pattern.joined(parts[1].pattern).joined(parts[2].pattern)
        stiffness, damping, mass = (part.on(pattern).values for part in parts)
        count, size = len(mass), pattern.size
        step = 2 * np.pi / (basis[1, 0, 2] * count)  # a sine's slope at the start is the drive's rate
        mass, damping = mass / step**2, damping / (2 * step)
        values = np.stack([mass - damping, stiffness - 2 * mass, mass + damping])
        at = np.arange(count)[:, None]
        rows = np.broadcast_to(at * size + pattern.rows, values.shape)
        columns = np.stack([(at + ahead) % count * size + pattern.columns for ahead in (-1, 0, 1)])
        matrix = sp.coo_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape=(count * size,) * 2)
        self.factors = splu(matrix.tocsc())  # with pivoting, which PETSc's own LU has not: the equation is indefinite
        self.basis = basis[0]

    def solve(self, right: Array) -> Array:
        """Solve for the motion at all angles, ``(angles, coordinates)``."""
        return self.factors.solve(right.ravel()).reshape(right.shape)

    def apply(self, pc: PETSc.PC, x: PETSc.Vec, y: PETSc.Vec) -> None:
        series = x.array_r.reshape(self.basis.shape[1], -1).copy()
        series[0] /= 2
        motion = self.basis.T @ self.solve(self.basis @ series) * (2 / len(self.basis))
        motion[0] /= 2
        y.array[:] = motion.ravel()
