"""Eigenvalues of the monodromy matrix: all of them, or the largest of those that the steps can follow.

Steps at Gauss points hardly damp what is too fast for them. Krylov spaces of their monodromy matrix fill with that.
Radau points damp it, so that they give the space of the slow disturbances, in which Gauss points then give the
multipliers. What they leave of the fast ones there is damped by another cycle at Radau points.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech._petsc import PETSc, SLEPc, configured, name_of
from fenics_mech._sparse import LANES
from fenics_mech.errors import SolverError
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.krylov import products

Complex = NDArray[np.complex128]
Products = Callable[[Array], Array]  # of a matrix with several vectors, ``(size, vectors)``
Space = tuple[Array, Array, bool]  # see `_by_blocks`
Eigenpairs = tuple[Complex, Complex]  # eigenvalues, and with each its state at the start of the cycle, (pairs, states)


@dataclass(frozen=True)
class MultiplierLimits:
    """How many multipliers are looked for, and how precisely."""

    few_states: int = 80  # of which all multipliers are found as fast as some
    wanted: int = 12  # slow disturbances that are looked for first
    most_states: int = 800  # of which all are found where some are not enough
    tolerance: float = 1e-6  # of Krylov spaces: rounding of very fine meshes leaves no less
    rounding: float = 1e-14  # of the largest image, in what is left over
    restarts: int = 30  # of Krylov spaces of SLEPc
    vectors: int = 20  # of a Krylov space at most, for each that is wanted
    above_rounding: float = 100.0  # times the rounding of a march: what less is left of a disturbance tells nothing
    lost: float = 1e-8  # of the largest multiplier at Radau points: disturbances that are hardly left after a cycle


MULTIPLIERS = MultiplierLimits()


def eigenpairs(flow: Flow, damped: Flow | None, options: Mapping[str, Any]) -> Iterator[tuple[Eigenpairs, bool, float]]:
    """Give multipliers, more with each try, whether they are all that count, and up to which size they are rounding.

    Parameters
    ----------
    flow
        The steps at Gauss points.
    damped
        The same steps at Radau points; None where all multipliers are wanted at once.
    options
        PETSc options with the prefix "stability_".

    Raises
    ------
    SolverError
        When SLEPc does not converge.
    """
    states, wanted = 2 * flow.size, MULTIPLIERS.wanted
    if damped is None and states > MULTIPLIERS.most_states:
        damped = flow  # what diverges is the largest there, too
    while damped is not None and states > MULTIPLIERS.few_states and 4 * wanted <= min(states, MULTIPLIERS.most_states):
        last = min(16 * wanted, states) > MULTIPLIERS.most_states
        slow, whole = _slow(flow, damped, wanted, options)
        yield slow, last or whole, 0.0  # those that are lost are not among them
        wanted *= 4
    unit = np.tile(flow.unit, 2)
    monodromy = flow.monodromy * unit[:, None] / unit
    rounding = float(np.finfo(float).eps * np.linalg.norm(monodromy, 2))
    matrix = PETSc.Mat().createDense(monodromy.shape, array=monodromy, comm=PETSc.COMM_SELF)
    matrix.setUp()
    values, found = _solved(matrix, {"eps_type": "lapack"}, options)
    yield (values, found / unit), True, rounding


def _slow(flow: Flow, damped: Flow, wanted: int, options: Mapping[str, Any]) -> tuple[Eigenpairs, bool]:
    """Give the multipliers in the space of the disturbances that Radau points damp least.

    The second value says whether these are all that count: some that were found are hardly left after a cycle, and
    those that were not found are smaller.
    """
    unit = np.tile(flow.unit, 2)

    def carried(states: Array, steps: Flow) -> Array:
        """States ``(states, disturbances)`` after a cycle, all numbers alike."""
        return steps.after_cycle(states / unit[:, None]) * unit[:, None]

    asked = any(name.startswith("stability_") for name in options)
    find = partial(_by_slepc, options=options) if asked else _by_blocks
    space, left, whole = find(lambda states: carried(states, damped), len(unit), wanted)
    if not space.shape[1]:
        return (np.zeros(0, dtype=complex), np.zeros((0, len(unit)), dtype=complex)), False
    right = carried(carried(space, flow), damped)
    rounding = np.linalg.norm(left[:, 0] - carried(space[:, :1], damped)[:, 0])  # one state is summed in another order
    outward, sizes, inward = np.linalg.svd(left, full_matrices=False)
    clear = sizes > MULTIPLIERS.above_rounding * rounding
    space, right = space @ inward[clear].T, right @ inward[clear].T
    reduced = (outward[:, clear] / sizes[clear]).T @ right  # least squares of left x = right
    values, parts = (part.astype(np.complex128) for part in np.linalg.eig(reduced))
    return (values, (space.astype(np.complex128) @ parts).T / unit), whole


def _by_slepc(apply: Products, size: int, wanted: int, options: Mapping[str, Any]) -> Space:
    """Find the space of the largest eigenvalues of a matrix by SLEPc, as the options ask for; see `_by_blocks`."""
    matrix = products(size, lambda state: apply(state[:, None])[:, 0])
    limits = {"eps_tol": MULTIPLIERS.tolerance, "eps_max_it": MULTIPLIERS.restarts}
    values, states = _solved(matrix, {"eps_type": "krylovschur", "eps_nev": wanted} | limits, options)
    kept = states[_not_lost(values)]
    space = np.linalg.svd(np.concatenate([kept.real, kept.imag]).T, full_matrices=False)[0][:, : len(kept)]
    return space, apply(space), len(kept) < len(states)


def _by_blocks(apply: Products, size: int, wanted: int) -> Space:
    """Find the space of the largest eigenvalues by Arnoldi's method with blocks of vectors.

    All vectors of a block pass through the cycle at once, in little more time than one of them.

    Source: Saad, Numerical Methods for Large Eigenvalue Problems (2011), section 6.4.

    Returns
    -------
    tuple
        An orthonormal basis of the eigenvectors that have converged, as many as are wanted or more, and its products
        with the matrix. Whether all other eigenvalues are lost beside the largest.
    """
    most = min(MULTIPLIERS.vectors * wanted, size) // LANES * LANES
    basis, images = np.empty((size, most + LANES)), np.empty((size, most))
    basis[:, :LANES] = np.linalg.qr(np.random.default_rng(0).standard_normal((size, LANES)))[0]
    for last in range(LANES, most + 1, LANES):
        now, known = slice(last - LANES, last), basis[:, :last]
        images[:, now] = apply(known[:, now])
        if not np.isfinite(images[:, now]).all():
            raise SolverError("no Floquet multiplier was found: disturbances grow beyond all numbers in a cycle")
        rest, left_over = images[:, now], np.eye(LANES)
        for _ in range(3):  # where no new directions are left, the rest is rounding, hardly orthogonal at first
            rest, part = np.linalg.qr(rest - known @ (known.T @ rest))
            left_over = part @ left_over
        basis[:, last : last + LANES] = rest
        values, vectors = np.linalg.eig(known.T @ images[:, :last])
        rounding = MULTIPLIERS.rounding * np.linalg.norm(images[:, :last], 2)
        residuals = np.linalg.norm(left_over @ vectors[now], axis=0) - rounding
        counted = _not_lost(values)
        found = counted & (residuals < MULTIPLIERS.tolerance * np.abs(values))
        whole = bool((found == counted).all()) and not counted.all()
        if whole or (last >= wanted and found[np.argsort(-np.abs(values))[:wanted]].all()):
            break
    parts = vectors[:, found]
    turned = np.linalg.svd(np.concatenate([parts.real, parts.imag], axis=1))[0][:, : parts.shape[1]]
    return basis[:, :last] @ turned, images[:, :last] @ turned, whole


def _not_lost(values: Complex) -> NDArray[np.bool_]:
    """Which eigenvalues are not lost beside the largest."""
    return np.asarray(np.abs(values) > MULTIPLIERS.lost * np.abs(values).max(initial=0.0))


def _solved(matrix: PETSc.Mat, defaults: Mapping[str, Any], options: Mapping[str, Any]) -> Eigenpairs:
    """Solve for eigenvalues of largest magnitude; the matrix is destroyed."""
    eps = SLEPc.EPS().create(comm=PETSc.COMM_SELF)
    eps.setProblemType(SLEPc.EPS.ProblemType.NHEP)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.LARGEST_MAGNITUDE)
    real, imaginary = matrix.createVecs()
    with configured(eps, "stability_", defaults, options):
        eps.setOperators(matrix)
        eps.solve()
        count = eps.getConverged()
        if not count:
            found = name_of(SLEPc.EPS.ConvergedReason, eps.getConvergedReason())
            raise SolverError(
                f"no Floquet multiplier converged (SLEPc says {found}). Other options stability_eps_* may help; "
                "analysis.stability = false does without"
            )
        values, states = np.empty(count, complex), np.empty((count, matrix.size[0]), complex)
        for i in range(count):
            values[i] = eps.getEigenpair(i, real, imaginary)
            states[i] = real.array_r + 1j * imaginary.array_r
    for thing in (matrix, real, imaginary):
        thing.destroy()
    return values, states
