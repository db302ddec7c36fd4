"""Forces on rigid links: weight, drag, loads, springs and dampers, as forces on the coordinates of the links."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.joints.link_states import BodyForces, LinkStates, quarter
from fenics_mech.kinematics.load_factors import load_factor
from fenics_mech.scene import HingeDamper, HingeSpring, LineDamper, LineSpring, Load, Scene
from fenics_mech.scene.springs_dampers import Hinge
from fenics_mech.terms.causes import Cause

Pull = Callable[[Array, Array], Array]  # tension or moment by the length or angle (m, rad) and its rate, ``(states,)``


@dataclass(frozen=True)
class RigidInertia:
    """Inertia of rigid links, about their centres of mass.

    Parameters
    ----------
    mass, inertia
        Mass (kg) and moment of inertia (kg m^2), ``(links,)`` each.
    centre
        Centre of mass in the link's frame (m), ``(links, 2)``.
    """

    mass: Array
    inertia: Array
    centre: Array

    @classmethod
    def of(cls, scene: Scene) -> RigidInertia:
        """Take the inertia of a scene's links, none of which bends.

        Parameters
        ----------
        scene
            The scene.
        """
        bodies = [link.rigid for link in scene.links.values() if link.rigid is not None]
        return cls(
            np.array([body.mass for body in bodies]),
            np.array([body.inertia for body in bodies]),
            np.array([body.centre for body in bodies]),
        )

    def arms(self, links: LinkStates) -> Array:
        """Centres of mass, seen from the links' origins in the fixed frame (m), ``(states, links, 2)``.

        Parameters
        ----------
        links
            Where the links are.
        """
        c, s = (part[:, :-1] for part in links.axes)
        x, y = self.centre.T
        return np.stack([c * x - s * y, s * x + c * y], axis=-1)

    def velocity(self, links: LinkStates) -> Array:
        """Velocities of the centres of mass (m/s), ``(states, links, 2)``.

        Parameters
        ----------
        links
            How the links move.
        """
        return links.rate[:, :-1, :2] + links.rate[:, :-1, 2:] * quarter(self.arms(links))

    def kinetic_energy(self, links: LinkStates) -> Array:
        """Kinetic energy (J), ``(states,)``.

        Parameters
        ----------
        links
            How the links move.
        """
        velocity, omega = self.velocity(links), links.rate[:, :-1, 2]
        return np.asarray(np.sum(velocity**2, axis=-1) @ self.mass + omega**2 @ self.inertia) / 2

    def on_coordinates(self, links: LinkStates, force: Array, moment: Array) -> Array:
        """Forces at the centres of mass, ``(states, links, 2)``, and moments, on coordinates, ``(states, 3 links)``.

        Parameters
        ----------
        links
            Where the links are.
        force, moment
            N and N m.
        """
        arms = self.arms(links)
        about_origin = moment + arms[..., 0] * force[..., 1] - arms[..., 1] * force[..., 0]
        return np.concatenate([force, about_origin[..., None]], axis=-1).reshape(len(force), -1)

    def needed(self, links: LinkStates, second: Array) -> Array:
        """Forces on the coordinates that accelerate the links so, ``(states, 3 links)``.

        Parameters
        ----------
        links
            How the links move.
        second
            Second derivatives of their coordinates, ``(states, 3 links)``.
        """
        second = second.reshape(len(second), -1, 3)
        arms, omega, alpha = self.arms(links), links.rate[:, :-1, 2:], second[..., 2:]
        acceleration = second[..., :2] + alpha * quarter(arms) - omega**2 * arms  # (6.29)
        return self.on_coordinates(links, self.mass[:, None] * acceleration, self.inertia * second[..., 2])


@dataclass(frozen=True)
class RigidLoads:
    """Weight, drag, loads, springs and dampers on rigid links.

    Parameters
    ----------
    scene
        The scene.
    start
        Coordinates of the links where springs without a stated length or angle are free, ``(3 links,)``.
    """

    scene: Scene
    start: Array

    @cached_property
    def inertia(self) -> RigidInertia:
        """Inertia of the links."""
        return RigidInertia.of(self.scene)

    @cached_property
    def _bodies(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.scene.links)} | {"ground": -1}

    def by_cause(self, theta: Array, time: Array, links: LinkStates) -> dict[Cause, Array]:
        """Forces on the coordinates of the links by their cause, ``(states, 3 links)`` each.

        Parameters
        ----------
        theta, time
            Drive angles (rad) and times (s), ``(states,)`` each.
        links
            How the links move.
        """
        scene, found = self.scene, {}
        if any(scene.gravity):
            weight = self.inertia.mass[:, None] * np.broadcast_to(scene.gravity, links.pose[:, :-1, :2].shape)
            found[Cause.WEIGHT] = self.inertia.on_coordinates(links, weight, np.zeros(weight.shape[:2]))
        if drag := scene.damping.external:
            force = -drag * self.inertia.mass[:, None] * self.inertia.velocity(links)
            moment = -drag * self.inertia.inertia * links.rate[:, :-1, 2]
            found[Cause.EXTERNAL_DRAG] = self.inertia.on_coordinates(links, force, moment)
        if scene.loads:
            on = self._none(links)
            for load in scene.loads.values():
                if isinstance(load, Load):
                    self._add_load(on, load, load_factor(scene, load, theta, time, links), links)
            found[Cause.LOADS] = on.on_coordinates
        for cause, parts in ((Cause.SPRINGS, self._springs), (Cause.DAMPERS, self._dampers)):
            if parts:
                on = self._none(links)
                for part, pull in parts:
                    self._add_pull(on, part, pull, links)
                found[cause] = on.on_coordinates
        return found

    def spring_energy(self, links: LinkStates) -> Array:
        """Energy of all springs (J), ``(states,)``.

        Parameters
        ----------
        links
            Where the links are.
        """
        energy = np.zeros(len(links.pose))
        for (part, _), spring in zip(self._springs, self.scene.springs.values()):
            energy += spring.stiffness / 2 * (self._extent(part, links)[0] - self._free(spring)) ** 2
        return energy

    def _none(self, links: LinkStates) -> BodyForces:
        return BodyForces.none(len(links.pose), links.pose.shape[1] - 1)

    def _add_load(self, on: BodyForces, load: Load, factor: Array, links: LinkStates) -> None:
        """Add a force and a moment at a point of a link, or at a pin, times a factor ``(states,)``."""
        name = (
            load.at if "." in load.at else next(at for at in self._points_of(load.at) if not at.startswith("ground."))
        )
        label, place = self.scene.point(name)
        body = self._bodies[label]
        force = links.turned(body, load.force) if load.follows else np.broadcast_to(load.force, (len(factor), 2))
        on.add(body, links.turned(body, place), factor[:, None] * force)
        on.turn(body, factor * load.moment)

    def _points_of(self, joint: str) -> tuple[str, ...]:
        return self.scene.joints[joint].connect

    @cached_property
    def _springs(self) -> list[tuple[LineSpring | HingeSpring, Pull]]:
        def pull(spring: LineSpring | HingeSpring) -> Pull:
            free = self._free(spring)
            return lambda extent, _: spring.stiffness * (extent - free)

        return [(spring, pull(spring)) for spring in self.scene.springs.values()]

    @cached_property
    def _dampers(self) -> list[tuple[LineDamper | HingeDamper, Pull]]:
        def pull(damper: LineDamper | HingeDamper) -> Pull:
            return lambda _, rate: damper.damping * rate

        return [(damper, pull(damper)) for damper in self.scene.dampers.values()]

    def _free(self, spring: LineSpring | HingeSpring) -> float:
        """Length (m) or angle (rad) at which a spring is free: as stated, whole turns and all, or that at the start."""
        stated = spring.angle if isinstance(spring, HingeSpring) else spring.length
        if stated is not None:
            return stated
        links = LinkStates.of(self.start[None], np.zeros_like(self.start[None]))
        return float(self._extent(spring, links)[0][0])

    def _extent(
        self, part: LineSpring | HingeSpring | LineDamper | HingeDamper, links: LinkStates
    ) -> tuple[Array, ...]:
        """Length (m) and direction of a line, or angle (rad) of a hinge, ``(states,)``."""
        if isinstance(part, Hinge):
            first, second = self._hinged(part)
            return (links.pose[:, second, 2] - links.pose[:, first, 2],)
        (_, at), (_, to) = self._ends(part, links)
        apart = to[0] - at[0]
        length = np.hypot(*apart.T)
        return length, apart / np.maximum(length, TINY)[:, None], to[1] - at[1]

    def _add_pull(
        self, on: BodyForces, part: LineSpring | HingeSpring | LineDamper | HingeDamper, pull: Pull, links: LinkStates
    ) -> None:
        """Add the two opposite forces or moments of a spring or a damper."""
        if isinstance(part, Hinge):
            first, second = self._hinged(part)
            rate = links.rate[:, second, 2] - links.rate[:, first, 2]
            moment = pull(self._extent(part, links)[0], rate)
            on.turn(first, moment)
            on.turn(second, -moment)
            return
        length, along, apart = self._extent(part, links)
        force = pull(length, np.sum(along * apart, axis=-1))[:, None] * along
        for sign, ((body, arm), _) in zip((1.0, -1.0), self._ends(part, links)):
            on.add(body, arm, sign * force)

    def _hinged(self, part: Hinge) -> tuple[int, int]:
        """Bodies of a torsional spring or damper."""
        first, second = part.bodies or [point.split(".")[0] for point in self._points_of(part.joint)]
        return self._bodies[first], self._bodies[second]

    def _ends(
        self, part: LineSpring | LineDamper, links: LinkStates
    ) -> list[tuple[tuple[int, Array], tuple[Array, Array]]]:
        """Body and arm of both ends of a line, and place and velocity there."""
        ends = []
        for name in part.between:
            label, place = self.scene.point(name)
            body = self._bodies[label]
            arm = links.turned(body, place)
            ends.append(((body, arm), links.point(body, arm)))
        return ends
