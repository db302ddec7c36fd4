"""The law of elements whose axes turn far: bending does not change the length of an axis, an even stretch does."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array, Index, each, times
from fenics_mech.effects.even_stretch import EVEN, Bars, Strained, Stretched
from fenics_mech.effects.stretch_tangents import Linearised

if TYPE_CHECKING:
    from fenics_mech.beams.bent_axis import BentAxis
    from fenics_mech.beams.nonlinear_stretching import Stretching
    from fenics_mech.effects.section_spin import SectionSpin


@dataclass(frozen=True)
class Prediction:
    """Force of each element along its straight line, linearised about a state.

    Parameters
    ----------
    law
        The law of the elements.
    y, rate
        Their own numbers and the rates of these at the state, ``(angles, elements, 5)``.
    pull, by_y, by_rate
        The force (N), ``(angles, elements)``, and its derivatives by both, ``(angles, elements, 5)``.
    by_stretch
        Derivatives by the stretch, of the forces on y, ``(angles, elements, 5)``, and of this force (N).
    """

    law: ArcLength
    y: Array
    rate: Array
    pull: Array
    by_y: Array
    by_rate: Array | None
    by_stretch: tuple[Array, Array]

    def at(self, v: Array, rate: Array) -> Array:
        """Give the force at another state (N), ``(angles, elements)``.

        Parameters
        ----------
        v, rate
            Displacement and velocity of the links' coordinates, ``(angles, links' coordinates)`` each.
        """
        found = self.pull + np.einsum("...i,...i->...", self.by_y, self.law.own(v) - self.y)
        if self.by_rate is not None:
            found += np.einsum("...i,...i->...", self.by_rate, self.law.own(rate) - self.rate)
        return np.asarray(found)


@dataclass(frozen=True)
class ArcLength:
    """Elements with an even stretch lambda, and the curvature ``w''/sqrt(lambda^2 - w'^2)`` of the bent axis.

    Derivatives are along the axis before it is stretched, so that ``w'/lambda`` is the sine of its rotation, and the
    mean of ``u' + 1`` is that of ``sqrt(lambda^2 - w'^2)``. As the stretch is even, a bent element does not lock.
    Rotations of nodes are these sines, which elements with other stretches share.
    Source: Reissner, J. Appl. Math. Phys. 23 (1972) 795, for strains of bending and stretch alone.

    Its methods take the displacement v and the velocity v' of the links' coordinates, and give what adds to the linear
    elastic forces. Newton's method takes each element's tension as an unknown of its own, beside v. It then needs few
    steps and no small ones: a tension that is computed from a bending not yet right is a bad guess, as members are
    stiff along their axes. So is a stretch, which is therefore the one that the held tension gives. By how much the
    elongation needs another one counts to its first order, and is 0 in the end.
    Source: Magisano, Leonetti and Garcea, Int. J. Numer. Meth. Engng 109 (2017) 1237.

    Parameters
    ----------
    axis
        Shortening and bending of the elements.
    stretching
        Elongation of each element for small rotations, whose rate modal damping acts on.
    dofs
        The links' coordinates of each, ``(elements, n)``: nodal dofs, or where links are reduced what moves these.
    rigidity, length
        EA over the length (N/m), and the length (m), ``(elements,)`` each.
    material
        Retardation time: the tension is ``EA (strain + material * rate of strain)`` (s), and so is the moment. The rate
        is that of the whole strain: on the linear part alone it would damp bending away, as u' follows the shortening.
    of_nodes
        The same by the nodal dofs, where the links are reduced.
    spin
        Inertia of the sections beyond that of linear theory; None where they have none.
    """

    axis: BentAxis
    stretching: Stretching
    dofs: Index
    rigidity: Array
    length: Array
    material: float
    of_nodes: ArcLength | None = None
    spin: SectionSpin | None = None

    @property
    def on_elements(self) -> ArcLength:
        """The same by the nodal dofs."""
        return self.of_nodes or self

    def tension(self, v: Array, rate: Array) -> Array:
        """Mean force of each element along its straight line (N), ``(angles, elements)``."""
        state = self._strained(self.own(v), self.own(rate))
        return np.asarray(state.whole / (state.of.fold * self.length))

    def stretch(self, v: Array) -> Array:
        """Length of each element's axis over that before, ``(angles, elements)``."""
        return Stretched.of(self.own(v), self._bars).stretch

    def shapes(self, jets: list[Array]) -> tuple[list[Array], list[Array]]:
        """Give stretch and shape of each element, ``(angles, elements)`` and ``(angles, elements, 4)``.

        Parameters
        ----------
        jets
            Displacement of the links' coordinates, alone or with its two time derivatives, which the answer then has.
        """
        own = [self.own(v) for v in jets]
        found = Stretched.of(own[0], self._bars)
        return found.in_time(own[1], own[2], self._bars) if len(own) > 1 else ([found.stretch], [found.shape])

    def force(self, v: Array, rate: Array) -> Array:
        """Forces of stretch and bending less their linear parts, ``(angles, elements, n)``."""
        y, y_rate = self.own(v), self.own(rate)
        linear = each(self._linear, y + self.material * y_rate)
        return each(self._back, self._strained(y, y_rate).force - linear)

    def whole_force(self, v: Array, rate: Array) -> Array:
        """Forces of stretch and bending with their linear parts, ``(angles, elements, n)``."""
        return each(self._back, self._strained(self.own(v), self.own(rate)).force)

    def shortening(self, v: Array, stretch: Array) -> Array:
        """By how much each element's straight line is shorter than its stretched axis (m), ``(angles, elements)``."""
        return np.asarray(self.length * (stretch - 1) - np.sum(self.stretching.line * v[:, self.dofs], axis=-1))

    def energy(self, v: Array) -> Array:
        """Strain energy less that of linear theory (J), ``(angles, elements)``."""
        y = self.own(v)
        of = Stretched.of(y, self._bars)
        whole = self.rigidity * (self.length * of.strain) ** 2 / 2 + self.axis.energy(of.shape)
        return np.asarray(whole - np.sum(y * each(self._linear, y), axis=-1) / 2)

    def about(
        self, v: Array, rate: Array, tension: Array | None = None
    ) -> tuple[tuple[Array, Array, Array], Prediction]:
        """Linearise about v, v' and a tension.

        Parameters
        ----------
        v, rate
            Displacement and velocity of the links' coordinates, ``(angles, links' coordinates)`` each.
        tension
            Mean force of each element along its straight line (N), ``(angles, elements)``; None for that of v and v'.

        Returns
        -------
        tuple
            The force ``constant + by_v v + by_rate v'`` as a constant, ``(angles, elements, n)``, and two matrices,
            ``(angles, elements, n, n)``; and the tension near the state.
        """
        y, y_rate = self.own(v), self.own(rate)
        found = Linearised.about(self._strained(y, y_rate, tension), y_rate, self._bars, tension)
        by_stretch = found.by_stretch, found.pull_by_stretch
        near = Prediction(self, y, y_rate, found.pull, found.pull_by_y, found.pull_by_rate, by_stretch)
        by_v = self._on_dofs(found.by_y - self._linear)
        # products of these matrices, whose rounding leaves alone what does not strain
        constant = each(self._back, found.force - each(self._linear, y)) - times(by_v, v[:, self.dofs])
        if found.by_rate is None:
            return (constant, by_v, np.zeros_like(by_v)), near
        by_rate = self._on_dofs(found.by_rate - self.material * self._linear)
        constant -= each(self._back, each(self.material * self._linear, y_rate)) + times(by_rate, rate[:, self.dofs])
        return (constant, by_v, by_rate), near

    def force_near(self, v: Array, rate: Array, tension: Array, near: Prediction) -> tuple[Array, Prediction]:
        """Give the forces of `force` with a held tension, and the tension near them, by the tangents of another state.

        The stretch that belongs to the held tension differs from that of v. The difference counts by those tangents,
        as they give the next elongation: the stiffness along the axis would magnify any other.

        Parameters
        ----------
        v, rate, tension
            As of `about`.
        near
            What `about` gave of a state beside it.
        """
        y, y_rate = self.own(v), self.own(rate)
        state = Strained.held(tension, y, y_rate, self._bars, EVEN.tolerance)
        force_by_stretch, pull_by_stretch = near.by_stretch
        linear = each(self._linear, y + self.material * y_rate)
        found = each(self._back, state.force + force_by_stretch * state.of.beyond[..., None] - linear)
        held = state.whole / (state.of.fold * self.length) + pull_by_stretch * state.of.beyond
        return found, replace(near, y=y, rate=y_rate, pull=held)

    def axial(self, v: Array) -> Array:
        """Axial force of each element by the linear strain (N), ``(angles, ..., elements)`` of ``(angles, ..., v)``."""
        return self.rigidity * np.sum(self.stretching.line * v[..., self.dofs], axis=-1)

    def gradient(self, v: Array) -> Array:
        """Gradient of what bending adds to each element's elongation, to its first order, ``(angles, elements, n)``."""
        return each(self.stretching.bow, v[:, self.dofs])

    @property
    def bow(self) -> Array:
        """Second derivative of each element's elongation where it is straight (1/m ...), ``(elements, n, n)``."""
        return self.stretching.bow

    @cached_property
    def _basis(self) -> Array:
        """Elongation of the straight line, and dofs of w, by the dofs of each element, ``(elements, 5, n)``."""
        return np.concatenate([self.stretching.line[:, None, :], self.axis.whole], axis=1)

    @property
    def _back(self) -> Array:
        return self._basis.transpose(0, 2, 1)

    @cached_property
    def _both(self) -> Array:
        basis = self._basis
        return np.einsum("ebi,ecj->eijbc", basis, basis).reshape(len(basis), -1, basis.shape[1] ** 2)

    @cached_property
    def _linear(self) -> Array:
        """Stiffness of linear theory by the elongation and w, ``(elements, 5, 5)``."""
        found = np.zeros((len(self.rigidity), 5, 5))
        found[:, 0, 0], found[:, 1:, 1:] = self.rigidity, self.axis.linear
        return found

    @cached_property
    def _bars(self) -> Bars:
        return Bars(self.axis, self.rigidity * self.length, self.length, self.material)

    def own(self, v: Array) -> Array:
        """Elongation of the straight line and dofs of w of each element, ``(angles, elements, 5)``."""
        return each(self._basis, v[:, self.dofs])

    def _on_dofs(self, matrices: Array) -> Array:
        """Carry matrices by the elongation and w to the elements' dofs, ``(angles, elements, n, n)``."""
        n = self._basis.shape[-1]
        return each(self._both, matrices.reshape(*matrices.shape[:2], -1)).reshape(*matrices.shape[:2], n, n)

    def _strained(self, y: Array, rate: Array, tension: Array | None = None) -> Strained:
        """Give what the forces are made of; no numbers where an axis turns by 90 degrees."""
        if tension is not None:
            return Strained.held(tension, y, rate, self._bars)
        return Strained.by(Stretched.of(y, self._bars), rate, self._bars)
