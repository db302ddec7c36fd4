"""Forces of modal damping at many drive angles, by the rates at which the modes strain the links."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array, summed
from fenics_mech._sparse import Stack
from fenics_mech.effects.terms import Law
from fenics_mech.mechanism.transformation import Transformation


@dataclass(frozen=True, eq=False)
class ModalForces:
    """Linear forces ``F^T y`` that go with the modes' rates ``y = G q' + H q``.

    Parameters
    ----------
    outward, by_rate, by_place
        F, G and H, ``(angles, modes, coordinates)`` each. G is F where time is not scaled.
    """

    outward: Array
    by_rate: Array
    by_place: Array

    def rates(self, q: Array, rate: Array) -> Array:
        """Give y of q and q', ``(angles, modes)``."""
        return np.einsum("tmn,tn->tm", self.by_rate, rate) + np.einsum("tmn,tn->tm", self.by_place, q)

    def forces(self, rates: Array) -> Array:
        """Give the forces on the coordinates, ``(angles, coordinates)``, of y."""
        return np.einsum("tmn,tm->tn", self.outward, rates)

    def of(self, q: Array, rate: Array) -> Array:
        """Give the forces on the coordinates, ``(angles, coordinates)``, of q and q'."""
        return self.forces(self.rates(q, rate))

    @cached_property
    def damping(self) -> Stack:
        """Full matrices ``F^T G``."""
        return Stack.of_full(self.outward.transpose(0, 2, 1) @ self.by_rate)

    @cached_property
    def stiffness(self) -> Stack:
        """Full matrices ``F^T H``."""
        return Stack.of_full(self.outward.transpose(0, 2, 1) @ self.by_place)

    def widened(self, more: int) -> ModalForces:
        """Give the same with further coordinates, which strain nothing."""
        wider = (np.pad(part, ((0, 0), (0, 0), (0, more))) for part in (self.outward, self.by_rate, self.by_place))
        return ModalForces(*wider)

    def paced(self, pace: float) -> ModalForces:
        """Give the same where q' is in units of a pace (1/s)."""
        return replace(self, by_rate=pace * self.by_rate)


@dataclass(frozen=True, eq=False)
class NonlinearModalForces:
    """Modal damping of links whose strain is nonlinear: y holds the rates of the whole strain.

    With the strings' axial forces N in the modes' stress, ``y = F q' + H q + N s`` with the rate s of what bending adds
    to the strings' elongation. On the linear strain alone damping would brake the bending: an axis that bends freely
    shortens without stress.

    Parameters
    ----------
    linear
        F and H.
    axial
        N, ``(angles, modes, strings)`` (N per unit of force).
    law
        The strings.
    transformation, jets
        P and P' of the angles, as nonzeros.
    """

    linear: ModalForces
    axial: Array
    law: Law
    transformation: Transformation
    jets: tuple[Array, Array]

    def _links(self, q: Array, rate: Array) -> tuple[Array, Array]:
        """Give v, and the rate at which the links strain, ``(angles, links' coordinates)`` each."""
        (p, turned), forward = self.jets, self.transformation.forward
        return forward(p, q), forward(p, rate) + forward(turned, q)

    def _bending(self, v: Array, v_rate: Array) -> Array:
        """Give ``N s``, ``(angles, modes)``."""
        added = np.sum(self.law.gradient(v) * v_rate[:, self.law.dofs], axis=-1)
        return np.einsum("tms,ts->tm", self.axial, added)

    def rates(self, q: Array, rate: Array) -> Array:
        """Give y of q and q', ``(angles, modes)``."""
        return self.linear.rates(q, rate) + self._bending(*self._links(q, rate))

    def tension(self, rates: Array) -> Array:
        """Give the axial force of each string that goes with y (N), ``(angles, strings)``."""
        return np.einsum("tms,tm->ts", self.axial, rates)

    def of(self, q: Array, rate: Array) -> Array:
        """Give the forces on the coordinates, ``(angles, coordinates)``, of q and q'."""
        rates, gradient = self.rates(q, rate), self.law.gradient(self._links(q, rate)[0])
        return self.linear.forces(rates) + self._on_coordinates(self.tension(rates)[..., None] * gradient)

    def linearised(self, q: Array, rate: Array) -> tuple[ModalForces, Array, Array]:
        """Linearise about a state.

        Returns
        -------
        tuple
            The linear forces, the strings' tension that adds to their stiffness (N), ``(angles, strings)``, and the
            load with which they are exact at the state, ``(angles, coordinates)``.
        """
        v, v_rate = self._links(q, rate)
        bending, rates = self._bending(v, v_rate), self.rates(q, rate)
        (p, turned), tension, gradient = self.jets, self.tension(rates), self.law.gradient(v)
        outward = self.linear.outward + self.axial @ self._each(p, gradient)
        by_place = self.axial @ (self._each(turned, gradient) + self._each(p, self.law.gradient(v_rate)))
        forces = ModalForces(outward, outward, self.linear.by_place + by_place)
        return forces, tension, forces.forces(bending) + self._on_coordinates(tension[..., None] * gradient)

    def _each(self, jet: Array, forces: Array) -> Array:
        """Carry forces ``(angles, strings, n)``, each string by itself, to ``(angles, strings, coordinates)``."""
        strings, height = len(self.law.dofs), self.transformation.shape[0]
        place = (self.law.dofs + height * np.arange(strings)[:, None]).ravel()
        whole = summed(forces.reshape(len(forces), -1), place, strings * height).reshape(-1, strings, height)
        return self.transformation.backward(jet[:, None], whole)

    def _on_coordinates(self, forces: Array) -> Array:
        """Carry forces on the strings, ``(angles, strings, n)``, to the coordinates."""
        whole = summed(forces.reshape(len(forces), -1), self.law.dofs.ravel(), self.transformation.shape[0])
        return self.transformation.backward(self.jets[0], whole)
