"""Natural modes about an equilibrium: held in a position, or in a frame that turns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import structural_rank

from fenics_mech._arrays import Array
from fenics_mech._petsc import PETSc, SLEPc, configured
from fenics_mech.errors import SolverError
from fenics_mech.machine import Machine, Pattern
from fenics_mech.solve.operators import shell
from fenics_mech.solve.sparse import Blocks, Factors

ROUNDING = float(np.finfo(float).eps)
STARTS = 20  # two or three serve, but LAPACK at times refuses to put pairs of equal eigenvalues in order
SAME = 1e-3  # of eigenvalues and vectors: a double rate of 0 comes out as two that differ by ROUNDING**0.25


def tangents_at(
    machine: Machine, q: Array, a: Array, t: float = 0.0, *, moving: bool = True, angles: Sequence[Array] | None = None
) -> tuple[sp.csr_matrix, sp.csr_matrix, sp.csr_matrix]:
    """Give M, C and K of small motions about an equilibrium: M x'' + C x' + K x = 0.

    The multipliers stand in x with the coordinates, and the rows of the joints in K. Modes of stress are eliminated.

    Parameters
    ----------
    machine
        The machine.
    q, a
        Coordinates, and accelerations with the multipliers ``(size,)``.
    t
        Instant (s).
    moving
        Whether the chart's motion counts; in a chart that turns evenly these are the tangents in the turning frame.
    angles
        As of the residual.
    """
    still = np.zeros((1, machine.size))
    found = machine.residual(np.array([t]), q[None], still, a[None], moving=moving, angles=angles)
    is_multiplier, kept = machine.pattern.indices >= machine.n, machine.n + machine.held
    values = np.where(is_multiplier, 0.0, found.M[0]), found.C[0], np.where(is_multiplier, found.M[0], found.K[0])
    M, C, K = (machine.pattern.matrix(x) for x in values)
    by_modes = K[:kept, kept:]  # forces of the modes of stress, whose sizes are what their rows of C and K give
    C, K = (sp.csr_matrix(X[:kept, :kept] + by_modes @ X[kept:, :kept]) for X in (C, K))
    return M[:kept, :kept], C, K


def frequencies(M: sp.csr_matrix, C: sp.csr_matrix | None, K: sp.csr_matrix, count: int) -> tuple[Array, Array]:
    """Give the slowest natural modes of M x'' + C x' + K x = 0, by SLEPc.

    Parameters
    ----------
    M, C, K
        Sparse matrices; M may be singular, as that of multipliers is. C is None where no force goes with rates.
    count
        How many, at most.

    Returns
    -------
    tuple
        Rates ``(modes,)`` (1/s), the slowest first: a mode goes with exp(rate t). The imaginary part is its frequency
        (rad/s), positive or 0. A positive real part tells of instability: one that grows faster than the last of the
        modes goes with rate is not among them. A rigid motion has the rate 0, once.
        Then the shapes ``(size, modes)``.

    Raises
    ------
    SolverError
        When there are none, or SLEPc does not find them.
    """
    mass, stiffness = M.diagonal(), np.abs(K.diagonal())
    heavy, rows = mass > 0, (mass == 0) & (stiffness == 0)
    held = heavy & (stiffness > 0)
    # K + s^2 M is not singular, though rigid motions be possible. The rates that coordinates have alone are those of
    # fast modes: s^2 is as far below their squares as rounding is below s^2.
    s = ROUNDING**0.25 * (np.sqrt(np.median(stiffness[held] / mass[held])) if held.any() else 1.0)
    free = int(heavy.sum() - rows.sum() + structural_rank(K[rows][:, rows]))  # a scale has no mass, and frees its row
    if free < 1:
        raise SolverError(
            f"natural modes: there are none. {int(heavy.sum())} coordinates have mass, and {int(rows.sum())} rows of "
            "joints and drives hold them"
        )
    count = min(count, free)
    rates, shapes = _held(M, K, s, count) if C is None else _moving(M, C, K, s, 2 * count)  # of both signs
    rates = np.array([_settled(rate, x, M, C, K) for rate, x in zip(rates, shapes.T)])
    kept: list[int] = []
    for i in np.argsort(np.abs(rates), kind="stable"):
        rigid = [shapes[:, k] for k in kept if rates[k] == 0]
        if rates[i].imag >= 0 and not (rates[i] == 0 and _combined(shapes[:, i], rigid)):
            kept.append(i)
    return rates[kept[:count]], shapes[:, kept[:count]]


def _held(M: sp.csr_matrix, K: sp.csr_matrix, s: float, count: int) -> tuple[Array, Array]:
    """Give rates, roots of -K x = rate^2 M x, and shapes."""
    inverse = _Inverse(K + s * s * M)

    def operator(x: Array) -> Array:
        """Multiply by s^2/(s^2 - rate^2)."""
        return inverse.times(s * s * (M @ x))

    values, shapes = _nearest(operator, inverse.unit, M.diagonal() > 0, count)
    if np.abs(K - K.T).max() < len(shapes) * ROUNDING * np.abs(K).max():
        values = values.real.astype(complex)
    rates = s * np.sqrt(1 - 1 / values)
    return np.where(rates.imag < 0, -rates, rates), shapes


def _moving(M: sp.csr_matrix, C: sp.csr_matrix, K: sp.csr_matrix, s: float, count: int) -> tuple[Array, Array]:
    """Give rates, roots of rate^2 M + rate C + K, and shapes."""
    size, whole = K.shape[0], sp.csr_matrix(K + s * C + s * s * M)
    inverse, heavy = _Inverse(whole), M.diagonal() > 0

    def operator(state: Array) -> Array:
        """Multiply by s/(rate - s): the equation of first order, of x and rate/s times x."""
        x, y = state[:size], state[size:]
        found = -inverse.times(s * (C @ x) + s * s * (M @ (x + y)))
        met = inverse.times(np.where(heavy, whole @ np.where(heavy, x, 0.0), 0.0))  # x, as the rows of joints let it be
        return np.concatenate([found, found + met])

    used = heavy | (np.diff(C.tocsc().indptr) > 0)
    values, shapes = _nearest(operator, np.tile(inverse.unit, 2), np.concatenate([used, heavy]), count)
    return s * (1 + 1 / values), shapes[:size]


class _Inverse:
    """Inverse of a sparse matrix, and sizes of its coordinates and multipliers that make an energy of 1."""

    def __init__(self, matrix: sp.spmatrix) -> None:
        csr = sp.csr_matrix(matrix)
        csr.sort_indices()
        pattern = Pattern(csr.shape[0], csr.indptr, csr.indices)
        self.times = Factors(Blocks(pattern, 1), csr.data[:, None, None], "natural modes").solve
        own = np.sqrt(np.abs(csr.diagonal()))
        self.unit = 1 / np.where(own > 0, own, 1.0)


def _nearest(operator: Callable[[Array], Array], unit: Array, kept: Array, count: int) -> tuple[Array, Array]:
    """Give at least the largest eigenvalues ``(pairs,)`` of an operator, and its vectors ``(size, pairs)``."""
    # operator (size,); unit (size,); kept (size,)
    # From one start a Krylov space may miss some of several equal eigenvalues, as those of round bars or of members
    # that are alike. So others are followed too, until one shows nothing new.
    size, values, vectors = np.where(kept, unit, 1.0), [], []  # type: ignore[var-annotated]
    rng, reach, failure = np.random.default_rng(0), 0.0, SolverError("natural modes: SLEPc finds none")
    for _ in range(STARTS):
        try:
            with shell(
                len(size), lambda x: np.where(kept, operator(np.where(kept, size * x, 0.0)), 0.0) / size
            ) as made:
                found = _from_start(made, count, rng)
        except SolverError as error:
            failure = error
            continue
        first, fresh = not values, [0.0]
        reach = max(reach, sorted(abs(value) for value, _ in found)[-count])
        for value, vector in found:
            equal = [x for x, other in zip(vectors, values) if abs(other - value) < SAME * abs(value)]
            if not _combined(vector, equal):
                values.append(value)
                vectors.append(vector)
                fresh.append(abs(value))
        if not first and max(fresh) <= reach * (1 + 1e-9):
            whole = [operator(size * x.real) + 1j * operator(size * x.imag) for x in vectors]
            return np.array(values), np.asarray(np.array(whole).T / values)
    raise failure


def _from_start(shelled: tuple[Any, Any, Any], count: int, rng: np.random.Generator) -> list[tuple[complex, Array]]:
    """Give the largest eigenvalues and their vectors that SLEPc finds from a random start."""
    matrix, real, imaginary = shelled
    eps = SLEPc.EPS().create(PETSc.COMM_SELF)
    eps.setOperators(matrix)
    eps.setProblemType(SLEPc.EPS.ProblemType.NHEP)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.LARGEST_MAGNITUDE)
    eps.setTolerances(1e-12, 100)
    eps.setDimensions(count)
    with configured(eps, "fenics_mech_modes_", {}, {}):
        real.setArray(rng.uniform(-1, 1, real.getSize()))
        eps.setInitialSpace([real])
        eps.solve()
        if (converged := eps.getConverged()) < count:
            raise SolverError(f"natural modes: SLEPc has found {converged} of {count}")
        found = []
        for i in range(converged):
            value = eps.getEigenpair(i, real, imaginary)
            vector = real.getArray() + 1j * imaginary.getArray()
            found.append((value, vector / np.linalg.norm(vector)))
    return found


def _combined(vector: Array, others: list[Array]) -> bool:
    """Whether a vector is a combination of others."""
    if not others:
        return False
    basis = np.array(others).T
    rest = vector - basis @ np.linalg.lstsq(basis, vector, rcond=None)[0]
    return bool(np.linalg.norm(rest) < SAME * np.linalg.norm(vector))


def _settled(rate: complex, x: Array, M: sp.csr_matrix, C: sp.csr_matrix | None, K: sp.csr_matrix) -> complex:
    """Give the rate of a mode, and that of a rigid motion where its stiffness is nothing but rounding."""

    def along(matrix: sp.csr_matrix) -> complex:
        value, size = x.conj() @ (matrix @ x), np.abs(x) @ (abs(matrix) @ np.abs(x))
        return complex(value) if abs(value) > len(x) * ROUNDING * size else 0.0

    if along(K):
        return rate
    damping = 0.0 if C is None else along(C)
    return min((0.0, -damping / along(M)), key=lambda value: abs(value - rate))
