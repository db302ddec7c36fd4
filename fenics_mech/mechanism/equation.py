"""The whole equation of motion (4.66) at many drive angles at once, as dense matrices over the coordinates q.

In link axes the elastic displacement is ``v = P q``, its velocity ``v' = P q' + P' q``, its acceleration
``v'' = P q'' + 2 P' q' + P'' q``. The links' forces in their own axes, carried back by P^T, give the equation. Without
the coupling of rigid and elastic motion P counts as constant, (5.1).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.linalg import eigh

from fenics_mech._arrays import Array, Index, summed, times
from fenics_mech._guard import ADVICE, require_memory
from fenics_mech._ranks import over_positions
from fenics_mech.effects import Entries
from fenics_mech.effects.terms import Law
from fenics_mech.errors import SolverError, TooLargeError
from fenics_mech.mechanism.system import System

DENSE = 44  # matrices of a position that a solver holds at a time: measured, 43 with the factors of its cycle
RIGID_DAMPING = 1e10  # measured: 1e-3 of the strains are lost at 1e10, 1e-1 at 1e12
MOST_COORDINATES = 1500  # beyond it the dense matrices of a cycle take more memory than a workstation has


@dataclass(frozen=True)
class Matrices:
    """``M q'' + C q' + K q = f``: three of ``(angles, coordinates, coordinates)`` and ``(angles, coordinates)``."""

    mass: Array
    damping: Array
    stiffness: Array
    load: Array

    @property
    def weakest(self) -> int | None:
        """Angle with the smallest eigenvalue of the stiffness' symmetric part, if it is not positive."""
        symmetric = self.stiffness + self.stiffness.transpose(0, 2, 1)
        try:
            np.linalg.cholesky(symmetric)
        except np.linalg.LinAlgError:
            return int(np.linalg.eigvalsh(symmetric)[:, 0].argmin())
        return None

    @property
    def growth(self) -> float:
        """Largest rate at which a motion without vibration grows (1/s), where the stiffness is not positive; else 0."""
        if self.weakest is None:
            return 0.0
        squares = np.linalg.eigvals(np.linalg.solve(self.mass, self.stiffness)).real
        return float(np.sqrt(max(0.0, -squares.min())))

    @property
    def loss(self) -> float:
        """Least loss factor of the modes at the first angle, twice a damping ratio; 0 where there are no modes."""
        stiffness = self.stiffness[0] + self.stiffness[0].T
        try:
            squares, shapes = eigh(self.mass[0] + self.mass[0].T, stiffness)  # 1 over omega^2, and Phi^T 2K Phi = 1
        except np.linalg.LinAlgError:
            return 0.0
        moves = squares > np.finfo(float).eps * squares[-1]
        work = 2 * np.einsum("im,ij,jm->m", shapes, self.damping[0], shapes)[moves]
        return max(0.0, float((work / np.sqrt(squares[moves])).min(initial=np.inf)))


@dataclass(frozen=True)
class Equation:
    """The equation of motion of a system, its linear part assembled once.

    Parameters
    ----------
    system
        The mechanism at the angles.
    extra_damping
        Damping over the coordinates q, ``(angles, coordinates, coordinates)``: that of modal ratios.
    """

    system: System
    extra_damping: Array | None = None

    def __post_init__(self) -> None:
        """Refuse what is too large to be dense."""
        require_dense(self.system.size, len(self.system.values))

    @cached_property
    def shape(self) -> tuple[Array, Array | None, Array | None]:
        """P, P' and P'' at all angles, ``(angles, links' coordinates, coordinates)``; the last two None when off."""
        transformation = self.system.transformation
        values = [self.system.values, *(transformation.derivatives(self.system.motion) if self.coupled else ())]
        full = np.zeros((len(values), len(values[0]), *transformation.shape))
        full[:, :, transformation.rows, transformation.columns] = np.stack(values)
        return (full[0], full[1], full[2]) if self.coupled else (full[0], None, None)

    def _shape_at(self, among: slice) -> tuple[Array, Array | None, Array | None]:
        """P, P' and P'' at some of the angles."""
        p, *rates = self.shape
        first, second = (None if rate is None else rate[among] for rate in rates)
        return p[among], first, second

    @property
    def coupled(self) -> bool:
        """Whether the coupling of rigid and elastic motion counts."""
        return self.system.terms.coupled

    @cached_property
    def linear(self) -> Matrices:
        """The linear part."""
        drift = None if self.extra_damping is None else self.drift
        count = len(self.system.values)
        mass, damping, stiffness = over_positions(count, lambda among: self._linear_at(among, drift))
        return Matrices(mass, damping, stiffness, self.system.load)

    def _linear_at(self, among: slice, drift: Array | None) -> tuple[Array, Array, Array]:
        """M, C and K at some of the angles."""
        p, first, second = self._shape_at(among)
        m, d = self.system.link_mass, self._link_damping(among)
        k = self._with(self.system.link_stiffness, self.system.added_stiffness, among)
        mass, damping, stiffness = _product(m, p), _product(d, p), _product(k, p)
        if first is not None and second is not None:
            omega, alpha = (rate[among] for rate in (self.system.motion.omega, self.system.tangential))
            m_v = self._scaled(self.system.link_gyroscopic, omega)  # (4.29)
            m_a = self._scaled(self.system.link_gyroscopic, alpha)  # (4.30)
            m_a = m_a - self._scaled(m - self.system.link_rotary_mass, omega**2)
            damping = damping + 2 * _product(m, first) + 2 * _product(m_v, p)  # (4.52), (4.53)
            stiffness = stiffness + _product(m, second) + 2 * _product(m_v, first) + _product(m_a, p)  # (4.49)-(4.51)
            stiffness = stiffness + _product(d, first)
        back = p.transpose(0, 2, 1)
        damping = back @ damping
        stiffness = back @ stiffness
        if self.extra_damping is not None and drift is not None:
            damping = damping + self.extra_damping[among]
            stiffness = stiffness + self.extra_damping[among] @ drift[among]
        return back @ mass, damping, stiffness

    def linearised(self, q: Array, rate: Array, tension: Array) -> Matrices:
        """Linearise about a state: the tangents, and the load with which they are exact at that state.

        Parameters
        ----------
        q, rate
            Coordinates and their time derivatives, ``(angles, coordinates)``.
        tension
            Axial force of each string of the nonlinear law that goes with them (N), ``(angles, strings)``.
        """
        law = self.system.terms.law
        return self.linear if law is None else self._linearised(law, self.in_links(q, rate), tension)

    def about(self, q: Array, rate: Array) -> Matrices:
        """Linearise about a motion, with the axial forces that its strains give.

        Parameters
        ----------
        q, rate
            Coordinates and their time derivatives, ``(angles, coordinates)``.

        Returns
        -------
        Matrices
            The tangents; those of the linear part where the links have no nonlinear law.
        """
        law = self.system.terms.law
        if law is None:
            return self.linear
        state = self.in_links(q, rate)
        return self._linearised(law, state, law.tension(*state))

    def _linearised(self, law: Law, state: tuple[Array, Array], tension: Array) -> Matrices:
        """Linearise about v and v' of the links, and the tension of their strings."""
        linear, (constant, *tangents) = self.linear, law.linearised(*state, tension)
        damping, stiffness = over_positions(len(tension), lambda among: self._tangents_at(among, law.dofs, *tangents))
        return Matrices(
            mass=linear.mass,
            damping=linear.damping + damping,
            stiffness=linear.stiffness + stiffness,
            load=linear.load - self._to_coordinates(constant, law.dofs),
        )

    def straight(self, tension: Array) -> Matrices:
        """Linearise about straight links at rest under axial forces (N), ``(angles, strings)``."""
        still = np.zeros((len(tension), self.system.size))
        return self.linearised(still, still, tension)

    def _tangents_at(self, among: slice, dofs: Index, by_v: Array, by_rate: Array) -> tuple[Array, Array]:
        """Damping and stiffness at some of the angles of strings on `dofs`, from theirs in link axes."""
        p, first, _ = self._shape_at(among)
        back, size = p.transpose(0, 2, 1), p.shape[1]
        stiffness = Entries.of_blocks(dofs, by_v[among]).dense(size) @ p
        if not by_rate.any():
            return np.zeros((len(p), 1, 1)), back @ stiffness
        of_rate = Entries.of_blocks(dofs, by_rate[among]).dense(size)
        if first is not None:
            stiffness += of_rate @ first
        return back @ (of_rate @ p), back @ stiffness

    def predicted_tension(self, q: Array, rate: Array, new_q: Array, new_rate: Array) -> Array:
        """Tension at a new state by the strain linearised about the old one.

        Parameters
        ----------
        q, rate
            Coordinates and their time derivatives at the old state, ``(angles, coordinates)``.
        new_q, new_rate
            The same at the new one.

        Returns
        -------
        numpy.ndarray
            Axial force of each string (N), ``(angles, strings)``.
        """
        law = self.system.terms.law
        assert law is not None
        return law.predicted(*self.in_links(q, rate), *self.in_links(new_q, new_rate))

    def residual(self, q: Array, rate: Array, second: Array) -> Array:
        """Residual ``M q'' + C q' + K q + law - f`` of the equation of motion (4.66), ``(angles, coordinates)``.

        Parameters
        ----------
        q, rate, second
            Coordinates and their first two time derivatives, ``(angles, coordinates)``.
        """
        linear, law = self.linear, self.system.terms.law
        found = times(linear.mass, second) + times(linear.damping, rate) + times(linear.stiffness, q) - linear.load
        return found if law is None else found + self._to_coordinates(law.force(*self.in_links(q, rate)), law.dofs)

    def straining(self, q: Array, rate: Array) -> Array:
        """Rate of the coordinates that strains the links as they are strained, ``(angles, coordinates)``.

        It is ``q' + drift q``. Modal damping goes with it: q' alone also holds the turning of the fixed frame against
        the links, and would damp a link that turns with a strain that does not change.
        """
        return rate + times(self.drift, q)

    @cached_property
    def drift(self) -> Array:
        """How coordinates that stand still strain the links as these turn, ``P^T k P drift = P^T k P'`` (1/s)."""
        return over_positions(len(self.system.values), lambda among: (self._drift_at(among),))[0]

    def _drift_at(self, among: slice) -> Array:
        p, first, _ = self._shape_at(among)
        if first is None:
            first, transformation = np.zeros_like(p), self.system.transformation
            rates = transformation.derivatives(self.system.motion.part(among))[0]
            first[:, transformation.rows, transformation.columns] = rates
        along = p.transpose(0, 2, 1) @ _product(self.system.link_stiffness, first)
        return np.asarray(np.linalg.solve(self.links_stiffness[among], along))

    @cached_property
    def links_stiffness(self) -> Array:
        """Stiffness of the links alone, ``P^T k P``: without springs, axial forces and coupling."""
        p = self.shape[0]
        return p.transpose(0, 2, 1) @ _product(self.system.link_stiffness, p)

    def _to_coordinates(self, forces: Array, dofs: Index) -> Array:
        """Carry forces on the links' coordinates `dofs`, ``(angles, strings, n)``, to the mechanism's."""
        p = self.shape[0]
        whole = summed(forces.reshape(len(forces), -1), dofs.ravel(), p.shape[1])
        return (whole[:, None] @ p)[:, 0]

    def in_links(self, q: Array, rate: Array) -> tuple[Array, Array]:
        """Displacement v and its velocity v' over the links' coordinates, each ``(angles, links' coordinates)``."""
        p, first, _ = self.shape
        v_rate = times(p, rate)
        return times(p, q), v_rate if first is None else v_rate + times(first, q)

    def acceleration(self, q: Array, rate: Array) -> Array:
        """Second derivative of the coordinates at a state, ``(angles, coordinates)``."""
        residual = self.residual(q, rate, np.zeros_like(q))
        return np.linalg.solve(self.linear.mass, -residual[..., None])[..., 0]

    def _link_damping(self, among: slice) -> sp.csr_matrix | Array:
        """Damping in link axes: by the material, by the surroundings, by dampers."""
        terms = self.system.terms
        constant = terms.damping.material * self.system.link_stiffness + terms.damping.drag * self.system.link_mass
        return self._with(constant, terms.matrices.damping, among)

    def _with(self, constant: sp.csr_matrix, added: tuple[Entries, ...], among: slice) -> sp.csr_matrix | Array:
        """Give a constant matrix, or with entries of effects a dense one at some of the angles."""
        if not added:
            return constant
        parts = (self.system.on_links(entries.part(among)) for entries in added)
        return constant.toarray() + sum(entries.dense(constant.shape[0]) for entries in parts)

    def _scaled(self, matrix: sp.csr_matrix, by_link: Array) -> sp.csr_matrix | Array:
        """Scale the rows of each link by a factor that changes with the angle, ``(angles, links)``."""
        rows = by_link[:, self.system.link_of_coordinate]
        return rows[..., None] * matrix.toarray()


def require_dense(size: int, positions: int) -> None:
    """Raise `TooLargeError` where dense matrices of so many coordinates at so many positions are too large."""
    if size > MOST_COORDINATES:
        raise TooLargeError(
            f"{size} degrees of freedom are too many for this solver, which takes {MOST_COORDINATES}",
            hint="Take fewer elements",
        )
    what = f"the matrices of {positions} positions with {size} degrees of freedom"
    require_memory(DENSE * positions * size**2, what, "Take fewer sub_intervals or elements")


def refuse_rigid_damping(matrices: Matrices, step: float) -> None:
    """Raise `SolverError` where a damper is as good as rigid: in a sum with it, all else would be lost to rounding.

    The damping is compared with inertia and stiffness, coordinate by coordinate, over a step of time (s).
    """
    mass, damping, stiffness = (
        np.abs(np.diagonal(matrix, axis1=1, axis2=2))
        for matrix in (matrices.mass, matrices.damping, matrices.stiffness)
    )
    ratio = float((step * damping / (mass + step**2 * stiffness)).max())
    if not ratio < RIGID_DAMPING:
        raise SolverError(
            f"the damping is {ratio:.1e} times the inertia and stiffness that it acts against in a sub-interval: "
            f"rounding would spoil the answer. {ADVICE}"
        )


def held_matrices(system: System, among: slice = slice(None)) -> tuple[Array, Array]:
    """Mass and symmetric stiffness, held at some of the angles: two of ``(angles, coordinates, coordinates)``."""
    values = system.values[among]
    p = np.zeros((len(values), *system.transformation.shape))
    p[:, system.transformation.rows, system.transformation.columns] = values
    stiffness: sp.csr_matrix | Array = system.link_stiffness
    if system.symmetric_stiffness:
        parts = (system.on_links(entries.part(among)) for entries in system.symmetric_stiffness)
        added = (entries.dense(p.shape[1]) for entries in parts)
        stiffness = system.link_stiffness.toarray() + sum(added)
    back = p.transpose(0, 2, 1)
    return back @ _product(system.link_mass, p), back @ _product(stiffness, p)


def _product(matrix: sp.csr_matrix | Array, columns: Array) -> Array:
    """Product of a matrix, constant or at all angles, with ``(angles, nodal dofs, coordinates)``."""
    if isinstance(matrix, np.ndarray):
        return matrix @ columns
    angles, rows, size = columns.shape
    flat = columns.transpose(1, 0, 2).reshape(rows, -1)
    return np.asarray(matrix @ flat).reshape(-1, angles, size).transpose(1, 0, 2)
