"""The whole equation of motion (4.66) at many drive angles at once, as sparse matrices over the coordinates q.

In link axes the elastic displacement is ``v = P q``, its velocity ``v' = P q' + P' q``, its acceleration
``v'' = P q'' + 2 P' q' + P'' q``. The links' forces in their own axes, carried back by P^T, give the equation. Without
the coupling of rigid and elastic motion P counts as constant, (5.1).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fenics_mech._arrays import Array, Index
from fenics_mech._sparse import Congruence, Stack
from fenics_mech._sparse.pattern import Pattern
from fenics_mech.effects import Entries
from fenics_mech.effects.nonlinear_law import ArcLength
from fenics_mech.errors import SolverError
from fenics_mech.mechanism.damping_factors import DampingFactor
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.mechanism.modal_forces import ModalForces, NonlinearModalForces
from fenics_mech.mechanism.spin_tangents import mass_with_spin, places_of, turning_forces, with_spin
from fenics_mech.mechanism.system import System

States = tuple[Array, Array, Array]  # coordinates and their first two time derivatives


@dataclass(frozen=True)
class Equation:
    """The equation of motion of a system, its linear part assembled once.

    Parameters
    ----------
    system
        The mechanism at the angles.
    modal_damping
        Factor F of the modes' damping ``F^T F``.
    """

    system: System
    modal_damping: DampingFactor | None = None

    @cached_property
    def jets(self) -> tuple[Array, Array | None, Array | None]:
        """Nonzeros of P, P' and P'' at all angles, ``(angles, nonzeros)``; the last two None without coupling."""
        if not self.coupled:
            return self.system.values, None, None
        return (self.system.values, *self.system.transformation.derivatives(self.system.motion))

    @cached_property
    def turned(self) -> Array:
        """Nonzeros of P' at all angles, ``(angles, nonzeros)``, with coupling or without."""
        first = self.jets[1]
        return self.system.transformation.derivatives(self.system.motion)[0] if first is None else first

    @property
    def coupled(self) -> bool:
        """Whether the coupling of rigid and elastic motion counts."""
        return self.system.terms.coupled

    @cached_property
    def _congruence(self) -> Congruence:
        """From matrices over the links' coordinates to those over q."""
        system, transformation = self.system, self.system.transformation
        constant = [system.link_mass, system.link_stiffness]
        if self.coupled:
            constant += [system.link_gyroscopic, system.link_rotary_mass]
        places = [tuple(part.astype(np.int64) for part in matrix.nonzero()) for matrix in constant]
        added = map(system.on_links, (*system.added_stiffness, *system.terms.matrices.damping))
        places += [(entries.rows, entries.columns) for entries in added]
        return Congruence.of(
            *transformation.shape, transformation.rows, transformation.columns, [*places, *self._nonlinear_places]
        )

    @property
    def pattern(self) -> Pattern:
        """Where the matrices have numbers."""
        return self._congruence.pattern

    @property
    def _nonlinear_places(self) -> list[tuple[Index, Index]]:
        """Places of the tangents of what is nonlinear, over the links' coordinates."""
        parts = self.system.terms.law, self.system.rotation_forces, self.system.spin
        return [places_of(part.dofs) for part in parts if part is not None]

    @cached_property
    def linear(self) -> Matrices:
        """The linear part."""
        mass, damping, stiffness = self._assembled()
        return Matrices(mass, damping, stiffness, self.system.load, self._modal)

    def _assembled(self) -> tuple[Stack, Stack, Stack]:
        """M, C and K of the links at all angles."""
        system, products = self.system, self._congruence
        p, first, second = self.jets
        m = products.values_of_matrix(system.link_mass)
        k = self._with(system.link_stiffness, system.added_stiffness)
        d = self._link_damping()
        mass = products.products(p, (m, p))
        if first is None or second is None:
            return mass, products.products(p, (d, p)), products.products(p, (k, p))
        link = system.link_of_coordinate[products.link_rows]
        omega, alpha = (np.take(rate, link, axis=1) for rate in (system.motion.omega, system.tangential))  # by rows
        s = products.values_of_matrix(system.link_gyroscopic)
        m_v = omega * s  # (4.29)
        m_a = alpha * s - omega**2 * (m - products.values_of_matrix(system.link_rotary_mass))  # (4.30)
        damping = products.products(p, (d + 2 * m_v, p), (2 * m, first))  # (4.52), (4.53)
        stiffness = products.products(p, (k + m_a, p), (2 * m_v + d, first), (m, second))  # (4.49)-(4.51)
        return mass, damping, stiffness

    @cached_property
    def _modal(self) -> ModalForces | None:
        """Damping of modes: their rate is that of straining, ``q' + (P^T k P)^-1 P^T k P' q``.

        q' alone also holds the turning of the fixed frame against the links, and would damp a link that turns with a
        strain that does not change.
        """
        return None if self.modal_damping is None else self.modal_damping.forces(self, self.modal_strain)

    @cached_property
    def modal_strain(self) -> Array:
        """Coordinates whose elastic forces are those of each mode, of the links or of links by few."""
        assert self.modal_damping is not None
        return self.modal_damping.strained(self)

    @cached_property
    def modal(self) -> ModalForces | NonlinearModalForces | None:
        """Forces of modal damping, of the whole strain."""
        law, damping = self.system.terms.law, self.modal_damping
        if damping is None:  # then nothing has to be assembled
            return None
        linear = self.linear.modal
        if law is None or linear is None:
            return linear
        axial = damping.axial(self, self.modal_strain, law)
        return NonlinearModalForces(linear, axial, law, self.system.transformation, (self.jets[0], self.turned))

    def linearised(
        self, q: Array, rate: Array, tension: Array | None, share: float = 1.0, second: Array | None = None
    ) -> Matrices:
        """Linearise about a state: the tangents, and the load with which they are exact at that state.

        Parameters
        ----------
        q, rate
            Coordinates and their time derivatives, ``(angles, coordinates)``.
        tension
            Axial force of each element that goes with them, where the law is nonlinear (N), ``(angles, elements)``.
            None for that of their strains.
        share
            Of the loads, under a nonlinear law.
        second
            Second time derivatives of the coordinates, where they are known: what sections need as axes turn far.
        """
        law = self.system.terms.law
        if law is None:
            return self.linear
        found = self._with_modes(self._linearised(law, self.in_links(q, rate), tension, share), q, rate)
        return with_spin(self, found, (q, rate, np.zeros_like(q) if second is None else second))

    def about(self, q: Array, rate: Array, second: Array | None = None) -> Matrices:
        """Linearise about a motion, with the axial forces that its strains give.

        Parameters
        ----------
        q, rate, second
            Coordinates and their time derivatives, ``(angles, coordinates)``; q'' by the equation itself where it is
            not given.

        Returns
        -------
        Matrices
            The tangents; those of the linear part where the links have no nonlinear law.
        """
        law = self.system.terms.law
        if law is None:
            return self.linear
        found = self._with_modes(self._linearised(law, self.in_links(q, rate), None), q, rate)
        if self.system.spin is None:
            return found
        return with_spin(self, found, (q, rate, self.acceleration(q, rate) if second is None else second))

    def mass_at(self, q: Array) -> Stack:
        """M about coordinates q, ``(angles, coordinates)``: with large slopes that of the sections depends on them.

        Parameters
        ----------
        q
            Coordinates, ``(angles, coordinates)``.
        """
        return mass_with_spin(self, q)

    def _with_modes(self, tangents: Matrices, q: Array, rate: Array) -> Matrices:
        """Give the tangents with those of modal damping."""
        if not isinstance(self.modal, NonlinearModalForces):
            return tangents
        modal, tension, load = self.modal.linearised(q, rate)
        blocks = tension[..., None, None] * self.modal.law.bow
        stiffness = tangents.stiffness + self._tangents(self.modal.law.dofs, blocks, np.zeros(1))[1]
        return replace(tangents, stiffness=stiffness, load=tangents.load + load, modal=modal)

    def _linearised(
        self, law: ArcLength, state: tuple[Array, Array], tension: Array | None, share: float = 1.0
    ) -> Matrices:
        """Linearise about v and v' of the links, and the tension of their elements."""
        mesh, forces = self.system.beams.mesh, self.system.rotation_forces
        linearised, near = law.about(*state, tension)
        linear = replace(self.linear, load=share * self.linear.load, near=near)
        found = self._added(
            linear, law.dofs, linearised, lambda i: f"axis of member {mesh.members[mesh.cell_member[i]]}"
        )
        if forces is None:
            return found
        nodal = np.concatenate([part.dofs for part in self.system.terms.rotation_forces])
        exact = forces.scaled(share).linearised(*state)
        return self._added(found, forces.dofs, exact, lambda i: f"axis at {mesh.node_name[nodal[i, 0] // 3]}")

    def _added(
        self, matrices: Matrices, dofs: Index, linearised: tuple[Array, Array, Array], name: Callable[[int], str]
    ) -> Matrices:
        """Add forces on the links' coordinates `dofs`; `name` says where one is that has no value.

        Raises
        ------
        SolverError
            Where an axis turns so far that there are no forces.
        """
        constant, *tangents = linearised
        if not np.isfinite(constant).all():
            k, place, _ = np.argwhere(~np.isfinite(constant))[0]
            raise SolverError(self.system.turned_too_far(k, name(place)))
        damping, stiffness = self._tangents(dofs, *tangents)
        if damping is not None:
            matrices = replace(matrices, damping=matrices.damping + damping.on(matrices.damping.pattern))
        return replace(
            matrices,
            stiffness=matrices.stiffness + stiffness.on(matrices.stiffness.pattern),
            load=matrices.load - self.to_coordinates(constant, dofs),
        )

    def straight(self, tension: Array) -> Matrices:
        """Linearise about straight links at rest under axial forces (N), ``(angles, elements)``.

        Parameters
        ----------
        tension
            Axial force of each element (N), ``(angles, elements)``.
        """
        still = np.zeros((len(tension), self.system.size))
        return self.linearised(still, still, tension)

    @cached_property
    def of_law(self) -> Congruence:
        """From the tangents of what is nonlinear to matrices over q."""
        transformation = self.system.transformation
        return Congruence.of(*transformation.shape, transformation.rows, transformation.columns, self._nonlinear_places)

    def _tangents(self, dofs: Index, by_v: Array, by_rate: Array) -> tuple[Stack | None, Stack]:
        """Damping and stiffness from tangents over the links' coordinates `dofs`; no damping where there is none."""
        products, (p, first, _), places = self.of_law, self.jets, places_of(dofs)
        k = products.values_of(*places, by_v.reshape(len(p), -1))
        if not by_rate.any():
            return None, products.products(p, (k, p))
        d = products.values_of(*places, by_rate.reshape(len(p), -1))
        moved = () if first is None else ((d, first),)
        return products.products(p, (d, p)), products.products(p, (k, p), *moved)

    def predicted_tension(self, tangents: Matrices, q: Array, rate: Array) -> Array:
        """Axial force of each element at a new state near that of the tangents (N), ``(angles, elements)``.

        Parameters
        ----------
        tangents
            What `linearised` gave.
        q, rate
            Coordinates and their time derivatives at the new state, ``(angles, coordinates)``.
        """
        assert tangents.near is not None
        return tangents.near.at(*self.in_links(q, rate))

    def residual(self, q: Array, rate: Array, second: Array) -> Array:
        """Residual ``M q'' + C q' + K q + law - f`` of the equation of motion (4.66), ``(angles, coordinates)``.

        Parameters
        ----------
        q, rate, second
            Coordinates and their first two time derivatives, ``(angles, coordinates)``.
        """
        law = self.system.terms.law
        return self._left_over((q, rate, second), None if law is None else law.force(*self.in_links(q, rate)))

    def residual_near(self, tangents: Matrices, state: States, tension: Array, share: float) -> tuple[Array, Matrices]:
        """Give the residual of a state with held axial forces, and the same tangents with the axial forces near it.

        Parameters
        ----------
        tangents
            What `linearised` gave of the state beside it.
        state
            Coordinates and their first two time derivatives, ``(angles, coordinates)`` each.
        tension, share
            As of `linearised`.
        """
        assert tangents.near is not None
        forces, near = tangents.near.law.force_near(*self.in_links(*state[:2]), tension, tangents.near)
        return self._left_over(state, forces, share), replace(tangents, near=near)

    def _left_over(self, state: States, of_law: Array | None, share: float = 1.0) -> Array:
        """Residual of a state with forces of the law, ``(angles, elements, n)``, under a share of the load."""
        (q, rate, second), system, linear = state, self.system, replace(self.linear, modal=None)
        found = linear.left(q, rate, second) - share * linear.load
        if (law := system.terms.law) is not None and of_law is not None:
            found += self.to_coordinates(of_law, law.dofs)
        for forces in turning_forces(self, state, share):
            found += forces
        return found if self.modal is None else found + self.modal.of(q, rate)

    @cached_property
    def links_stiffness(self) -> Stack:
        """Stiffness of the links alone, ``P^T k P``: without springs, axial forces and coupling."""
        p, k = self.system.values, self._congruence.values_of_matrix(self.system.link_stiffness)
        return self._congruence.products(p, (k, p))

    @property
    def links_turning(self) -> Stack:
        """Elastic forces as the links turn, ``P^T k P'``."""
        return self.links_turning_by(self.turned)

    def links_turning_by(self, turned: Array) -> Stack:
        """Give elastic forces as the links turn, by the nonzeros of P', ``(angles, nonzeros)``."""
        k = self._congruence.values_of_matrix(self.system.link_stiffness)
        return self._congruence.products(self.system.values, (k, turned))

    def to_coordinates(self, forces: Array, dofs: Index) -> Array:
        """Carry forces on the links' coordinates `dofs`, ``(angles, elements, n)``, to those of the mechanism."""
        return self.system.transformation.backward_at(self.jets[0], dofs, forces)

    def in_links(self, q: Array, rate: Array) -> tuple[Array, Array]:
        """Displacement v and its velocity v' over the links' coordinates, each ``(angles, links' coordinates)``.

        Parameters
        ----------
        q, rate
            Coordinates and their time derivatives, ``(angles, coordinates)``.
        """
        (p, first, _), forward = self.jets, self.system.transformation.forward
        v_rate = forward(p, rate)
        return forward(p, q), v_rate if first is None else v_rate + forward(first, q)

    def state_in_links(self, q: Array, rate: Array, second: Array) -> States:
        """Displacement v over the links' coordinates and its first two time derivatives, as `in_links`.

        Parameters
        ----------
        q, rate, second
            Coordinates and their first two time derivatives, ``(angles, coordinates)``.
        """
        (p, first, second_jet), forward = self.jets, self.system.transformation.forward
        found = forward(p, second)
        if first is not None and second_jet is not None:
            found += 2 * forward(first, rate) + forward(second_jet, q)
        return (*self.in_links(q, rate), found)

    def acceleration(self, q: Array, rate: Array) -> Array:
        """Second derivative of the coordinates at a state, ``(angles, coordinates)``.

        Parameters
        ----------
        q, rate
            Coordinates and their time derivatives, ``(angles, coordinates)``.
        """
        return self.mass_at(q).solve(-self.residual(q, rate, np.zeros_like(q)))

    def _link_damping(self) -> Array:
        """Damping in link axes: by the material, by the surroundings, by dampers; nonzeros of link matrices."""
        terms = self.system.terms
        constant = terms.damping.material * self.system.link_stiffness + terms.damping.drag * self.system.link_mass
        return self._with(constant, terms.matrices.damping)

    def _with(self, constant: sp.csr_matrix, added: tuple[Entries, ...]) -> Array:
        """Nonzeros of a constant matrix and entries of effects, ``(angles or 1, nonzeros)``."""
        found = self._congruence.values_of_matrix(constant)
        for entries in map(self.system.on_links, added):
            found = found + self._congruence.values_of(entries.rows, entries.columns, entries.values)
        return found
