"""Rates and accelerations of the bent mechanism, and the power of its inertia."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.kinematics import Motion
from fenics_mech.mechanism import System


@dataclass(frozen=True)
class Rates:
    """Rates, true or virtual, of the bent mechanism in link axes.

    Parameters
    ----------
    motion
        The rigid motion with these rates.
    rigid
        Velocity of the nodal dofs by it, ``(angles, nodal dofs)``.
    turning
        Angular velocity of the link of each nodal dof (rad/s), ``(angles, nodal dofs)``.
    deformation
        Rate of the elastic displacement v, ``(angles, nodal dofs)``.
    """

    motion: Motion
    rigid: Array
    turning: Array
    deformation: Array

    @classmethod
    def of(cls, system: System, motion: Motion, deformation: Array) -> Rates:
        """Give the rates of a motion of the same positions as that of the system.

        Parameters
        ----------
        system
            The mechanism.
        motion
            The rigid motion.
        deformation
            Rate of the elastic displacement v in link axes, ``(angles, nodal dofs)``.
        """
        moved = System(system.beams, motion, system.transformation)
        return cls(motion, moved.rigid_velocity, motion.omega[:, system.link_of_dof], deformation)


@dataclass(frozen=True)
class Acceleration:
    """Acceleration of the links' points: of nodal dofs, and what the gyroscopic and the rotary matrix multiply.

    All three are ``(angles, nodal dofs)``; see `ElasticResponse`.
    """

    of_nodes: Array
    turning: Array
    centripetal: Array

    def power(self, system: System, rates: Rates, v: Array) -> Array:
        """Power of the inertia ``-m a`` in the rates of the mechanism bent by v, ``(angles,)`` (W).

        Parameters
        ----------
        system
            The mechanism, for its mass.
        rates
            Rates in which the inertia does work, true or virtual.
        v
            The displacement by which it is bent, in link axes, ``(angles, nodal dofs)``.
        """
        mass, rotary = system.nodal_mass, system.nodal_rotary_mass
        force, velocity = (mass @ self.of_nodes.T - rotary @ self.centripetal.T).T, rates.rigid + rates.deformation
        if not self.turning.any() and not v.any():  # then nothing calls for the gyroscopic matrix
            return -np.sum(force * velocity, axis=1)
        gyroscopic = system.nodal_gyroscopic
        force = force + (gyroscopic @ self.turning.T).T
        swung = self.of_nodes * (gyroscopic @ v.T).T + self.turning * ((mass - rotary) @ v.T).T
        return -np.sum(force * velocity + rates.turning * swung, axis=1)
