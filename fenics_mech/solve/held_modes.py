"""Modes of a machine that is held at its positions, and their damping."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from scipy.optimize import linear_sum_assignment
from scipy.sparse.linalg import splu

from fenics_mech._arrays import Array, Index
from fenics_mech._petsc import SLOWEST_MODES, PETSc, SLEPc, configured, to_petsc
from fenics_mech.errors import SolverError
from fenics_mech.machine import Evaluation, Machine
from fenics_mech.terms import ModalDamping, Response

POSITIONS = 36  # of a cycle, at which modes are damped
ROUNDING = float(np.finfo(float).eps)
DENSE = 250  # coordinates up to which all modes are found: in few positions the slowest by SLEPc take as long
DENSE_AT_REST = 2500  # the same where joints let links pass: soft springs are not lost beside stiff links then
FOLLOWED = 60  # modes at least, so that those of interest do not leave or enter what is followed
SPARE = 10  # vectors of a Krylov space beside two for each mode: it then restarts few times
HELD = 1e-12  # stiffness of a motion of rigid links, of that of its parts: less is rounding
NOISE = 1e-22  # the same, of the links' own stiffness
TINY = 1e-6  # rad/s, for 0
MASSLESS = 1e149  # rad/s of what has no mass
GIVES_WAY = (
    "the stiffness is not positive there, and the mechanism buckles or gives way. Lower the loads or the speed, hold "
    "what is free by drives or joints, or take stiffer members"
)


@dataclass(frozen=True)
class About:
    """Forces about which a machine vibrates.

    Parameters
    ----------
    stresses
        Of every term ``(instants, elements, measures)`` each.
    pulls
        Multipliers, where accelerations stand ``(instants, size)``.
    """

    stresses: Sequence[Array]
    pulls: Array


def held_modes(machine: Machine, t: float) -> tuple[Array, Array]:
    """Give the frequencies (rad/s) of a machine held at the place of its chart, and shapes of unit stiffness.

    Parameters
    ----------
    machine
        The machine, without damping of modes.
    t
        Instant (s).

    Returns
    -------
    tuple
        ``(modes,)``, the slowest first, and ``(size, modes)``.

    Raises
    ------
    SolverError
        When drives and joints leave something free to move, or nothing at all.
    """
    return next(_each_held(machine, np.array([t])))[:2]


def _each_held(
    machine: Machine, times: Array, about: About | None = None, loose: Array | None = None
) -> Iterator[tuple[Array, Array, Array]]:
    """Give what `held_modes` gives at each of some instants, and the mass ``(coordinates, coordinates)``."""
    found, n = _tangents(machine, times, about), machine.n
    for k, (t, M, K) in enumerate(zip(times, found.pattern.dense(found.M), found.pattern.dense(found.K))):
        if loose is None:
            yield *_held(machine, float(t), M, K), M[:n, :n]
        else:
            omega, shapes = _beside_rigid(M[:n, :n], K, _unbent(machine, times[k : k + 1], about)[:n, :n], loose[:n])
            yield omega, np.pad(shapes, ((0, machine.size - n), (0, 0))), M[:n, :n]


def _tangents(machine: Machine, times: Array, about: About | None) -> Evaluation:
    """Give the tangents of a machine at rest: straight and without loads, or with these and what balances them."""
    zero = np.zeros((len(times), machine.size))
    if about is None:
        if any(term.external for term in machine.terms):
            machine = copy(machine)
            machine.terms = [term for term in machine.terms if not term.external]
            machine.forget_plan()
        return machine.residual(times, zero, zero, zero, moving=False, heavy=False)
    return machine.residual(times, zero, zero, about.pulls, predicted=about.stresses, moving=False)


def _held(machine: Machine, t: float, M: Array, K: Array) -> tuple[Array, Array]:
    """Give frequencies and shapes by the tangents of an instant (s), ``(size, size)`` each."""
    n = machine.n
    free = scipy.linalg.null_space(K[n:, :n], rcond=1e-10) if machine.held else np.eye(n)
    mass, stiffness, what = (
        free.T @ M[:n, :n] @ free,
        free.T @ ((K + K.T)[:n, :n] / 2) @ free,  # loads that turn with links make it unsymmetric
        f"modes of the machine held at {t:.6g} s",
    )
    if not len(stiffness):
        raise SolverError(f"{what}: there are none, as its joints and drives leave no coordinate free")
    try:
        squares, shapes = scipy.linalg.eigh(mass, stiffness)
        slowest = np.abs(shapes[:, -1])
        strained = len(slowest) * ROUNDING * (slowest @ np.abs(stiffness) @ slowest) < 1.0  # its stiffness
    except np.linalg.LinAlgError:  # the stiffness is not positive
        strained = False
    if not strained:
        raise SolverError(
            f"{what}: something is free to move without strain, or unstable. Hold it by drives or joints, or take "
            "frequencies(), which gives rigid motions too"
        )
    whole = np.zeros((machine.size, len(squares)))
    whole[:n] = free @ shapes
    return 1 / np.sqrt(np.maximum(squares[::-1], 1e-300)), whole[:, ::-1]


def _unbent(machine: Machine, t: Array, about: About | None) -> Array:
    """Give the stiffness at an instant without that of the strains of beams ``(size, size)``."""
    beams, zero = machine.beams, np.zeros((1, machine.size))
    rest = copy(machine)
    rest.terms = [term for term in machine.terms if term is not beams and (about is not None or not term.external)]
    rest.forget_plan()
    if about is None:
        found = rest.residual(t, zero, zero, zero, moving=False, heavy=False)
        return found.pattern.dense(found.K[0])
    pairs = [stress for term, stress in zip(machine.terms, about.stresses) if term is not beams]
    found = rest.residual(t, zero, zero, about.pulls, predicted=pairs, moving=False)
    k = machine.terms.index(beams)
    here = machine.residual(t, zero, zero, about.pulls, predicted=about.stresses, moving=False).terms[k]
    assert here.response.by_measure is not None
    alone = replace(here, response=Response(about.stresses[k], np.zeros_like(here.response.by_measure)))
    turned = np.zeros((1, machine.pattern.entries))
    spread = np.zeros_like(zero), np.zeros_like(turned), np.zeros_like(turned), turned
    machine.groups[k].spread(alone, about.stresses[k], machine.pattern, True, spread)
    return np.asarray(found.pattern.dense(found.K[0]) + machine.pattern.dense(turned[0]))


def _beside_rigid(mass: Array, K: Array, added: Array, ways: Array) -> tuple[Array, Array]:
    """Give frequencies, 0 of rigid motions, and shapes of unit stiffness, or of unit mass where they have none."""
    # mass (n, n); K (size, size); added (n, n); ways (n, motions)
    # Motions of rigid links, which joints let pass, are coordinates of their own. In these the links have no
    # stiffness, beside which that of springs, however soft, would be lost to rounding. Elastic motions carry rigid
    # ones so that they have no momentum in them.
    n, count = ways.shape
    free = scipy.linalg.null_space(K[n:, :n], rcond=1e-10) if len(K) > n else np.eye(n)
    mass, stiffness, added = (free.T @ (X + X.T) @ free / 2 for X in (mass, K[:n, :n], added))
    ways = free.T @ ways
    size = np.abs(ways)
    parts, most = (np.einsum("im,ij,jm->m", size, np.abs(X), size) for X in (added, stiffness))
    unit = 1 / np.sqrt(np.maximum(np.maximum(parts, NOISE / HELD * most), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh((ways.T @ added @ ways) * np.outer(unit, unit))
    ways = ways @ (unit[:, None] * vectors[:, np.argsort(-np.abs(values))])
    rigid = int((np.abs(values) < HELD).sum())
    own = np.sqrt(np.abs(np.diag(stiffness)) + np.abs(np.diag(added)))
    places = scipy.linalg.qr(ways.T * own, mode="r", pivoting=True)[1][:count]
    others = np.setdiff1d(np.arange(len(mass)), places)
    basis = np.hstack([np.eye(len(mass))[:, others], ways])
    mass, whole = basis.T @ mass @ basis, basis.T @ added @ basis
    whole[: len(others), : len(others)] = stiffness[np.ix_(others, others)]
    held = len(basis) - rigid
    carried = -np.linalg.solve(mass[held:, held:], mass[held:, :held])
    try:
        squares, shapes = scipy.linalg.eigh(mass[:held, :held] + mass[:held, held:] @ carried, whole[:held, :held])
    except np.linalg.LinAlgError:
        raise SolverError(f"modes of the machine at rest: {GIVES_WAY}") from None
    alone = np.linalg.inv(np.linalg.cholesky(mass[held:, held:])).T if rigid else np.zeros((0, 0))
    found = np.block([[np.zeros((held, rigid)), shapes[:, ::-1]], [alone, carried @ shapes[:, ::-1]]])
    omega = np.append(np.zeros(rigid), 1 / np.sqrt(np.maximum(squares[::-1], 1e-300)))
    return omega, free @ (basis @ found)


@dataclass(frozen=True)
class FollowedModes:
    """Modes of a machine that is held at positions, each after the one that is most alike.

    Parameters
    ----------
    omega
        Frequencies ``(positions, modes)`` (rad/s).
    shapes
        Of unit mass ``(positions, coordinates, modes)``.
    momenta
        The mass times them.
    assurance
        How far each mode is that of the next position, in axes that turn with the chart's poses, 0..1
        ``(positions, modes)``; the last: which of the first it is most.
    """

    omega: Array
    shapes: Array
    momenta: Array
    assurance: Array

    def only(self, those: Index) -> FollowedModes:
        """Give some of the modes."""
        # those (modes,)
        shapes, momenta = self.shapes[..., those], self.momenta[..., those]
        return FollowedModes(self.omega[:, those], shapes, momenta, self.assurance[:, those])


def followed_modes(
    machine: Machine,
    times: Array,
    count: int | None = None,
    *,
    about: About | None = None,
    loose: Array | None = None,
    options: Mapping[str, Any] | None = None,
) -> FollowedModes:
    """Give the modes of a machine held at the places of its chart, followed from one instant to the next.

    Parameters
    ----------
    machine
        The machine, without damping of modes.
    times
        Instants ``(positions,)`` (s).
    count
        How many of the slowest at least; None for all.
    about
        Forces that stiffen it; None for straight members.
    loose
        Motions of rigid links ``(size, motions)`` that joints let pass; what holds none of them has the frequency 0.
        None where there are none.
    options
        Of SLEPc, with the prefix "modes_", for machines with more than `DENSE` coordinates.

    Raises
    ------
    SolverError
        When something is free to move that may not be so, or the stiffness is not positive.
    """
    omegas: list[Array] = []
    shapes: list[Array] = []
    momenta: list[Array] = []
    assurance: list[Array] = []
    if count is None or machine.n <= (DENSE if loose is None else DENSE_AT_REST):
        found: Iterator[tuple[Array, Array, Array | sp.csr_matrix]] = _each_held(machine, times, about, loose)
    else:
        found = _each_slowest(machine, times, about, loose is not None, count, options or {})
    axes, d = machine.known.at(times).R, machine.geometry.d
    poses = np.unique(machine.places[:, 0], return_index=True)[1]  # of those that share a place the first
    poses = poses[machine.places[poses, 0] >= 0]
    place = machine.places[poses, :d]
    first = last = np.zeros((machine.n, 0))
    for R, (held, stiff, mass) in zip(axes[:, poses], found):
        few = slice(min(len(held) if count is None else max(count, FOLLOWED), int((held < MASSLESS).sum())))
        omega, shape = held[few], (np.where(held > 0, held, 1.0) * stiff[: machine.n])[:, few]
        momentum = mass @ shape
        carried, pushed = shape.copy(), momentum.copy()  # in axes that turn with the poses
        for x in (carried, pushed):
            x[place] = np.swapaxes(R, -1, -2) @ x[place]
        if shapes:
            alike = last.T @ pushed
            apart = np.log(np.maximum(omega, TINY) / np.maximum(omegas[-1], TINY)[:, None])
            order = linear_sum_assignment(-(alike**2) / (1 + apart**2))[1]  # frequencies change little in a step
            signs = np.where(alike[np.arange(len(order)), order] < 0, -1.0, 1.0)
            omega, shape, momentum, carried = omega[order], *(x[:, order] * signs for x in (shape, momentum, carried))
            assurance.append(np.minimum(alike[np.arange(len(order)), order] ** 2, 1.0))
        last = carried
        first = first if shapes else pushed
        omegas.append(omega)
        shapes.append(shape)
        momenta.append(momentum)
    assurance.append(np.minimum((last.T @ first) ** 2, 1.0).max(axis=1))
    fewest = min(map(len, omegas))  # of links of hardly any mass, the fastest are not found at every position
    shapes, momenta = ([x[:, :fewest] for x in kept] for kept in (shapes, momenta))
    omegas, assurance = ([x[:fewest] for x in kept] for kept in (omegas, assurance))
    return FollowedModes(np.array(omegas), np.array(shapes), np.array(momenta), np.array(assurance))


def _each_slowest(
    machine: Machine, times: Array, about: About | None, loose: bool, count: int, options: Mapping[str, Any]
) -> Iterator[tuple[Array, Array, sp.csr_matrix]]:
    """Give the slowest modes as `_each_held` gives all of them, by SLEPc."""
    found, n = _tangents(machine, times, about), machine.n
    for t, *both in zip(times, found.M, found.K):
        M, K = (found.pattern.matrix(x) for x in both)
        free, what = _left_by(K[n:, :n].toarray()), f"modes of the machine held at {t:.6g} s"
        mass, stiffness = (sp.csr_matrix(free.T @ (X + X.T)[:n, :n] @ free / 2) for X in (M, K))
        own, heavy = stiffness.diagonal(), mass.diagonal() > 0
        shift = loose * np.sqrt(ROUNDING) * float(np.median(own[heavy] / mass.diagonal()[heavy]))
        squares, shapes = _nearest_to_0(sp.csr_matrix(stiffness + shift * mass), mass, count, options, what)
        strain = np.einsum("im,im->m", shapes, stiffness @ shapes)
        size = np.einsum("im,im->m", np.abs(shapes), abs(stiffness) @ np.abs(shapes))
        rigid = np.abs(strain) < len(own) * ROUNDING * size
        if (rigid.any() and not loose) or (strain[~rigid] < 0).any():
            raise SolverError(f"{what}: {GIVES_WAY}")
        unit = np.where(rigid, np.einsum("im,im->m", shapes, mass @ shapes), strain)
        whole = np.zeros((machine.size, len(squares)))
        whole[:n] = free @ (shapes / np.sqrt(unit))
        yield np.where(rigid, 0.0, np.sqrt(np.maximum(squares - shift, 0.0))), whole, M[:n, :n]


def _left_by(rows: Array) -> sp.csr_matrix:
    """Give coordinates that rows ``(rows, n)`` leave, and by them all ``(n, left)``."""
    n = rows.shape[1]
    if not len(rows):
        return sp.identity(n, format="csr")
    among = np.flatnonzero(rows.any(axis=0))
    r, order = scipy.linalg.qr(rows[:, among], mode="r", pivoting=True)
    size = np.abs(np.diag(r))
    rank = int((size > 1e-10 * size.max(initial=0.0)).sum())
    by = -scipy.linalg.solve_triangular(r[:rank, :rank], r[:rank, rank:])
    left = np.setdiff1d(np.arange(n), among[order[:rank]])
    found = sp.lil_matrix((n, len(left)))
    found[left, np.arange(len(left))] = 1.0
    found[np.ix_(among[order[:rank]], np.searchsorted(left, among[order[rank:]]))] = by
    return found.tocsr()


def _nearest_to_0(
    stiffness: sp.csr_matrix, mass: sp.csr_matrix, count: int, options: Mapping[str, Any], what: str
) -> tuple[Array, Array]:
    """Give the smallest eigenvalues (1/s^2) of a stiffness and a mass, ascending, and shapes ``(n, modes)``."""
    # A Krylov space may hold fewer vectors of an eigenvalue than it has. By Sylvester's law of inertia as many are
    # below a number as K - number M has negative pivots.
    for wanted in (count, 2 * count + SPARE):
        eps, pair = SLEPc.EPS().create(comm=PETSc.COMM_SELF), [to_petsc(X) for X in (stiffness, mass)]
        eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
        eps.setDimensions(wanted)
        eps.setOperators(*pair)
        start = np.random.default_rng(0).uniform(-1, 1, mass.shape[0])
        vector = PETSc.Vec().createWithArray(start, comm=PETSc.COMM_SELF)
        with configured(eps, "modes_", SLOWEST_MODES | {"eps_ncv": 2 * wanted + SPARE}, options):
            eps.setInitialSpace(vector)
            eps.solve()
            if (found := eps.getConverged()) < wanted:
                raise SolverError(f"{what}: SLEPc has found {found} of {wanted}")
            values = np.array([eps.getEigenvalue(i).real for i in range(found)])
            order, shapes = np.argsort(values)[:wanted], []
            for i in order:
                eps.getEigenvector(int(i), vector)
                shapes.append(vector.array_r.copy())
        for thing in (*pair, vector):
            thing.destroy()  # Python by itself does not
        squares = values[order]
        bound = squares[count - 1] - 1e-6 * abs(squares[count - 1])
        factors = splu((stiffness - bound * mass).tocsc(), "MMD_AT_PLUS_A", 0.0, options={"SymmetricMode": True})
        if (factors.U.diagonal() < 0).sum() <= (squares < bound).sum():
            return squares[:count], np.array(shapes).T[:, :count]
    raise SolverError(f"{what}: SLEPc misses one of them. Ask for more modes")


def damp_modes(
    machine: Machine,
    period: float,
    ratio: float | Sequence[float],
    *,
    fastest: float = 32.0,
    positions: int = POSITIONS,
    times: Array | None = None,
) -> None:
    """Damp the slow modes of a machine by their ratios, in a cycle of its chart.

    Parameters
    ----------
    machine
        The machine; its chart is the cycle.
    period
        s.
    ratio
        Damping ratio of all modes, or of the slowest ones; the last holds for the rest.
    fastest
        Frequency below which modes are damped, over that of the slowest mode of the cycle. Faster ones follow their
        loads. Strains of slender members of five demos need 8 to be within 2e-5 of those with all modes, and those of a
        stiff crank 32 to be within 4e-5.
    positions
        Even positions of the cycle at which the modes are found: with 24 instead of 48 they are within 2e-5.
    times
        Instants at which the chart is at these positions; None for even ones from 0 (s).
    """
    times = period / positions * np.arange(positions) if times is None else times
    strains, lags = _damped(machine, times, ratio, fastest)
    machine.beams.modal = ModalDamping.of(machine.beams.stiffness, strains, lags, period)
    machine.forget_plan()


def held_damping(machine: Machine, t: float, ratio: float | Sequence[float]) -> Array:
    """Give the stress of all modes of a machine held at the place of its chart: E as of `HeldDamping`.

    Parameters
    ----------
    machine
        The machine, without damping of modes.
    t
        Instant (s).
    ratio
        As of `damp_modes`.

    Returns
    -------
    ndarray
        ``(elements, strains, modes)``.
    """
    (strain,), (lag,) = _damped(machine, np.array([t]), ratio, np.inf)
    return np.asarray(np.einsum("eij,ejk->eik", machine.beams.stiffness, strain) * np.sqrt(lag))


def _damped(
    machine: Machine, times: Array, ratio: float | Sequence[float], fastest: float
) -> tuple[list[Array], list[Array]]:
    """Give strains of the slow modes of unit energy at instants, and ``2 zeta/omega`` of each (s)."""
    term = machine.terms.index(machine.beams)
    group = machine.groups[term]
    modes = [(omega, shape) for omega, shape, _ in _each_held(machine, times)]
    zero = np.zeros((len(times), machine.size))
    measured = machine.residual(times, zero, zero, zero, moving=False, tangents=False).terms[term]
    most = fastest * min(omega[0] for omega, _ in modes)
    stated = np.atleast_1d(ratio)
    strains, lags = [], []
    for k, (omega, shapes) in enumerate(modes):
        slow = omega < most
        inside = np.clip(3 * (1 - omega[slow] / most), 0.0, 1.0)
        ratios = stated[np.minimum(np.arange(slow.sum()), len(stated) - 1)] * inside**2 * (3 - 2 * inside)
        strains.append(np.einsum("emn,ken->emk", measured.gradient[k], group.variables(shapes[:, slow].T)))
        lags.append(2 * ratios / omega[slow])
    return strains, lags
