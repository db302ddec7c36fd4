"""Forces of modal damping at many drive angles, by the rates at which the modes strain the links."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fenics_mech._arrays import Array, Index, summed
from fenics_mech._sparse import ProductPairs, Stack
from fenics_mech.effects.nonlinear_law import ArcLength
from fenics_mech.mechanism.transformation import Transformation


@dataclass(frozen=True)
class MatrixLimits:
    """How matrices over the coordinates are looked at, and stored."""

    few_modes: float = 0.9  # of the coordinates, up to which modes are kept as products of their shapes
    many: int = 300  # coordinates, above which growth is looked for at few angles
    angles: int = 8  # at which it is looked for then
    rate_ratio: float = 1.5  # of rates of growth that are tried, one after the other
    rates: int = 40  # of these, from the fastest of all: slower growth is rounding
    rate_error: float = 0.01  # relative
    rigid_damping: float = 1e10  # ratio to the stiffness; measured: 1e-3 of the strains are lost at 1e10, 1e-1 at 1e12


MATRICES = MatrixLimits()


@dataclass(frozen=True, eq=False)
class ModalForces:
    """Linear forces ``Z^T F^T y`` that go with the modes' rates ``y = G Z q' + H Z q``.

    Parameters
    ----------
    outward, by_rate, by_place
        F, G and H, ``(angles, modes, seen)`` each. G is F where time is not scaled.
    seen
        Z, what the modes see of the coordinates, ``(seen, coordinates)``; without it all of them.
    """

    outward: Array
    by_rate: Array
    by_place: Array
    seen: sp.csr_matrix | None = None

    def _seen(self, vectors: Array) -> Array:
        """``Z vectors``, ``(..., coordinates)`` to ``(..., seen)``."""
        return vectors if self.seen is None else _times(self.seen, vectors)

    def _spread(self, forces: Array) -> Array:
        """``Z^T forces``, ``(..., seen)`` to ``(..., coordinates)``."""
        return forces if self.seen is None else _times(self.seen.T, forces)

    @property
    def spread(self) -> ModalForces:
        """The same over all coordinates: for few of them, or few modes."""
        return self if self.seen is None else self._over_all  # kept in itself, it would outlive its use

    @cached_property
    def _over_all(self) -> ModalForces:
        """The same over all coordinates, where the modes do not see all of them."""
        return ModalForces(*map(self._spread, (self.outward, self.by_rate, self.by_place)))

    @property
    def count(self) -> int:
        """Number of modes."""
        return self.outward.shape[1]

    def rates(self, q: Array, rate: Array) -> Array:
        """Give y of q and q', ``(angles, modes)``.

        Parameters
        ----------
        q, rate
            Coordinates and their time derivatives, ``(angles, coordinates)``.
        """
        by_rate = np.einsum("tmn,tn->tm", self.by_rate, self._seen(rate))
        return by_rate + np.einsum("tmn,tn->tm", self.by_place, self._seen(q))

    def forces(self, rates: Array) -> Array:
        """Give the forces on the coordinates, ``(angles, coordinates)``, of y.

        Parameters
        ----------
        rates
            The modes' rates y, ``(angles, modes)``.
        """
        return self._spread(np.einsum("tmn,tm->tn", self.outward, rates))

    def of(self, q: Array, rate: Array) -> Array:
        """Give the forces on the coordinates, ``(angles, coordinates)``, of q and q'.

        Parameters
        ----------
        q, rate
            Coordinates and their time derivatives, ``(angles, coordinates)``.
        """
        return self.forces(self.rates(q, rate))

    def damped(self, rates: Array) -> Array:
        """Give the forces of several q' at each angle, ``(angles, vectors, coordinates)``.

        Parameters
        ----------
        rates
            Several q' at each angle, ``(angles, vectors, coordinates)``.
        """
        return self._spread(self._seen(rates) @ self.by_rate.transpose(0, 2, 1) @ self.outward)

    @property
    def in_own_unknowns(self) -> bool:
        """Whether the modes are so few that unknowns of their own are cheaper than full matrices."""
        return self.seen is not None or self.count < MATRICES.few_modes * self.outward.shape[2]

    def damped_at(self, position: int, rates: Array) -> Array:
        """Give the forces at one angle of several q', ``(coordinates, vectors)`` both.

        Parameters
        ----------
        position
            Number of the angle.
        rates
            Several q', ``(coordinates, vectors)``.
        """
        seen = rates if self.seen is None else self.seen @ rates
        forces = self.outward[position].T @ (self.by_rate[position] @ seen)
        return forces if self.seen is None else np.asarray(self.seen.T @ forces)

    @property
    def diagonal(self) -> Array:
        """Diagonals of ``F^T G``, ``(angles, coordinates)``, where the modes see all of them."""
        return np.sum(self.outward * self.by_rate, axis=1)

    @cached_property
    def damping(self) -> Stack:
        """Full matrices ``F^T G``."""
        return Stack.of_full(self.spread.outward.transpose(0, 2, 1) @ self.spread.by_rate)

    @cached_property
    def stiffness(self) -> Stack:
        """Full matrices ``F^T H``."""
        return Stack.of_full(self.spread.outward.transpose(0, 2, 1) @ self.spread.by_place)

    def at_rate(self, rate: float) -> ModalForces:
        """Give the same at another rate of the drive (rad/s), where this is that at 1 rad/s: H is in proportion to it.

        Parameters
        ----------
        rate
            The rate (rad/s).
        """
        found = replace(self, by_place=rate * self.by_place)
        if not self.in_own_unknowns:  # those are taken without full matrices
            vars(found).update(damping=self.damping, stiffness=rate * self.stiffness)
        return found

    def widened(self, more: int) -> ModalForces:
        """Give the same with further coordinates, which strain nothing.

        Parameters
        ----------
        more
            Number of further coordinates.
        """
        if self.seen is not None:
            wider_still = sp.hstack([self.seen, sp.csr_matrix((self.seen.shape[0], more))], format="csr")
            return replace(self, seen=wider_still)
        wider = (np.pad(part, ((0, 0), (0, 0), (0, more))) for part in (self.outward, self.by_rate, self.by_place))
        return ModalForces(*wider)

    def paced(self, pace: float) -> ModalForces:
        """Give the same where q' is in units of a pace (1/s).

        Parameters
        ----------
        pace
            The pace (1/s): q' is the pace times what is given.
        """
        return replace(self, by_rate=pace * self.by_rate)


def _times(matrix: sp.spmatrix, vectors: Array) -> Array:
    """A constant matrix times the last axis of vectors, ``(..., n)``."""
    return np.ascontiguousarray((matrix @ vectors.reshape(-1, vectors.shape[-1]).T).T).reshape(*vectors.shape[:-1], -1)


@dataclass(frozen=True, eq=False)
class NonlinearModalForces:
    """Modal damping of links whose strain is nonlinear: y holds the rates of the whole strain.

    With the elements' axial forces N in the modes' stress, ``y = F q' + H q + N s`` with the rate s of what bending
    adds to the elements' elongation. On the linear strain alone damping would brake the bending: an axis that bends
    freely shortens without stress.

    Parameters
    ----------
    linear
        F and H.
    axial
        N, ``(angles, modes, elements)`` (N per unit of force).
    law
        The elements.
    transformation, jets
        P and P' of the angles, as nonzeros.
    """

    linear: ModalForces
    axial: Array
    law: ArcLength
    transformation: Transformation
    jets: tuple[Array, Array]

    @property
    def _size(self) -> int:
        """Number of coordinates."""
        linear = self.linear
        return int(linear.outward.shape[2] if linear.seen is None else linear.seen.shape[1])

    def _links(self, q: Array, rate: Array) -> tuple[Array, Array]:
        """Give v, and the rate at which the links strain, ``(angles, links' coordinates)`` each."""
        (p, turned), forward = self.jets, self.transformation.forward
        return forward(p, q), forward(p, rate) + forward(turned, q)

    def _bending(self, gradient: Array, v_rate: Array) -> Array:
        """Give ``N s``, ``(angles, modes)``, with the gradient of what bending adds to the elements' elongation."""
        return np.einsum("tms,ts->tm", self.axial, np.sum(gradient * v_rate[:, self.law.dofs], axis=-1))

    def rates(self, q: Array, rate: Array) -> Array:
        """Give y of q and q', ``(angles, modes)``.

        Parameters are those of `ModalForces.rates`.
        """
        v, v_rate = self._links(q, rate)
        return self.linear.rates(q, rate) + self._bending(self.law.gradient(v), v_rate)

    def tension(self, rates: Array) -> Array:
        """Give the axial force of each element that goes with y (N), ``(angles, elements)``.

        Parameters
        ----------
        rates
            The modes' rates y, ``(angles, modes)``.
        """
        return np.einsum("tms,tm->ts", self.axial, rates)

    def on_bent_axis(self, rates: Array, q: Array) -> Array:
        """Give the forces of the elements' tension on the bent axis, ``(angles, coordinates)``, of y and q.

        Parameters
        ----------
        rates
            The modes' rates y, ``(angles, modes)``.
        q
            Coordinates, ``(angles, coordinates)``.
        """
        v = self.transformation.forward(self.jets[0], q)
        return self._on_coordinates(self.tension(rates)[..., None] * self.law.gradient(v))

    def of(self, q: Array, rate: Array) -> Array:
        """Give the forces on the coordinates, ``(angles, coordinates)``, of q and q'.

        Parameters are those of `ModalForces.of`.
        """
        rates = self.rates(q, rate)
        return self.linear.forces(rates) + self.on_bent_axis(rates, q)

    def linearised(self, q: Array, rate: Array) -> tuple[ModalForces, Array, Array]:
        """Linearise about a state.

        Parameters
        ----------
        q, rate
            Coordinates and their time derivatives, ``(angles, coordinates)``.

        Returns
        -------
        tuple
            The linear forces, the elements' tension that adds to their stiffness (N), ``(angles, elements)``, and the
            load with which they are exact at the state, ``(angles, coordinates)``.
        """
        (p, turned), (v, v_rate) = self.jets, self._links(q, rate)
        gradient = self.law.gradient(v)
        bending = self._bending(gradient, v_rate)
        tension = self.tension(self.linear.rates(q, rate) + bending)
        outward = self.linear.spread.outward + self._by_mode((p, gradient))
        by_place = self._by_mode((turned, gradient), (p, self.law.gradient(v_rate)))
        forces = ModalForces(outward, outward, self.linear.spread.by_place + by_place)
        return forces, tension, forces.forces(bending) + self._on_coordinates(tension[..., None] * gradient)

    @cached_property
    def _carrying(self) -> tuple[Index, Index, Index, ProductPairs]:
        """Forces on elements and nonzeros of P that meet, the place of their product, and the places that N meets."""
        rows, columns, size = self.transformation.rows, self.transformation.columns, self._size
        force, nonzero = np.nonzero(self.law.dofs.ravel()[:, None] == rows)
        element = force // self.law.dofs.shape[1]
        places, place = np.unique(element * size + columns[nonzero], return_inverse=True)
        mode = np.arange(self.axial.shape[1])[:, None]
        met = mode * len(self.law.dofs) + places // size, np.arange(len(places)), mode * size + places % size
        return force, nonzero, place, ProductPairs.of(*(part.ravel() for part in np.broadcast_arrays(*met)))

    def _by_mode(self, *parts: tuple[Array, Array]) -> Array:
        """Sum N times forces on the elements that P or P' carries to the coordinates, ``(angles, modes, coordinates)``.

        The parts are nonzeros of P or P', and forces ``(angles, elements, n)``.
        """
        force, nonzero, place, pairs = self._carrying
        products = np.zeros((len(self.axial), len(force)))
        for jet, forces in parts:
            products += forces.reshape(len(forces), -1)[:, force] * jet[:, nonzero]
        found = np.zeros((*self.axial.shape[:2], self._size))
        axial = self.axial.reshape(len(found), -1)
        pairs.add(axial, summed(products, place, int(place.max()) + 1), found.reshape(len(found), -1))
        return found

    def _on_coordinates(self, forces: Array) -> Array:
        """Carry forces on the elements, ``(angles, elements, n)``, to the coordinates."""
        found = self.transformation.backward_at(self.jets[0], self.law.dofs, forces)
        return np.pad(found, ((0, 0), (0, self._size - found.shape[1])))  # a twist strains nothing
