"""What drives give at the impulses of a cycle: they keep to their laws, and so push back at once.

The elastic velocities jump by ``M dq' = P^T J`` and the rigid motion by nothing. The effort of each drive also has an
impulse, by virtual work at held q as in `virtual_work`. It is minus the work of J and of the inertial impulses
``-m dv`` as that drive moves at unit rate. An impulse gives the energy J times the mean of the point's
velocities before and after, and a drive its impulse times its rate. Their sum is the jump of the kinetic energy.

Source: Goldsmith, Impact (1960), ch. 2; Lagrange's equations integrated over an instant.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects.impulses import nodal_impulses
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.rates import Acceleration, Rates
from fenics_mech.forces.virtual_work import Forces
from fenics_mech.kinematics.influence import drive_influences, drive_rates
from fenics_mech.mechanism import System
from fenics_mech.scene import Scene


@dataclass(frozen=True)
class AtImpulses:
    """State of a mechanism at the impulses of its cycle.

    Parameters
    ----------
    system
        The mechanism at the angle of each impulse.
    response
        Its response there, with the mean of the velocities before and after.
    jump
        Change of q' by each impulse (m/s, rad/s), ``(impulses, coordinates)``.
    """

    system: System
    response: ElasticResponse
    jump: Array


@dataclass(frozen=True)
class ImpulseWork:
    """The impulses of a scene as they strike its mechanism.

    Parameters
    ----------
    scene
        The scene.
    struck
        The state of its mechanism at each impulse.
    """

    scene: Scene
    struck: AtImpulses

    @cached_property
    def efforts(self) -> Array:
        """Impulse of each drive's effort (N m s, or N s along a guide), ``(impulses, drives)``."""
        units = drive_influences(self.scene, self.struck.system.motion)
        works = (self._of_impulses(rates) + self._of_inertia(rates) for rates in self._forces.rates_of(units))
        return -np.stack(list(works), axis=1)

    @property
    def by_drives(self) -> Array:
        """Energy that the drives give (J), ``(impulses,)``."""
        return np.asarray(np.sum(self.efforts * drive_rates(self.scene, self.struck.system.motion), axis=1))

    @property
    def by_impulses(self) -> Array:
        """Energy that the impulses themselves give (J), ``(impulses,)``."""
        return self._of_impulses(self._forces.rates)

    @cached_property
    def _forces(self) -> Forces:
        return Forces(self.scene, self.struck.system, self.struck.response)

    def _of_impulses(self, rates: Rates) -> Array:
        """Work of the impulses in some rates."""
        scene, system = self.scene, self.struck.system
        impulses = scene.impulses.values()
        acting, turned = nodal_impulses(impulses, scene.links, scene.joints, system.beams, system.motion)
        moved = acting * (rates.rigid + rates.deformation)
        return np.asarray(np.sum(moved + turned * rates.turning * self._forces.shape, axis=1))

    def _of_inertia(self, rates: Rates) -> Array:
        """Work of the inertia in some rates, as the velocities jump."""
        system, forces = self.struck.system, self._forces
        change, still = system.to_links(self.struck.jump), forces.still
        work = Acceleration(change, still, still).power(system, rates, forces.shape)
        if forces.shortening is not None and forces.bent:
            straight = Rates(rates.motion, rates.rigid, rates.turning, still)
            change = forces.shortening.by_velocity(change)
            work = work + Acceleration(change, still, still).power(system, straight, still)
        if (shift := forces.inert_shift) is not None and forces.bent:
            jump = shift.by_change(system.to_links(self.struck.jump))
            work = work - shift.momentum(rates.rigid, jump)
        return work
