"""Equation of motion of a mechanism whose drive gives way: with one more coordinate, the twist of the drive's shaft.

The links are measured against the rigid motion at the crank's own angle, psi = theta + twist. The elastic coordinates
feel psi, psi' and psi'' by their load F, so that the column of the twist holds minus the derivatives of F by them. The
row is the virtual work of all forces in the swing dX/dpsi of the linkage about its crank. With the elastic displacement
P q the swing is ``dX/dpsi + d(P q)/dpsi``: the forces of the rigid motion do work in its second part, a load stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech._sparse import Stack
from fenics_mech.effects import Entries
from fenics_mech.effects.terms import quarter_back
from fenics_mech.kinematics import Motion
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.mechanism.system import System
from fenics_mech.scene.drives import Motor


def at_rate(motion: Motion, nominal: float, rate: Array, change: Array) -> Motion:
    """Give a motion at constant rate `nominal` (rad/s) with another rate and change of it, ``(angles,)`` each.

    Parameters
    ----------
    motion
        The motion at the constant rate.
    nominal
        That rate of the drive coordinate (rad/s).
    rate, change
        The other rate (rad/s) and its time derivative (rad/s^2).
    """
    ratio, growth = rate / nominal, change / nominal
    return replace(
        motion,
        velocity=_times(ratio, motion.velocity),
        omega=_times(ratio, motion.omega),
        acceleration=_times(growth, motion.velocity) + _times(ratio**2, motion.acceleration),  # chain rule
        alpha=_times(growth, motion.omega) + _times(ratio**2, motion.alpha),
    )


def _times(factor: Array, values: Array) -> Array:
    """Multiply ``(angles, ...)`` by a factor at each angle."""
    return np.einsum("t,t...->t...", factor, values)


def _swing(system: System, unit: Motion) -> Array:
    """Displacement of all nodal dofs in link axes as the crank turns by 1 rad, ``(angles, nodal dofs)``."""
    return replace(system, motion=unit).rigid_velocity


def load_with_torque(system: System, unit: Motion) -> Array:
    """Give the load, and as its last entry the torque of loads and rigid inertia on the crank, ``(angles, n + 1)``.

    Parameters
    ----------
    system
        The mechanism.
    unit
        Its motion at a rate of 1 rad/s.
    """
    torque = -np.sum(_swing(system, unit) * _residual_forces(system), axis=1)
    return np.column_stack([system.load, torque])


def _residual_forces(system: System) -> Array:
    """Residual forces of the rigid motion, ``m a - f`` in link axes, ``(angles, nodal dofs)``."""
    return (system.nodal_mass @ system.rigid_acceleration.T).T - system.applied


@dataclass(frozen=True, kw_only=True)
class MotorEquation(Equation):
    """The equation of motion of a system with the twist as its last coordinate.

    Parameters
    ----------
    motor
        Stiffness, damping and inertia at the crank.
    unit
        The system's rigid motion when its crank turns at 1 rad/s.
    twist
        Twist that the system's motion has, and its first two time derivatives, ``(3, angles)``.
    load
        Load of the system and torque on its crank, see `load_with_torque`.
    tangents
        Their derivatives by the crank's angle, rate and acceleration, ``(3, angles, n + 1)``.
    """

    motor: Motor
    unit: Motion
    twist: Array
    load: Array
    tangents: Array

    @cached_property
    def linear(self) -> Matrices:
        """The equation linearised about the twist; its load makes it hold for the whole coordinates."""
        plain, rows = Equation(self.system, self.modal_damping).linear, self._rows()
        motor = self.motor.stiffness, self.motor.damping, self.motor.inertia
        blocks = plain.stiffness, plain.damping, plain.mass
        stiffness, damping, mass = (
            _bordered(block, row, -tangent, constant)
            for block, row, tangent, constant in zip(blocks, rows, self.tangents, motor)
        )
        modal = None if plain.modal is None else plain.modal.widened(1)  # the twist strains nothing
        load = self.load - np.einsum("iak,ia->ak", self.tangents, self.twist)
        return Matrices(mass, damping, stiffness, load, modal)

    def to_coordinates(self, forces: Array, dofs: Index) -> Array:
        """Carry forces on the links' coordinates to the mechanism's; they do no work in the twist."""
        return np.pad(super().to_coordinates(forces, dofs), ((0, 0), (0, 1)))

    def _rows(self) -> tuple[Array, Array, Array]:
        """Torques on the crank of q, q' and q'', ``(angles, n)`` each.

        With the swing ``x = dX/dpsi``, the residual forces ``r = m a - f`` of the rigid motion, the damping D and the
        stiffness S of what acts on the links in link axes, and the angles phi of the links::

            q:    x^T (m P'' + (2 m_v + D) P' + (m_a + S) P) + r^T (dP/dpsi + dphi/dpsi Q P)
            q':   x^T (2 m P' + (2 m_v + D) P)
            q'':  x^T m P

        with m_v and m_a of (4.29) and (4.30), and the quarter turn Q that the rotation of its link gives to ``P q``.
        The links' own stiffness and their material's damping do no work in x, which strains nothing.
        """
        system, terms, link = self.system, self.system.terms, self.system.link_of_dof
        transformation, motion = system.transformation, system.motion
        field, residual, matrices = _swing(system, self.unit), _residual_forces(system), terms.matrices
        omega, alpha = motion.omega[:, link], system.tangential[:, link]
        s, centrifugal = system.nodal_gyroscopic.T, (system.nodal_mass - system.nodal_rotary_mass).T
        momentum = (system.nodal_mass.T @ field.T).T  # x^T m
        drag = terms.damping.drag * momentum + _times_transposed(matrices.damping, field)  # x^T D
        turning = 2 * (s @ (omega * field).T).T + drag  # x^T (2 m_v + D)
        held = (s @ (alpha * field).T - centrifugal @ (omega**2 * field).T).T  # x^T m_a
        held += _times_transposed((*matrices.stiffness, *matrices.follower, *matrices.convective), field)  # x^T S
        turned = quarter_back(system.applied, (len(omega), -1, 3))
        carried = (s @ system.rigid_acceleration.T).T - turned  # r^T Q: of m a by the form s
        held += self.unit.omega[:, link] * carried  # P q turns with its link
        first, second = transformation.derivatives(motion)
        by_angle = transformation.derivatives(self.unit)[0]  # dP/dpsi: at 1 rad/s it is P'
        work = system.on_coordinates
        stiffness = work(momentum, second) + work(turning, first) + work(held) + work(residual, by_angle)
        damping = 2 * work(momentum, first) + work(turning)
        return stiffness, damping, work(momentum)


def _times_transposed(added: tuple[Entries, ...], vectors: Array) -> Array:
    """Sum of the transposed matrices times vectors, ``(angles, nodal dofs)``."""
    total = np.zeros_like(vectors)
    for entries in added:
        total += Entries(entries.columns, entries.rows, entries.values).times(vectors)
    return total


def _bordered(block: Stack, row: Array, column: Array, constant: float) -> Stack:
    """Matrices with one more row and column; the constant adds to the corner."""
    pattern, last, every = block.pattern.widened(1), np.full(block.size, block.size), np.arange(block.size)
    values = block.on(pattern).values
    values[:, pattern.places(last, every)] = row
    values[:, pattern.places(np.arange(block.size + 1), np.append(last, block.size))] = column
    values[:, -1] += constant
    return Stack(pattern, values)
