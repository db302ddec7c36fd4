"""A mechanism that differs a little from one whose motion is known: what the known motion leaves over in its equation.

Nothing of it is assembled: the links' forces are summed in their own axes. What has to be solved for is corrected by
the factors of the known mechanism. The error of that is of second order in the difference, and alike on both sides of
the known one, so that central differences do not see it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fenics_mech._arrays import Array, times
from fenics_mech._sparse import Stack
from fenics_mech.eigenmodes import Modes
from fenics_mech.forces.elastic_response import ElasticResponse, ModalDamping, response_at
from fenics_mech.mechanism import System
from fenics_mech.mechanism.damping_factors import FullFactor
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.spin_tangents import turning_forces
from fenics_mech.response.modal_damping import through
from fenics_mech.response.mode_shapes import every, held

NEXT = 1e-3  # relative distance of squared frequencies, from which a small change does not mix their modes
State = tuple[Array, Array]  # q and q', ``(positions, coordinates)`` each
Path = tuple[Array, Array, Array]  # q, q' and q'', ``(positions, coordinates)`` each


@dataclass(frozen=True, eq=False)
class KnownModes:
    """Modes of a mechanism at its positions, by which the damping of modes changes with its matrices.

    Parameters
    ----------
    inverse
        ``1/omega``, ``(positions, modes)``.
    forces
        Elastic forces of the shapes of unit stiffness, ``(positions, modes, coordinates)``.
    shapes
        These shapes, ``(positions, modes, coordinates)``.
    """

    inverse: Array
    forces: Array
    shapes: Array

    @classmethod
    def of(cls, system: System) -> KnownModes:
        """Find all modes of a mechanism at its positions.

        Parameters
        ----------
        system
            The mechanism.
        """
        mass, stiffness = held(system)
        squares, forces, _ = every(mass, stiffness)
        return cls(np.sqrt(np.maximum(squares, 0)), forces, stiffness.solve(forces))

    def change_of_damping(self, mass: Stack, stiffness: Stack) -> Array:
        """Give the change of damping by one and the same ratio of all modes, for a ratio of 1.

        The damping is ``2 M (M^-1 K)^(1/2)``. The derivative of a square root X solves Sylvester's equation
        ``X dX + dX X = d(M^-1 K)``, which is diagonal in the modes.

        Parameters
        ----------
        mass, stiffness
            Changes of M and K at the positions.

        Returns
        -------
        numpy.ndarray
            Shape ``(positions, coordinates, coordinates)``.
        """
        back = self.shapes.transpose(0, 2, 1)
        by_mass, by_stiffness = (part.times(self.shapes) @ back for part in (mass, stiffness))
        first, second = self.inverse[:, :, None], self.inverse[:, None, :]
        total = first + second
        total[total == 0] = 1.0  # both modes have no mass, and no damping
        change = 2 * (first * second * by_stiffness + by_mass) / total
        return np.asarray(self.forces.transpose(0, 2, 1) @ change @ self.forces)


def between(change: Array, places: Array) -> Array:
    """Give matrices at places of equal steps of a closed cycle, ``(steps x places, n, n)``, as `KnownDamping` does.

    Parameters
    ----------
    change
        The matrices at the starts of the steps, ``(steps, n, n)``.
    places
        Where in every step, 0..1.
    """
    alike = {ahead: np.roll(change, -ahead, axis=0) for ahead in range(-2, 4)}
    found = [through(range(-2, 4), place, alike) for place in places]
    return np.stack(found, axis=1).reshape(-1, *change.shape[1:])


def modes_beside(modes: Modes, mass: Stack, stiffness: Stack) -> Modes | None:
    """Give the modes of a mechanism beside that of some modes, by Rayleigh's quotient; None where two are nearly one.

    Their shapes are those of the known mechanism.

    Parameters
    ----------
    modes
        Modes of the known mechanism.
    mass, stiffness
        M and K of the mechanism beside it, at the same positions.
    """
    squares = np.sort(modes.omega**2, axis=1)
    if np.any(np.diff(squares, axis=1) <= NEXT * squares[:, 1:]):
        return None
    of_mass, of_stiffness = (np.sum(modes.shapes * part.times(modes.shapes), axis=-1) for part in (mass, stiffness))
    return replace(modes, omega=np.sqrt(np.maximum(of_stiffness / of_mass, 0.0)))


@dataclass(frozen=True, eq=False)
class BesideKnown:
    """The equation of motion of a mechanism beside a known one, at the same positions.

    Parameters
    ----------
    known
        The equation of the known mechanism.
    system
        The other mechanism.
    change
        How far its damping of modes differs, ``(positions, coordinates, coordinates)``; None without such damping.
    """

    known: Equation
    system: System
    change: Array | None = None

    @cached_property
    def _plain(self) -> Equation:
        """Its equation without damping of modes."""
        return Equation(self.system)

    def residual(self, q: Array, rate: Array, second: Array) -> Array:
        """Give what a state leaves over, ``(positions, coordinates)``.

        Parameters
        ----------
        q, rate, second
            Coordinates and their first two time derivatives, ``(positions, coordinates)``.
        """
        found = residual_of_links(self._plain, q, rate, second)
        if self.change is None:
            return found
        forces, tension = self._of_modes(q, rate)
        return found + forces if tension is None else found + forces + self._on_bent_axis(tension, q)

    def tangents(self, state: State, paths: Sequence[Path]) -> list[Array]:
        """Give what small disturbances of a state add to what it leaves over, ``(positions, coordinates)`` each.

        Parameters
        ----------
        state
            q and q' of the state.
        paths
            The disturbances.
        """
        found = tangents_of_links(self._plain, state, paths)
        if self.change is None:
            return found
        return [part + added for part, added in zip(found, self._tangents_of_modes(state, paths))]

    def _tangents_of_modes(self, state: State, paths: Sequence[Path]) -> list[Array]:
        """What small disturbances add to the forces of the damping of modes, ``(positions, coordinates)`` each."""
        if (law := self.system.terms.law) is None:
            return [self._of_modes(q, rate)[0] for q, rate, _ in paths]
        (v, w), (_, tension), found = self._straining_links(*state), self._of_modes(*state), []
        assert tension is not None
        for q, rate, _ in paths:
            v_more, w_more = self._straining_links(q, rate)
            bending = np.sum(law.gradient(v_more) * w[:, law.dofs] + law.gradient(v) * w_more[:, law.dofs], axis=-1)
            forces, added = self._of_strains(q, rate, bending)
            assert added is not None
            found.append(forces + self._on_bent_axis(added, state[0]) + self._on_bent_axis(tension, q))
        return found

    def acceleration(self, q: Array, rate: Array, near: Array) -> Array:
        """Give the second derivatives that fulfil the equation, ``(positions, coordinates)``.

        Parameters
        ----------
        q, rate
            Coordinates and their rates, ``(positions, coordinates)``.
        near
            Second derivatives of the known motion, ``(positions, coordinates)``.
        """
        return near - self.known.mass_at(q).solve(self.residual(q, rate, near))

    def response(self, q: Array, rate: Array, acceleration: Array) -> ElasticResponse:
        """Give the response from its coordinates and two time derivatives.

        Parameters
        ----------
        q, rate, acceleration
            Coordinates and their derivatives, ``(positions, coordinates)``.
        """
        mass = self.known.linear.mass
        found = response_at(self._plain, q, rate, acceleration)
        if self.change is None:
            return found
        (forces, tension), system, on_bent_axis = self._of_modes(q, rate), self.system, None
        strain = system.to_links(self._strained(forces))
        if tension is not None and (law := system.terms.law) is not None:
            forces = forces + self._on_bent_axis(tension, q)
            on_bent_axis = tension[..., None] * law.on_elements.gradient(system.to_links(q))
        inertia = _corrected(mass, lambda x: self._by_links(system.link_mass, x), forces)
        return replace(found, modal_damping=ModalDamping(strain, system.to_links(inertia), on_bent_axis))

    def _of_modes(self, q: Array, rate: Array) -> tuple[Array, Array | None]:
        """Forces of the damping of modes on the coordinates, and the elements' tension that goes with them.

        See `ModalForces` and `NonlinearModalForces`, whose products they are.
        """
        if (law := self.system.terms.law) is None:
            return self._of_strains(q, rate, None)
        v, w = self._straining_links(q, rate)
        return self._of_strains(q, rate, np.sum(law.gradient(v) * w[:, law.dofs], axis=-1))

    def _straining_links(self, q: Array, rate: Array) -> tuple[Array, Array]:
        """Displacement of the links and the rate at which they strain, ``(positions, links' coordinates)`` each."""
        p, forward = self.system.values, self.system.transformation.forward
        return forward(p, q), forward(p, rate) + forward(self._plain.turned, q)

    def _of_strains(self, q: Array, rate: Array, bending: Array | None) -> tuple[Array, Array | None]:
        """Those forces and that tension, with the rate by which bending adds to the elements' elongation."""
        system, law, factor = self.system, self.system.terms.law, self.known.modal_damping
        assert isinstance(factor, FullFactor)
        assert self.change is not None
        p, transformation = system.values, system.transformation
        turned = transformation.forward(self._plain.turned, q)
        right = transformation.backward(p, _times(system.link_stiffness, turned))
        if law is not None and bending is not None:
            line = (law.rigidity * bending)[..., None] * law.stretching.line
            right += transformation.backward_at(p, law.dofs, line)
        straining = rate + self._strained(right)
        modes = np.einsum("tmn,tn->tm", factor.values, straining)
        forces = np.einsum("tmn,tm->tn", factor.values, modes) + np.einsum("tmn,tn->tm", self.change, straining)
        return forces, None if law is None else law.axial(transformation.forward(p, self._strained(forces)))

    def _on_bent_axis(self, tension: Array, q: Array) -> Array:
        """Forces of the elements' tension on the bent axis, ``(positions, coordinates)``."""
        system, law = self.system, self.system.terms.law
        assert law is not None
        gradient = law.gradient(system.transformation.forward(system.values, q))
        return system.transformation.backward_at(system.values, law.dofs, tension[..., None] * gradient)

    def _strained(self, forces: Array) -> Array:
        """Coordinates whose elastic forces these are, ``(positions, coordinates)``."""
        return _corrected(self.known.links_stiffness, lambda q: self._by_links(self.system.link_stiffness, q), forces)

    def _by_links(self, matrix: sp.csr_matrix, q: Array) -> Array:
        """``P^T matrix P q``, ``(positions, coordinates)``."""
        system, transformation = self.system, self.system.transformation
        return transformation.backward(system.values, _times(matrix, transformation.forward(system.values, q)))


def residual_of_links(equation: Equation, q: Array, rate: Array, second: Array) -> Array:
    """Give the residual of (4.66) without damping of modes, by the links' forces in their own axes.

    It is that of `Equation.residual`, and assembles nothing.

    Parameters
    ----------
    equation
        The equation of motion.
    q, rate, second
        Coordinates and their first two time derivatives, ``(positions, coordinates)``.
    """
    system, state = equation.system, equation.in_links(q, rate)
    found = _linear_of_links(equation, (q, rate, second), state) - system.load
    if (law := system.terms.law) is not None:
        found += equation.to_coordinates(law.force(*state), law.dofs)
    for forces in turning_forces(equation, (q, rate, second)):
        found += forces
    return found


def tangents_of_links(equation: Equation, state: State, paths: Sequence[Path]) -> list[Array]:
    """Give what small disturbances of a state add to that residual, ``(positions, coordinates)`` each.

    Parameters
    ----------
    equation
        The equation of motion.
    state
        q and q' of the state.
    paths
        The disturbances.
    """
    system, p = equation.system, equation.jets[0]
    about, moved = equation.in_links(*state), [equation.in_links(*path[:2]) for path in paths]
    found = [_linear_of_links(equation, path, own) for path, own in zip(paths, moved)]
    (law, forces), parts = (system.terms.law, system.rotation_forces), []
    if law is not None:
        parts.append((law.dofs, law.about(*about)[0][1:]))
    if forces is not None:
        parts.append((forces.dofs, forces.linearised(*about)[1:]))
    for dofs, (by_v, by_rate) in parts:
        for k, (v, v_rate) in enumerate(moved):
            added = times(by_v, v[:, dofs]) + times(by_rate, v_rate[:, dofs])
            found[k] += system.transformation.backward_at(p, dofs, added)
    if (spin := system.spin) is not None:
        around = equation.state_in_links(*state, equation.acceleration(*state))
        tangents = spin.linearised(*around, system.motion.alpha)[1:]
        for k, path in enumerate(paths):
            own = (part[:, spin.dofs] for part in equation.state_in_links(*path))
            forces_of_spin = np.sum([times(*both) for both in zip(tangents, own)], axis=0)
            found[k] += system.transformation.backward_at(p, spin.dofs, forces_of_spin)
    return found


def _linear_of_links(equation: Equation, path: Path, state: State) -> Array:
    """Give the linear forces of q, q' and q'', with v and v' of the links, ``(positions, coordinates)``."""
    system, terms, transformation = equation.system, equation.system.terms, equation.system.transformation
    (q, rate, second), (v, v_rate), (p, first, second_jet) = path, state, equation.jets
    inertia = transformation.forward(p, second) + terms.damping.drag * v_rate
    if first is not None and second_jet is not None:
        inertia += 2 * transformation.forward(first, rate) + transformation.forward(second_jet, q)
    forces = _times(system.link_mass, inertia) + _times(system.link_stiffness, v + terms.damping.material * v_rate)
    if equation.coupled:
        omega, alpha = (part[:, system.link_of_coordinate] for part in (system.motion.omega, system.tangential))
        forces += _times(system.link_gyroscopic, 2 * omega * v_rate + alpha * v)  # (4.29), (4.30)
        forces -= _times(system.link_mass - system.link_rotary_mass, omega**2 * v)
    for entries, by in ((system.added_stiffness, v), (terms.matrices.damping, v_rate)):
        for part in map(system.on_links, entries):
            forces += part.times(by)
    return transformation.backward(p, forces)


def _times(matrix: sp.csr_matrix, vectors: Array) -> Array:
    """``matrix vectors`` at all positions, ``(positions, links' coordinates)``."""
    return np.asarray((matrix @ vectors.T).T)


def _corrected(known: Stack, other: Callable[[Array], Array], right: Array) -> Array:
    """Solve with the matrices of the known mechanism, corrected once by those of the other, ``(positions, n)``."""
    rough = known.solve(right)
    return rough + known.solve(right - other(rough))
