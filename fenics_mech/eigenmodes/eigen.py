"""The generalised Hermitian eigenproblem (E.2) at every position, by SLEPc."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from fenics_mech._arrays import Array
from fenics_mech._guard import guarded
from fenics_mech._petsc import SLOWEST_MODES, WHOLE_SPECTRUM, PETSc, SLEPc, configured, name_of, to_petsc
from fenics_mech._ranks import over_positions
from fenics_mech.eigenmodes.tracking import Modes, track
from fenics_mech.errors import SolverError
from fenics_mech.mechanism import RigidModes, System

logger = logging.getLogger(__name__)
SEED = 0  # of the vector that the solver starts from


@dataclass(frozen=True)
class EigenLimits:
    """Limits by which eigenvalues count as equal, as zero, and as complete."""

    equal: float = 1e-6  # relative distance of eigenvalues that count as one: a Krylov space may miss one of them
    rounding: float = 10  # of an eigenvalue, in units of rounding of the largest one
    most_rounding: float = 0.1  # share of an eigenvalue that is allowed for rounding at most
    zero: float = 1e-6  # of the shift, up to which an eigenvalue counts as 0
    counted: int = 8  # positions at which eigenvalues are counted, at most: each costs a factorisation
    alike: int = 10  # vectors of a Krylov space at most, beside two for each mode wanted


EIGENSOLVER = EigenLimits()


def modes_kept(modes: int | Literal["all"], size: int) -> int:
    """Give the number of modes that are kept of a mechanism with so many coordinates.

    Parameters
    ----------
    modes
        The number asked for, as of `Analysis`.
    size
        Number of coordinates.
    """
    return size if modes == "all" else min(modes, size)


def natural(system: System) -> System:
    """Give the mechanism whose natural modes are told and damped in the place of another.

    Under exact strains it is that without axial forces, at all rates of the drive: the law of the elements has these,
    and what they change along an element would be half of them.

    Parameters
    ----------
    system
        The mechanism.
    """
    return system if system.terms.law is None else system.without_axial_forces


@guarded()
def solve_modes(system: System, modes: int | Literal["all"], options: Mapping[str, Any] | None = None) -> Modes:
    """Solve for the lowest modes at every angle of a system and track them over the cycle.

    Parameters
    ----------
    system
        The mechanism; its angles are taken as one closed cycle.
    modes
        Number of modes that bend the links; more than there are means all, as "all" does. Rigid-body modes come before
        them, with the frequency 0.
    options
        PETSc options with the prefix "modes_".

    Raises
    ------
    SolverError
        When SLEPc does not converge, or an eigenvalue is not positive.
    """
    count, system = modes_kept(modes, system.size), natural(system)
    return system.once("modes", lambda: _solve_all(system, count, options or {}), (count, str(options)))


def _solve_all(system: System, count: int, options: Mapping[str, Any]) -> Modes:
    rigid, angles = RigidModes.of(system), len(system.motion.theta)
    logger.info("%d modes at %d positions", count, angles)
    count, first = min(count, system.size - len(rigid)), len(rigid)
    positions: Iterator[tuple[int, sp.csr_matrix, sp.csr_matrix]]
    if rigid.separate is not None:
        squares, shapes = np.zeros((angles, first + count)), np.empty((angles, first + count, system.size))
        shapes[:, :first] = rigid.shapes
        squares[:, first:], shapes[:, first:] = _solve_beside(rigid, system, count, options)
        positions = iter([(0, rigid.separate.mass, rigid.separate.stiffness)])
    else:
        squares, shapes = over_positions(angles, lambda among: _solve_among(system, among, count, options))
        masses, stiffnesses = system.held_matrices()
        positions = ((k, masses.at(k), stiffnesses.at(k)) for k in range(angles))
    dense = {f"modes_{key}": value for key, value in WHOLE_SPECTRUM.items()}
    if not first and not dense.items() <= options.items() and _misses_one(positions, squares):
        logger.info("a mode of a repeated frequency is missing: all are solved for anew by LAPACK")
        return _solve_all(system, count, {**options, **dense})
    momenta = system.mass_times(shapes)
    norms = np.sqrt(np.einsum("kmi,kmi->km", shapes, momenta))[..., None]
    shapes /= norms  # (E.7)
    momenta /= norms
    ahead = np.roll(shapes, -1, axis=0)
    momenta_ahead = system.mass_times(shapes, shift=1)
    transfer = ahead @ momenta_ahead.transpose(0, 2, 1)
    size = np.einsum("kmi,kmi->km", shapes, momenta_ahead)
    back = momenta @ ahead.transpose(0, 2, 1)
    return track(system.motion.theta, np.sqrt(squares), shapes, transfer, back, size)


def _misses_one(positions: Iterator[tuple[int, sp.csr_matrix, sp.csr_matrix]], squares: Array) -> bool:
    """Whether an eigenvalue is missing, as a Krylov space may hold fewer vectors of a repeated one than there are.

    By Sylvester's law of inertia as many eigenvalues are below a number as ``K - number M`` has negative pivots. Looked
    at are the first position, and those at which two modes are next to each other.
    """
    close = (np.diff(squares, axis=1) < EIGENSOLVER.equal * squares[:, 1:]).any(axis=1)
    looked_at = {0, *np.flatnonzero(close)[: EIGENSOLVER.counted].tolist()}
    for k, mass, stiffness in positions:
        if k in looked_at:
            heavy = mass.diagonal() > 0
            fastest = (stiffness.diagonal()[heavy] / mass.diagonal()[heavy]).max(initial=0.0)
            rounding = EIGENSOLVER.rounding * np.finfo(float).eps * fastest / squares[k, -1]
            bound = squares[k, -1] * (1 - min(max(EIGENSOLVER.equal, rounding), EIGENSOLVER.most_rounding))
            shifted = (stiffness - bound * mass).tocsc()
            factors = splu(shifted, "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
            if (factors.U.diagonal() < 0).sum() > (squares[k] < bound).sum():
                return True
        if k >= max(looked_at):
            break
    return False


@contextmanager
def _solver(
    system: System, count: int, options: Mapping[str, Any], first: int = 0
) -> Iterator[tuple[SLEPc.EPS, PETSc.Vec]]:
    """Set up the eigensolver for so many modes, beside others that come first, and the vector that it starts from."""
    members = len(system.beams.mesh.members)  # those that are alike have modes in common, nearly at one frequency
    subspace = 2 * count + min(members + 1, EIGENSOLVER.alike)  # with more the basis costs more than few restarts do
    few = subspace + first < system.size and options.get("modes_eps_type") != WHOLE_SPECTRUM["eps_type"]
    defaults = SLOWEST_MODES | {"eps_ncv": subspace} if few else WHOLE_SPECTRUM
    eps = SLEPc.EPS().create(comm=PETSc.COMM_SELF)
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    eps.setDimensions(count)
    start = np.random.default_rng(SEED).uniform(-1, 1, system.size)
    with configured(eps, "modes_", defaults, options):
        yield eps, PETSc.Vec().createWithArray(start, comm=PETSc.COMM_SELF)


def _solve_among(system: System, among: slice, count: int, options: Mapping[str, Any]) -> tuple[Array, Array]:
    """Lowest eigenvalues and eigenvectors at some of the angles."""
    angles = len(system.motion.theta[among])
    squares, shapes = np.empty((angles, count)), np.empty((angles, count, system.size))
    with _solver(system, count, options) as (eps, start):
        for i, (k, mass, stiffness) in enumerate(system.positions(symmetric=True, among=among)):
            eps.setOperators(stiffness, mass)
            squares[i], shapes[i] = _solve_position(eps, start, system, k, count)
            _refuse_negative(system, k, squares[i, 0], shapes[i, 0])
    return squares, shapes


def _solve_beside(rigid: RigidModes, system: System, count: int, options: Mapping[str, Any]) -> tuple[Array, Array]:
    """Lowest eigenvalues and eigenvectors beside rigid-body modes, by K + shift M, which is not singular.

    The coordinates separate motions of rigid links, which springs and axial forces may hold, from those that bend.
    """
    assert rigid.separate is not None
    basis, mass, stiffness = rigid.separate.basis, rigid.separate.mass, rigid.separate.stiffness
    shift, first = rigid.lowest_elastic() if len(rigid) else 0.0, len(rigid)
    matrices = to_petsc((stiffness + shift * mass).tocsr()), to_petsc(mass)
    with _solver(system, count, options, first) as (eps, start):
        eps.setOperators(*matrices)
        dense = eps.getType() == SLEPc.EPS.Type.LAPACK  # it finds them all, and knows no deflation
        if dense:
            eps.setDimensions(count + first)
        elif first:
            eps.setDeflationSpace([PETSc.Vec().createWithArray(y, comm=PETSc.COMM_SELF) for y in rigid.separate_shapes])
        values, shapes = _solve_position(eps, start, system, 0, count + dense * first)
        if dense and _positive(stiffness + shift * mass):
            _refine_lowest(eps, matrices, values, shapes)
        _refuse_negative(system, 0, values[0] - shift, (basis @ shapes[0].T).T, EIGENSOLVER.zero * shift)
    return values[len(values) - count :] - shift, (basis @ shapes[len(shapes) - count :].T).T


def _positive(matrix: sp.csr_matrix) -> bool:
    """Whether a matrix is positive definite, whatever the units of its coordinates are."""
    unit = 1 / np.sqrt(np.abs(matrix.diagonal()))
    try:
        np.linalg.cholesky(matrix.toarray() * np.outer(unit, unit))
    except np.linalg.LinAlgError:
        return False
    return True


def _refine_lowest(eps: SLEPc.EPS, matrices: tuple[PETSc.Mat, PETSc.Mat], values: Array, shapes: Array) -> None:
    """Solve ``M x = x/value`` for those of the eigenvalues that are next to 0, in place.

    LAPACK's errors are shares of the largest eigenvalue, here of the largest 1/value.
    """
    stiffness, mass = matrices
    eps.setOperators(mass, stiffness)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.LARGEST_REAL)
    eps.solve()
    inverse = np.array([eps.getEigenvalue(i).real for i in range(eps.getConverged())])
    order = np.argsort(-inverse)
    vector, most = stiffness.createVecRight(), abs(values[-1])
    for place, i in enumerate(order[: len(values)]):
        if inverse[i] < np.sqrt(inverse[order[0]] / most):
            break
        eps.getEigenvector(int(i), vector)
        values[place], shapes[place] = 1 / inverse[i], vector.array_r


def _solve_position(eps: SLEPc.EPS, start: PETSc.Vec, system: System, k: int, count: int) -> tuple[Array, Array]:
    """Lowest eigenvalues (rad^2/s^2) and eigenvectors at position k, ascending.

    Each position starts from the same vector: what it gives to the last bit does not depend on the ones before it.
    """
    eps.setInitialSpace(start)
    eps.solve()
    if eps.getConvergedReason() <= 0 or eps.getConverged() < count:
        found = name_of(SLEPc.EPS.ConvergedReason, eps.getConvergedReason())
        where = f"at drive angle {np.degrees(system.motion.theta[k]):.6g} deg"
        raise SolverError(f"{eps.getConverged()} of {count} modes converged {where} (SLEPc says {found})")
    values = np.array([eps.getEigenvalue(i).real for i in range(count)])
    order, shapes, vector = np.argsort(values), np.empty((count, system.size)), start.duplicate()
    for place, i in enumerate(order):
        eps.getEigenvector(int(i), vector)
        shapes[place] = vector.array_r
    return values[order], shapes


def _refuse_negative(system: System, k: int, lowest: float, q: Array, noise: float = 0.0) -> None:
    """Raise where the lowest eigenvalue at position k, of the shape q, is not positive."""
    if lowest <= -noise:
        where = f"at drive angle {np.degrees(system.motion.theta[k]):.6g} deg"
        raise SolverError(
            f"mode 1 has the eigenvalue {lowest:.3g} (rad/s)^2 {where}: the stiffness is not positive "
            f"there, and the mechanism buckles or gives way; link {system.bent_most(k, q)} bends most"
        )
