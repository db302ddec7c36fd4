"""The matrices of a linear equation of motion at many drive angles, ``M q'' + C q' + K q + modal damping = f``."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import eigh
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from fenics_mech._arrays import Array, Index
from fenics_mech._guard import ADVICE
from fenics_mech._sparse import Stack
from fenics_mech.errors import SolverError
from fenics_mech.mechanism.modal_forces import MATRICES, ModalForces

if TYPE_CHECKING:
    from fenics_mech.effects.nonlinear_law import Prediction


@dataclass(frozen=True)
class Matrices:
    """``M q'' + C q' + K q + modal damping = f``.

    Parameters
    ----------
    mass, damping, stiffness
        M, C and K at all angles.
    load
        f, ``(angles, coordinates)``, or of several loads ``(angles, coordinates, loads)``.
    modal
        Damping of modes, where there is some.
    near
        Axial forces of the elements near the state that a nonlinear law is linearised about.
    """

    mass: Stack
    damping: Stack
    stiffness: Stack
    load: Array
    modal: ModalForces | None = None
    near: Prediction | None = None

    @classmethod
    def of_full(cls, mass: Array, damping: Array, stiffness: Array, load: Array) -> Matrices:
        """Take M, C and K that are given as a whole, ``(angles, coordinates, coordinates)`` each.

        Parameters
        ----------
        mass, damping, stiffness
            M, C and K, ``(angles, coordinates, coordinates)``.
        load
            f, ``(angles, coordinates)``, or of several loads ``(angles, coordinates, loads)``.
        """
        return cls(Stack.of_full(mass), Stack.of_full(damping), Stack.of_full(stiffness), load)

    def left(self, q: Array, rate: Array, second: Array) -> Array:
        """Give the left side of the equation for q, q' and q'', ``(angles, coordinates)`` each.

        Parameters
        ----------
        q, rate, second
            Coordinates and their first two time derivatives, ``(angles, coordinates)``.
        """
        found = self.mass.times(second) + self.damping.times(rate) + self.stiffness.times(q)
        return found if self.modal is None else found + self.modal.of(q, rate)

    @property
    def full(self) -> tuple[Array, Array, Array]:
        """M, C and K with the modal damping in them, ``(angles, coordinates, coordinates)``: for few coordinates."""
        return self.mass.full, self.whole_damping.full, self.whole_stiffness.full

    def damped(self, rates: Array) -> Array:
        """Give the forces of damping, those of modes among them, ``(angles, vectors, coordinates)``, of several q'.

        Parameters
        ----------
        rates
            Several q' at each angle, ``(angles, vectors, coordinates)``.
        """
        found = self.damping.times(rates)
        return found if self.modal is None else found + self.modal.damped(rates)

    def damped_at(self, position: int, rates: Array) -> Array:
        """Give the forces of damping, those of modes among them, at one angle, ``(coordinates, vectors)``.

        Parameters
        ----------
        position
            Number of the angle.
        rates
            Several q', ``(coordinates, vectors)``.
        """
        found = np.asarray(self.damping.at(position) @ rates)
        return found if self.modal is None else found + self.modal.damped_at(position, rates)

    @cached_property
    def whole_damping(self) -> Stack:
        """C with the damping of modes."""
        return self.damping if self.modal is None else self.damping + self.modal.damping

    @cached_property
    def whole_stiffness(self) -> Stack:
        """K with what the damping of modes adds."""
        return self.stiffness if self.modal is None else self.stiffness + self.modal.stiffness

    @cached_property
    def growth(self) -> float:
        """Bound of the rate at which a motion grows that does not turn (1/s); 0 where the stiffness is positive.

        Such a motion ``x exp(rate t)`` has ``(rate^2 M + rate C + K) x = 0``. The leading minors of this matrix are all
        positive at rates beyond its own. Where C = 0 and K is symmetric, the bound is the rate (Sylvester).
        """
        among = looked_at(not_positive(self.stiffness), self.mass.size)
        if not len(among):
            return 0.0
        mass, damping, stiffness = (part[among] for part in (self.mass, self.damping, self.stiffness))

        def beyond(rate: float) -> bool:
            try:
                return bool(((mass * rate**2 + damping * rate + stiffness).factors.pivots > 0).all())
            except SolverError:
                return False

        fastest = MATRICES.rate_ratio * float(np.sqrt(np.abs(stiffness.values).max() / np.abs(mass.values).max()))
        lower, higher = (fastest * MATRICES.rate_ratio ** (sign * np.arange(MATRICES.rates)) for sign in (-1, 1))
        below = next((float(rate) for rate in lower if not beyond(rate)), 0.0)
        above = below * MATRICES.rate_ratio
        if below == fastest:  # light coordinates may grow faster than heavy ones; without mass there is no bound
            above = next((float(rate) for rate in higher[1:] if beyond(rate)), above)
            below = above / MATRICES.rate_ratio
        while above > (1 + MATRICES.rate_error) * below:
            middle = math.sqrt(above * below)
            above, below = (middle, below) if beyond(middle) else (above, middle)
        return above

    @cached_property
    def loss(self) -> float:
        """Least loss factor of the modes at the first angle, twice a damping ratio; 0 where there are no modes.

        Of many coordinates the slow modes are looked at. Where few modes are damped, it is those up to half the
        frequency of the fastest: the others do not vibrate.
        """
        size, modal = self.mass.size, self.modal
        if len(not_positive(self.stiffness[:1])):
            return 0.0
        count = size if size <= MATRICES.many else MATRICES.many // 3
        if modal is not None and modal.in_own_unknowns:
            count = min(count, modal.count)
        mass, stiffness = self.mass.symmetric.at(0), self.stiffness.symmetric.at(0)
        if count < size / 3:  # 1 over omega^2, and Phi^T K Phi = 1
            inverse = LinearOperator(mass.shape, splu(stiffness.tocsc()).solve, dtype=float)
            squares, shapes = eigsh(mass, count, stiffness, Minv=inverse, which="LA", v0=np.ones(size))
        else:
            squares, shapes = eigh(mass.toarray(), stiffness.toarray(), subset_by_index=(size - count, size - 1))
        moves = squares > np.finfo(float).eps * squares[-1]
        if modal is not None and modal.in_own_unknowns:
            moves &= squares >= min(4 * squares[0], squares[-1])
        work = np.einsum("im,im->m", shapes, self.damped_at(0, shapes))[moves]
        return max(0.0, float((work / np.sqrt(squares[moves])).min(initial=np.inf)))


def looked_at(angles: Index, size: int) -> Index:
    """Angles whose eigenvalues are looked at: all of them, or few where there are many coordinates.

    Parameters
    ----------
    angles
        Numbers of the angles in question.
    size
        Number of coordinates.
    """
    return angles if size <= MATRICES.many else angles[:: max(1, -(-len(angles) // MATRICES.angles))]


def not_positive(stiffness: Stack) -> Index:
    """Angles at which the symmetric part of a matrix is not positive, by the signs of its pivots (Sylvester).

    Parameters
    ----------
    stiffness
        The matrices at all angles.
    """
    try:
        positive = (stiffness.symmetric.factors.pivots > 0).all(axis=1)
    except SolverError:
        positive = np.array([np.linalg.eigvalsh(stiffness.symmetric.dense(k))[0] > 0 for k in range(len(stiffness))])
    return np.flatnonzero(~positive)


def refuse_rigid_damping(matrices: Matrices, step: float) -> None:
    """Raise `SolverError` where a damper is as good as rigid: in a sum with it, all else would be lost to rounding.

    The damping is compared with inertia and stiffness, coordinate by coordinate, over a step of time (s).

    Parameters
    ----------
    matrices
        M, C and K at all angles.
    step
        Duration of a step (s).
    """
    parts = matrices.mass, matrices.damping, matrices.stiffness
    mass, damping, stiffness = (np.abs(part.diagonal) for part in parts)
    if matrices.modal is not None and matrices.modal.seen is None:  # else only slow modes are damped
        damping = damping + np.abs(matrices.modal.diagonal)
    ratio = float((step * damping / (mass + step**2 * stiffness)).max())
    if not ratio < MATRICES.rigid_damping:
        raise SolverError(
            f"the damping is {ratio:.1e} times the inertia and stiffness that it acts against in a sub-interval: "
            f"rounding would spoil the answer. {ADVICE}"
        )
