"""Periodic motion as a truncated Fourier series: harmonic balance of the residual, a check of the steps of `periodic`.

Coordinates are ``q = B Q`` with B the mean, cosines and sines of all harmonics at even instants of the cycle, and so
are multipliers. Modes of stress are what the rates say at each instant. The residual is taken at these instants.
Carried back to the harmonics by B^T it has to vanish (alternating frequency and time). With the tangents of the
instants a step of Newton's method is

    B^T (M B'' + C B' + K B) dQ = -B^T R,

solved by GMRES. Central differences between the instants make its preconditioner, one sparse block-cyclic matrix.

Source: Krack and Gross, Harmonic Balance for Nonlinear Vibration Problems, ch. 2 and 3; Orszag, J. Comput. Phys. 37
(1980) 70, for differences as preconditioners of spectral derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError, UnresolvedError
from fenics_mech.machine import Evaluation, Machine
from fenics_mech.solve.newton import newton
from fenics_mech.solve.operators import by_gmres
from fenics_mech.solve.path import Path
from fenics_mech.solve.periodic import LEAST
from fenics_mech.solve.stages import radau

CLOSE = 1e-9  # last change of Newton's method, relative to the largest coordinate
ENOUGH = 1e-10  # of the right-hand side, that GMRES leaves
MOST_DIRECTIONS = 300  # of GMRES: differences make it need 10 to 60

UNBALANCED = (
    "the harmonics cannot be balanced: GMRES has not converged. The motion is at a resonance that nothing damps, or "
    "needs more sub_intervals"
)


@dataclass(frozen=True)
class Series:
    """A Fourier series of coordinates and multipliers over a cycle."""

    # mean, then cosine and sine of harmonic 1, 2 and so on, (1 + 2 harmonics, size); none of modes of stress
    coefficients: Array
    period: float  # s
    n: int  # coordinates; what follows them are multipliers

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Give coordinates, rates, and accelerations with multipliers at instants ``(instants, size)`` each."""
        basis, multipliers = _basis(t, len(self.coefficients) // 2, self.period), np.arange(self.coefficients.shape[1])
        q, v, a = basis @ self.coefficients
        held = multipliers >= self.n
        return np.where(held, 0.0, q), np.where(held, 0.0, v), np.where(held, q, a)

    def path(self, steps: Array, stages: int) -> Path:
        """Give the motion by steps that begin at instants ``(steps,)`` (s)."""
        tableau = radau(stages)
        h = np.diff(steps, append=steps[0] + self.period)
        q0, v0, _ = self.at(steps)
        a = self.at((steps[:, None] + h[:, None] * tableau.c).ravel())[2]
        return Path(tableau, steps, self.period, self.n, q0, v0, a.reshape(len(steps), stages, -1))


class Balance:
    """Newton's method on the coefficients, step by step."""

    found: Evaluation

    def __init__(
        self, machine: Machine, period: float, harmonics: int, instants: int, stresses: Sequence[Array] | None = None
    ) -> None:
        if instants <= 4 * harmonics:
            raise UnresolvedError(
                f"{harmonics} harmonics need more than {4 * harmonics} sub_intervals, and there are {instants}: give "
                "more sub_intervals or fewer harmonics"
            ).finer_by(sub_intervals=4 * harmonics + 2)
        self.machine, self.stresses, self.turning = machine, stresses, True
        self.t = period / instants * np.arange(instants)
        self.basis = _basis(self.t, harmonics, period)
        self.weights = np.where(np.arange(1 + 2 * harmonics) == 0, 1.0, 2.0)[:, None] / instants
        self.series = Series(np.zeros((1 + 2 * harmonics, machine.size)), period, machine.n)

    def step(self) -> float:
        """Take a step, and give the size of its change."""
        machine, n, pattern = self.machine, self.machine.n, self.machine.pattern
        state = self.series.at(self.t)
        found = self.found = machine.residual(self.t, *state, predicted=self.stresses, known=True, turning=self.turning)
        shape, differences = self.series.coefficients.shape, _Differences(found, n, self.series.period)
        of_modes = np.arange(machine.size) >= n + machine.held

        def forces(q: Array, v: Array, a: Array) -> Array:
            """Add up what a change does to the residual; `a` gets the modes, whose sizes are E . rates."""
            force = pattern.times(found.M, a) + pattern.times(found.C, v) + pattern.times(found.K, q)
            a[:, of_modes] = force[:, of_modes]
            force += pattern.times(found.M, np.where(of_modes, force, 0.0))
            force[:, of_modes] = 0.0
            return force

        def left(x: Array) -> Array:
            change = _with_multipliers(self.basis @ x.reshape(shape), n)
            return np.asarray((differences.rows * self.back(forces(*change))).ravel())

        def nearly(x: Array) -> Array:
            near = differences.solve(self.basis[0] @ (x.reshape(shape) / differences.rows))
            return self.back(np.where(of_modes, 0.0, near)).ravel()

        right = -(differences.rows * self.back(found.force)).ravel()
        x = by_gmres(lambda x: left(nearly(x)), right, ENOUGH, MOST_DIRECTIONS, "fenics_mech_harmonics_", UNBALANCED)
        change = Series(nearly(x).reshape(shape), self.series.period, n)
        self.change = change.at(self.t)
        forces(*self.change)
        self.stresses = machine.predicted(found, *self.change)
        self.series = Series(self.series.coefficients + change.coefficients, self.series.period, n)
        largest = max(np.abs(self.series.at(self.t)[0]).max(), LEAST * machine.extent)
        return float(np.abs(self.change[0]).max() / largest)

    def back(self, values: Array) -> Array:
        """Carry values at the instants back to coefficients ``(1 + 2 harmonics, size)``."""
        return np.asarray(self.weights * (self.basis[0].T @ values))


def balanced(
    machine: Machine, period: float, harmonics: int, instants: int, *, tolerance: float = CLOSE, most: int = 25
) -> tuple[Series, list[float]]:
    """Find the periodic motion beside the machine's chart as a Fourier series, and the changes of Newton's method."""
    balance = Balance(machine, period, harmonics, instants)
    changes = newton(balance.step, tolerance, most, "the balance of harmonics")
    return balance.series, changes


def _with_multipliers(states: Array, n: int) -> Array:
    """Put multipliers, which are no coordinates, in the place of their accelerations ``(3, instants, size)``."""
    held = np.arange(states.shape[-1]) >= n
    states[2] = np.where(held, states[0], states[2])
    states[:2, :, held] = 0.0
    return states


def _basis(t: Array, harmonics: int, period: float) -> Array:
    """Mean, cosines and sines and their first two time derivatives, ``(3, instants, 1 + 2 harmonics)``."""
    rates = 2 * np.pi / period * np.arange(1, harmonics + 1)
    cosine, sine = np.cos(np.outer(t, rates)), np.sin(np.outer(t, rates))
    basis = np.zeros((3, len(t), 1 + 2 * harmonics))
    basis[0, :, 0] = 1
    basis[:, :, 1::2] = cosine, -rates * sine, -(rates**2) * cosine
    basis[:, :, 2::2] = sine, rates * cosine, -(rates**2) * sine
    return basis


class _Differences:
    """The linearised equation with central differences between the instants: a sparse block-cyclic matrix, factored."""

    # Rows are brought to a size of one, and so are columns: forces and gaps, coordinates and multipliers differ by
    # units.

    def __init__(self, found: Evaluation, n: int, period: float) -> None:
        pattern, count = found.pattern, len(found.t)
        step, size = period / count, pattern.size
        rows = np.repeat(np.arange(size), np.diff(pattern.indptr))
        of_q = pattern.indices < n
        M = np.where(of_q, found.M, 0.0) / step**2
        C = np.where(of_q, found.C, 0.0) / (2 * step)
        here = np.where(of_q, found.K, found.M) - 2 * M
        at = np.arange(count)[:, None]
        values = np.stack([M - C, here, M + C])
        row = np.broadcast_to(at * size + rows, values.shape).ravel()
        column = np.stack([(at + ahead) % count * size + pattern.indices for ahead in (-1, 0, 1)]).ravel()
        matrix = sp.coo_matrix((values.ravel(), (row, column)), shape=(count * size,) * 2).tocsc()
        largest = np.maximum(abs(matrix).max(axis=1).toarray().ravel().reshape(count, size).max(axis=0), 1e-300)
        self.rows = 1 / largest  # (size,), the same at all instants
        matrix = sp.diags(np.tile(self.rows, count)) @ matrix
        self.columns = 1 / np.maximum(abs(matrix).max(axis=0).toarray().ravel(), 1e-300)
        try:
            self.factors = splu((matrix @ sp.diags(self.columns)).tocsc())
        except RuntimeError as error:
            raise SolverError(
                "the harmonics cannot be balanced: the equations are singular. Look for a link that its joints do not "
                "hold"
            ) from error

    def solve(self, right: Array) -> Array:
        """Solve for the motion at all instants, with multipliers, ``(instants, size)``."""
        flat = self.factors.solve((self.rows * right).ravel())
        return np.asarray((self.columns * flat).reshape(right.shape))
