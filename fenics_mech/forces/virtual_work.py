"""Efforts of the drives by virtual work on the bent mechanism, and the power of every cause of force.

A point of a link is at ``r = r_0 + R (X + N v)`` with ``v = P q``. As one drive moves at unit rate and q is held, it
moves by ``V + phi z x N v + N dP/dtheta q`` in link axes, with the velocity V and the angular velocity phi of the rigid
motion. The effort of the drive is minus the work of all other forces in this motion. The equation of motion is their
work at a held drive: efforts and equation together make the balance of energy, wherever the coupling acts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects import NOTHING, UNLOADED, Loads, Situation, Terms, active, dampers
from fenics_mech.effects.loads import terms as load_terms
from fenics_mech.effects.loads import turned_back
from fenics_mech.effects.offsets import terms as offset_terms
from fenics_mech.effects.springs import shortening_power, spring_power
from fenics_mech.effects.terms import quarter_back
from fenics_mech.forces.air import air_loads
from fenics_mech.forces.elastic_response import ElasticResponse, RotationOfFrames, rate_of_cycle
from fenics_mech.forces.joint_forces import nodal_forces
from fenics_mech.forces.mass_shift import MassShift
from fenics_mech.forces.rates import Acceleration, Rates
from fenics_mech.forces.shortening import Shortening
from fenics_mech.forces.spinning_sections import work_against_spin
from fenics_mech.kinematics import Motion
from fenics_mech.kinematics.influence import drive_influences
from fenics_mech.mechanism import System
from fenics_mech.scene import Scene
from fenics_mech.terms.causes import Cause


@dataclass(frozen=True)
class Forces:
    """All forces of a motion but those of the drives, and the work that they do.

    Parameters
    ----------
    scene, system, response
        The scene, its mechanism and its motion.
    beside
        Loads of the system that are none of the scene, such as what stands for an error of its mesh.
    """

    scene: Scene
    system: System
    response: ElasticResponse
    beside: Loads = UNLOADED

    @property
    def bent(self) -> bool:
        """Whether forces do their work on the bent mechanism.

        They do where the elastic motion feels that of the links, and in equilibria on the bent axis. Linear statics,
        and motions without the coupling or with the inertia of the rigid motion alone, are of first order: forces
        balance on the undeformed shape. On the bent one inertia would do work that no other inertia gives back.
        """
        if self.scene.analysis.method == "static":
            return self.system.terms.law is not None or self.system.terms.stiffening is not None
        return self.response.rotation is not None

    def efforts(self) -> dict[str, Array]:
        """Torque (N m), or force along the guide (N), of each drive on the second body of its joint, ``(angles,)``."""
        work = self._on_bent if self.bent else self._on_undeformed
        units = drive_influences(self.scene, self.system.motion)
        return {joint: work(rates) for joint, rates in zip(self.scene.moved_joints, self.rates_of(units))}

    def _on_bent(self, rates: Rates) -> Array:
        """Effort of the drive that moves the links so, ``(angles,)``."""
        shorter = None if self.shortening is None else self.shortening.by_drive(rates.motion, rates.deformation)
        shifted = None if self.shift is None else self.shift.by_change(rates.deformation)
        return -np.sum(list(self._works(rates, shorter, shifted).values()), axis=0)

    def rates_of(self, units: Sequence[Motion]) -> list[Rates]:
        """Rates of the mechanism as a drive moves the links so and q is held; of its undeformed shape if not bent.

        Parameters
        ----------
        units
            Motions of the links at the same positions as a drive moves at unit rate.
        """
        system, q = self.system, self.response.displacement
        if not self.bent:
            return [Rates.of(system, unit, self.still) for unit in units]
        swung = [system.on_nodes(system.transformation.forward(p, q)) for p in system.transformation.rates_in(units)]
        return [Rates.of(system, unit, deformation) for unit, deformation in zip(units, swung)]

    def _on_undeformed(self, rates: Rates) -> Array:
        """Effort of the drive that moves the links so, by the forces that the nodes need, ``(angles,)``."""
        forces = nodal_forces(self.system, self.response.undamped)
        if self.response.by_modal_damping is not None:
            forces = forces + nodal_forces(replace(self.system, terms=NOTHING), self.response.by_modal_damping)
        return np.asarray(np.sum(forces * rates.rigid, axis=1))

    def powers(self) -> dict[str, Array]:
        """Power of each cause of force in the motion itself (W), ``(angles,)`` each."""
        shorter = self.shortening.in_time[1] if self.shortening is not None and self.bent else None
        shifted = self.shift.in_time[1] if self.shift is not None and self.bent else None
        return self._works(self.rates, shorter, shifted)

    @cached_property
    def displacement(self) -> Array:
        """Elastic displacement v in link axes, ``(angles, nodal dofs)``."""
        return self.system.to_links(self.response.displacement)

    @cached_property
    def _velocity(self) -> Array:
        """Rate of the displacement with which the links strain, ``(angles, nodal dofs)``."""
        if self.scene.analysis.method in ("static", "quasi-static") or not self.scene.moved_joints:
            return self.still
        if self.response.velocity is not None:
            return self.response.velocity
        rate = self.system.transformation.derivatives(self.system.motion)[0]
        carried = self.system.transformation.forward(rate, self.response.displacement)
        return rate_of_cycle(self.displacement, self.scene.period) - self.system.on_nodes(carried)

    @cached_property
    def shape(self) -> Array:
        """Displacement in link axes of the shape on which forces do their work, ``(angles, nodal dofs)``."""
        return self.displacement if self.bent else self.still

    @cached_property
    def rates(self) -> Rates:
        """Rates of the motion itself."""
        return Rates.of(self.system, self.system.motion, self._velocity)

    @cached_property
    def still(self) -> Array:
        """No displacement, ``(angles, nodal dofs)``."""
        return np.zeros_like(self.displacement)

    @cached_property
    def weight(self) -> Array:
        """Acceleration of the frame that acts as the weight does, ``(angles, nodal dofs)``."""
        weight = self.system.terms.acceleration
        return self.still if weight is None else np.broadcast_to(weight, self.displacement.shape)

    @cached_property
    def _drags(self) -> dict[str, Acceleration]:
        """Accelerations whose inertia is the drag, on the absolute velocity and on the relative one."""
        damping, velocity = self.system.terms.damping, self._velocity
        absolute = damping.external * (self.system.rigid_velocity + velocity)
        turning = damping.external * self.rates.turning * self.shape
        found = {Cause.EXTERNAL_DRAG: (absolute, turning)} if damping.external else {}
        found |= {Cause.RELATIVE_DRAG: (damping.relative * velocity, self.still)} if damping.relative else {}
        return {name: Acceleration(*parts, self.still) for name, parts in found.items()}

    @cached_property
    def _accelerations(self) -> dict[str, Acceleration]:
        """Accelerations by cause: those of the motion, of weight and of drag."""
        response = self.response
        rotation = response.rotation or RotationOfFrames(self.still, self.still)
        own = response.inertia - self.weight - sum((a.of_nodes for a in self._drags.values()), self.still)
        turning = rotation.turning - sum((a.turning for a in self._drags.values()), self.still)
        return {
            Cause.INERTIA: Acceleration(own, turning, rotation.centripetal),
            Cause.WEIGHT: Acceleration(self.weight, self.still, self.still),
            **self._drags,
        }

    @cached_property
    def _of_axial_forces(self) -> dict[str, Acceleration]:
        """Accelerations by cause that the given axial forces balance: those of the rigid motion unless they settle."""
        if self.scene.freedoms:  # see `inert_shift`
            return {Cause.WEIGHT: Acceleration(self.weight, self.still, self.still)}
        if self.scene.analysis.tension == "settled":
            return self._accelerations
        drag = self.system.terms.damping.external * self.system.rigid_velocity
        parts = {
            Cause.INERTIA: self.system.rigid_acceleration - self.weight - drag,
            Cause.WEIGHT: self.weight,
            Cause.EXTERNAL_DRAG: drag,
        }
        return {name: Acceleration(part, self.still, self.still) for name, part in parts.items() if part.any()}

    @cached_property
    def shortening(self) -> Shortening | None:
        """Displacement by the shortening of members whose axial forces are given."""
        return Shortening.of(self.scene, self.system, self.jets)

    @cached_property
    def shift(self) -> MassShift | None:
        """Shift of the elements' mass, where axial forces change inside them."""
        return MassShift(self.system, self.jets) if self.system.terms.uneven else None

    @property
    def inert_shift(self) -> MassShift | None:
        """The same where it has inertia: in a motion with freedoms it would have to be part of the links' mass, too."""
        return None if self.scene.freedoms else self.shift

    @cached_property
    def jets(self) -> tuple[Array, Array, Array]:
        """Elastic displacement v in link axes and its two time derivatives, ``(angles, nodal dofs)`` each."""
        second = self.still
        if self.response.rotation is not None:
            drag = self.system.terms.damping.drag
            own = self.system.rigid_acceleration + drag * self._velocity + self.response.rotation.centripetal
            second = self.response.inertia - own
        return self.displacement, self._velocity, second

    def _works(self, rates: Rates, shorter: Array | None, shifted: Array | None) -> dict[str, Array]:
        """Work of each cause in some rates, ``(angles,)`` each.

        Their rates of the shortening's u and of the elements' shift are `shorter` and `shifted`.
        """
        mesh, motion, shape = self.system.beams.mesh, self.system.motion, self.shape
        powers = {name: a.power(self.system, rates, shape) for name, a in self._accelerations.items()}
        powers |= {name: -np.sum(force * rates.deformation, axis=1) for name, force in self._stress.items()}
        powers[Cause.LOADS] = self._of_loads(rates, shape) + self._of_applied(self.beside, UNLOADED, rates, shape)
        powers[Cause.INERTIA] = powers[Cause.INERTIA] + self._of_mass_beside_axes(rates, shape)
        if self.bent:
            powers[Cause.INERTIA] -= work_against_spin(self.system, self.response, rates.motion, rates.deformation)
        powers[Cause.SPRINGS] = spring_power(self.scene, mesh, rates.motion, shape, rates.deformation)
        powers[Cause.DAMPERS] = dampers.damper_power(
            self.scene, mesh, (motion, rates.motion), (shape, self._velocity), rates.deformation
        )
        if self.scene.damping.air is not None:
            powers[Cause.AIR_DRAG] = self._of_applied(*air_loads(self.scene, self.system, self.response), rates, shape)
        for law in self.system.terms.joint_laws:
            power = law.power(rates.motion, shape, rates.deformation)
            powers[law.cause] = powers.get(law.cause, 0.0) + power
        more = [] if shorter is None else [self._by_shortening(rates, shorter)]
        more += [] if shifted is None else [self._by_shift(rates, shifted)]
        for name, power in (item for works in more for item in works.items()):
            powers[name] = powers.get(name, 0.0) + power
        return powers

    @cached_property
    def _stress(self) -> dict[str, Array]:
        """Forces of the links' stress: elastic, of the material's damping, of modal damping, ``(angles, nodal dofs)``.

        Axial forces that are given do no work: what they do on the bent axis is the work of what they balance.
        """
        system, stiffness = self.system, self.system.nodal_stiffness
        elastic = (stiffness @ self.displacement.T).T
        material = system.terms.damping.material * (stiffness @ self._velocity.T).T
        if system.terms.law is not None:
            law = system.terms.law.on_elements
            at_rest = system.assembled(law.force(self.displacement, self.still))
            elastic = elastic + at_rest
            material = material + system.assembled(law.force(self.displacement, self._velocity)) - at_rest
        forces: dict[str, Array] = {Cause.ELASTIC: elastic, Cause.MATERIAL: material}
        if (damping := self.response.modal_damping) is not None:
            forces[Cause.MODAL_DAMPING] = (stiffness @ damping.displacement.T).T
            if damping.on_bent_axis is not None:
                forces[Cause.MODAL_DAMPING] += system.assembled(damping.on_bent_axis)
        return forces

    def _of_loads(self, rates: Rates, v: Array) -> Array:
        """Power of loads on the mechanism bent by v."""
        power = self._of_turned(load_terms(self._situation), rates, v)
        return power + sum(self._of_applied(*parts, rates, v) for parts in self._loads)

    @cached_property
    def _loads(self) -> list[tuple[Loads, Loads]]:
        """Loads whose work counts as such, and the same turned by a quarter clockwise."""
        found = [(load_terms(self._situation).loads, turned_back(self._situation))]
        for effect in active(self.scene):
            if effect.work == "as load" and effect.terms is not None:
                loads = effect.terms(self._situation).loads
                found.append((loads, loads.turned()))
        return found

    def _of_turned(self, terms: Terms, rates: Rates, v: Array) -> Array:
        """Power of what is added to loads as the axes that they act on turn by v."""
        added = sum((-entries.times(v) for entries in terms.matrices.follower), self.still)
        moved = rates.rigid + rates.deformation
        if self.system.terms.law is None:
            return np.asarray(np.sum(added * moved, axis=1))
        for forces in terms.rotation_forces:
            added = added - forces.on_nodes(v, self.still)
        moved[:, 2::3] = rates.deformation[:, 2::3]  # on the rotation of links moments do the same work as ever
        swung = quarter_back(added, (len(v), -1, 3)) * rates.turning * v
        return np.asarray(np.sum(added * moved + swung, axis=1))

    def _of_mass_beside_axes(self, rates: Rates, v: Array) -> Array:
        """Power of the centrifugal force of mass that is beside its member's axis; see `effects.offsets`."""
        if self.system.beams.layout.offsets is None:
            return np.zeros(len(v))
        loads = offset_terms(self._situation).loads
        return self._of_applied(loads, loads.turned(), rates, v)

    def _of_applied(self, loads: Loads, turned: Loads, rates: Rates, v: Array) -> Array:
        """Power of loads on the mechanism bent by v; `turned` are the same turned by a quarter clockwise."""
        swung = self.system.applied_by(turned) * rates.turning * v
        return np.asarray(np.sum(self.system.applied_by(loads) * (rates.rigid + rates.deformation) + swung, axis=1))

    @property
    def _situation(self) -> Situation:
        return Situation(self.scene, self.system.beams, self.system.motion)

    def _by_shift(self, rates: Rates, shifted: Array) -> dict[str, Array]:
        """Work of the forces of the straight links in the shift of the elements' mass, and of its own inertia."""
        assert self.shift is not None
        found, system = self.shift.works(self._of_axial_forces, rates, shifted), self.system
        if self.response.rotation is not None and self.inert_shift is not None:
            tangential = system.motion.alpha[:, system.link_of_dof], system.terms.damping.external
            for name, work in self.shift.own_works(self.rates.turning, tangential, rates.rigid).items():
                found[name] = found.get(name, 0.0) + work
        found[Cause.LOADS] = sum(
            (self.shift.of_loads(*parts, rates.turning, shifted) for parts in self._loads), np.zeros(len(shifted))
        )
        return found

    def _by_shortening(self, rates: Rates, shorter: Array) -> dict[str, Array]:
        """Work of the forces of the straight links in the shortening, and of what the shortening makes in theirs."""
        assert self.shortening is not None
        system, (u, first, second) = self.system, self.shortening.in_time
        carried = Rates(rates.motion, self.still, rates.turning, shorter)
        found = {name: a.power(system, carried, u) for name, a in self._of_axial_forces.items()}
        if self.response.rotation is not None:
            omega, alpha = self.rates.turning, system.motion.alpha[:, system.link_of_dof]
            centripetal = -(omega**2) * u
            own = {Cause.INERTIA: Acceleration(second + centripetal, 2 * omega * first + alpha * u, centripetal)}
            if drag := system.terms.damping.external:
                own[Cause.EXTERNAL_DRAG] = Acceleration(drag * first, drag * omega * u, self.still)
            straight = replace(rates, deformation=self.still)
            for name, acceleration in own.items():
                found[name] = found.get(name, 0.0) + acceleration.power(system, straight, self.still)
        found[Cause.LOADS] = self._of_loads(carried, u)
        found[Cause.INERTIA] = found.get(Cause.INERTIA, 0.0) + self._of_mass_beside_axes(carried, u)
        if self.scene.damping.air is not None:
            air = air_loads(self.scene, system, self.response, rigid=True)
            found[Cause.AIR_DRAG] = self._of_applied(*air, carried, u)
        found[Cause.DAMPERS] = dampers.shortening_power(
            self.scene, system.beams.mesh, (system.motion, rates.motion), (u, first), shorter
        )
        found[Cause.SPRINGS] = shortening_power(self.scene, system.beams.mesh, rates.motion, u, shorter)
        return found
