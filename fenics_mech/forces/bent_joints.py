"""Forces of joint laws on links that bend, and how they change with the motion.

The laws act on frames at the joints' points, as they do on rigid links. Dry friction is a share of the force of its
joint, which is the multiplier of the joint's equation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from fenics_mech._arrays import Array, Index, times
from fenics_mech.effects.joint_frames import JointFrames, LawForces
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.joint_forces import nodal_forces, reactions
from fenics_mech.joints.bent_guide import BentGuide, nodes_along
from fenics_mech.joints.dry_friction import DryFriction, line, next_held
from fenics_mech.joints.friction_balance import FrictionBalance
from fenics_mech.joints.joint_state import JointLaw, JointPlace, JointState, Touching, Wrench
from fenics_mech.joints.laws import laws_of, rubbing_of
from fenics_mech.joints.link_states import BodyForces, LinkStates, quarter
from fenics_mech.mechanism import System
from fenics_mech.scene import Scene
from fenics_mech.scene.paired_joints import PairedJoints

Contacts = Mapping[str, Touching]  # by law


@dataclass(frozen=True)
class LawDifferences:
    """Steps of central differences by place and velocity of the frames of joints."""

    place: float = 1e-8  # m or rad: contacts are as stiff as that needs
    rate: float = 1e-7  # m/s or rad/s, at most
    width: float = 0.03  # of the width over which dry friction changes its sense, at most


LAW_DIFFERENCES = LawDifferences()


@dataclass(frozen=True)
class LawSlopes:
    """What the laws exert by small changes of the frames and of the joints' forces.

    Parameters
    ----------
    by_place, by_rate
        Forces on the frames by their places and velocities, ``(states, 3 frames, 3 frames)`` each.
    by_pressing
        The same by what else changes the joints' forces, ``(states, 3 frames, rows)``.
    """

    by_place: Array
    by_rate: Array
    by_pressing: Array


@dataclass(frozen=True)
class Acting:
    """What the laws exert at states.

    Parameters
    ----------
    exerted
        Forces on the frames but for dry friction, ``(states, 3 frames)``.
    units
        The same by dry friction of size 1, ``(states, 3 frames, laws)``.
    friction
        What the friction has to fulfil; None where nothing rubs.
    """

    exerted: Array
    units: Array
    friction: FrictionBalance | None


@dataclass(frozen=True)
class BentJoints:
    """The joint laws of a scene of which links bend.

    Parameters
    ----------
    scene
        The scene.
    frames
        Frames at the points of the joints.
    names
        The points, by frame.
    guides
        By joint: the points at the nodes of the member that a pin travels along; none where it does not.
    start
        The frames at the start, where gears have no moment.
    """

    scene: Scene
    frames: JointFrames
    names: tuple[str, ...]
    guides: Mapping[str, list[str]]
    start: LinkStates

    @classmethod
    def of(cls, scene: Scene, system: System, of_sines: bool) -> BentJoints:
        """Place the laws of a scene.

        Parameters
        ----------
        scene
            The scene.
        system
            Its mechanism at the start.
        of_sines
            Whether rotational dofs are the sines of rotations.
        """
        laws = scene.joint_laws.values()
        joints = [law.joint for law in laws] + [law.drives for law in laws if isinstance(law, PairedJoints)]
        points = [point for joint in joints for point in scene.joints[joint].connect if not point.startswith("ground.")]
        guides = {joint: nodes_along(scene, system.beams.mesh, joint) for joint in joints}
        names = tuple(dict.fromkeys([*points, *(point for nodes in guides.values() for point in nodes)]))
        frames = JointFrames.of(scene, system.beams.mesh, names, of_sines)
        still = np.zeros((1, system.transformation.height))
        return cls(scene, frames, names, guides, frames.states(system.motion, still, still))

    @cached_property
    def laws(self) -> dict[str, JointLaw]:
        """The laws, by name."""
        return laws_of(self.scene, self.start, self._place)

    def _place(self, joint: str) -> JointPlace:
        """Place of a joint among the frames: points of frames are their origins."""
        place, ends = JointPlace.of(self.scene, joint), self.scene.joints[joint].connect
        bodies = [self.names.index(point) if point in self.names else -1 for point in ends]
        points = [(0.0, 0.0) if body >= 0 else at for body, at in zip(bodies, place.points)]
        found = replace(place, bodies=(bodies[0], bodies[1]), points=(points[0], points[1]))
        if not self.guides[joint]:
            return found
        frames = tuple(map(self.names.index, self.guides[joint]))
        steps = np.linalg.norm(np.diff(self.frames.points[list(frames)], axis=0), axis=1)
        distances = tuple(np.append(0.0, np.cumsum(steps)).tolist())
        return BentGuide(**vars(found), nodes=frames, distances=distances)

    @cached_property
    def rubbing(self) -> dict[str, DryFriction]:
        """Those of them that are dry friction."""
        return rubbing_of(self.laws)

    def states(self, system: System, response: ElasticResponse) -> LinkStates:
        """Give place and velocity of the frames.

        Parameters
        ----------
        system, response
            The mechanism and its motion.
        """
        v = system.to_links(response.displacement)
        assert response.velocity is not None
        return self.frames.states(system.motion, v, response.velocity)

    def exerted(self, time: Array, links: LinkStates, contacts: Contacts) -> dict[str, Array]:
        """Give what the laws exert on the frames, but for dry friction, ``(states, frames + 1, 3)`` by law.

        Parameters
        ----------
        time
            Times (s), ``(states,)``.
        links
            The frames.
        contacts
            Which contacts are closed.
        """
        found = {}
        for name, law in self.laws.items():
            state = law.joint.state(links)
            found[name] = self._on_frames(law, state, law.wrench(time, state, contacts[name]))
        return found

    def size_of(self, name: str, links: LinkStates, values: Array) -> Array:
        """Give the size of what a law exerts, as `JointPlace.size` does.

        Parameters
        ----------
        name
            The law.
        links
            The frames.
        values
            What it exerts on them.
        """
        place = self.laws[name].joint
        on_second = values[:, place.bodies[1]]
        wrench = Wrench(on_second[:, :2], on_second[:, 2], np.zeros_like(on_second[:, :2]))
        return place.size(links, wrench, place.name in self.scene.open_joints)

    def _on_frames(self, law: JointLaw, state: JointState, wrench: Wrench) -> Array:
        on = BodyForces.none(len(state.place), len(self.frames))
        law.joint.exert(on, state, wrench)
        return on.values

    def _rubbed(self, links: LinkStates, contacts: Contacts) -> tuple[Array, tuple[Array, Array]]:
        """Forces on the frames by friction of size 1, ``(states, frames + 1, 3, laws)``, and `DryFriction.shares`."""
        units, shares = [], []
        for name, law in self.rubbing.items():
            state = law.joint.state(links)
            units.append(self._on_frames(law, state, law.joint.effort(state, np.ones_like(state.place))))
            shares.append(law.shares(state, contacts[name].held))
        held, beyond = (np.stack(parts, axis=-1) for parts in zip(*shares))
        return np.stack(units, axis=-1), (held, beyond)

    def hold(
        self, links: LinkStates, contacts: Contacts, before: Mapping[str, float]
    ) -> tuple[dict[str, Touching], float]:
        """Give where Newton's method holds friction next, and how far its tangents there are from its law, at most.

        Parameters
        ----------
        links
            The frames.
        contacts
            Where it was held.
        before
            Where it is held at first, by law: at the end of the step before.
        """
        found, off = dict(contacts), 0.0
        for name, law in self.rubbing.items():
            speed, held = law.scaled_speed(law.joint.state(links)), contacts[name].held
            first = np.full_like(speed, before.get(name, 0.0))
            held = first if held is None else next_held(held, speed)
            off = max(off, float(np.abs(line(held, speed) - np.tanh(speed)).max()))
            found[name] = replace(contacts[name], held=held)
        return found, off

    def pressing(self, system: System, links: LinkStates, forces: Array) -> Array:
        """Give the joints' forces that press bodies against each other, ``(..., states, rows)`` (N).

        Two rows are those of a pin, and one is that of a slider, across its guide.

        Parameters
        ----------
        system
            The mechanism.
        links
            The frames.
        forces
            Forces of the joints on the nodal dofs in link axes, ``(..., states, nodal dofs)``.
        """
        found, rows = reactions(system, forces), []
        for law in self.rubbing.values():
            name, ends = law.joint.name, self.scene.joints[law.joint.name].connect
            body = next(body for body in (end.split(".")[0] for end in ends) if (name, body, 2) in found)
            force = found[name, body, 2]
            if law.joint.slides:
                force = np.sum(quarter(law.joint.state(links).along) * force, axis=-1, keepdims=True)
            rows.append(force)
        return np.concatenate(rows, axis=-1) if rows else np.zeros((*forces.shape[:-1], 0))

    @cached_property
    def rows(self) -> list[Index]:
        """Rows of `pressing` that belong to each law of friction."""
        counts = np.cumsum([0] + [1 if law.joint.slides else 2 for law in self.rubbing.values()])
        return [np.arange(first, last) for first, last in pairwise(counts)]

    def forces(self, system: System, response: ElasticResponse, contacts: Contacts) -> dict[str, LawForces]:
        """Give what the laws exert in a motion.

        Parameters
        ----------
        system, response
            The mechanism without the laws, and its motion.
        contacts
            Which contacts are closed.

        Raises
        ------
        SolverError
            When friction locks the linkage.
        """
        links = self.states(system, response)
        values = self.exerted(system.motion.time, links, contacts)
        if self.rubbing:
            units, (_, beyond) = self._rubbed(links, contacts)
            balance = self._balance(system, response, links, _whole(values), contacts)
            friction, _ = balance.solve()
            factor, sizes, _ = balance.slopes(friction)
            friction = friction + times(factor, sizes * beyond)
            for k, name in enumerate(self.rubbing):
                values[name] = values[name] + units[..., k] * friction[:, k, None, None]
        return self.on_nodes(system, response, values)

    def on_nodes(self, system: System, response: ElasticResponse, values: dict[str, Array]) -> dict[str, LawForces]:
        """Give what the laws exert, with what that does on the nodes.

        Parameters
        ----------
        system, response
            The mechanism and its motion.
        values
            Forces and moments on the frames by law, ``(states, frames + 1, 3)`` each.
        """
        found, v = {}, system.to_links(response.displacement)
        for name, value in values.items():
            law, nodal = self.laws[name], self.frames.on_nodes(system.motion, v, value[:, :-1])
            joint = "" if law.joint.elsewhere else law.joint.name
            found[name] = LawForces(joint, law.joint.bodies, law.cause, self.frames, value, nodal)
        return found

    def acting(self, system: System, response: ElasticResponse, contacts: Contacts) -> Acting:
        """Give what the laws exert, with friction yet to be found.

        Parameters
        ----------
        system, response, contacts
            As of `forces`.
        """
        links = self.states(system, response)
        whole = _whole(self.exerted(system.motion.time, links, contacts))
        exerted = whole[:, :-1].reshape(len(whole), -1)
        if not self.rubbing:
            return Acting(exerted, np.zeros((*exerted.shape, 0)), None)
        units = self._rubbed(links, contacts)[0][:, :-1].reshape(*exerted.shape, -1)
        return Acting(exerted, units, self._balance(system, response, links, whole, contacts))

    def _balance(
        self, system: System, response: ElasticResponse, links: LinkStates, exerted: Array, contacts: Contacts
    ) -> FrictionBalance:
        """What the friction has to fulfil, beside what the other laws exert on the frames."""
        shape = system.motion, system.to_links(response.displacement)
        units, (shares, _) = self._rubbed(links, contacts)
        others = self.frames.on_nodes(*shape, exerted[:, :-1])
        alone = self.pressing(system, links, nodal_forces(system, response) - others)
        taken = self.pressing(system, links, self.frames.on_nodes(*shape, np.moveaxis(units[:, :-1], -1, 0)))
        return FrictionBalance(alone, np.moveaxis(taken, 0, -1), shares, self.rows)

    def slopes(self, system: System, response: ElasticResponse, contacts: Contacts) -> LawSlopes:
        """Give what the laws exert by small changes, about a motion.

        Parameters
        ----------
        system, response, contacts
            As of `forces`.
        """
        links, time, count = self.states(system, response), system.motion.time, 3 * len(self.frames)
        by_place, by_rate = self._differences(time, links, contacts)
        acting = self.acting(system, response, contacts)
        if (balance := acting.friction) is None:
            return LawSlopes(by_place[:, :count], by_rate[:, :count], np.zeros((len(time), count, 0)))
        friction, _ = balance.solve()
        factor, sizes, shared = balance.slopes(friction)  # `alone` changes by d(pressing) - taken d(exerted)
        taken = self._taken(system, response, links)
        found = []
        for part in (by_place, by_rate):
            exerted_by, share_by = part[:, :count], part[:, count:]
            change = factor @ (sizes[..., None] * share_by - shared @ taken @ exerted_by)
            found.append(exerted_by + acting.units @ change)
        return LawSlopes(found[0], found[1], acting.units @ factor @ shared)

    def _taken(self, system: System, response: ElasticResponse, links: LinkStates) -> Array:
        """What forces on the frames take off the joints' forces, ``(states, rows, 3 frames)``."""
        v, count = system.to_links(response.displacement), 3 * len(self.frames)
        units = np.broadcast_to(np.eye(count)[:, None], (count, len(v), count)).reshape(count, len(v), -1, 3)
        return np.moveaxis(self.pressing(system, links, self.frames.on_nodes(system.motion, v, units)), 0, -1)

    def _differences(self, time: Array, links: LinkStates, contacts: Contacts) -> tuple[Array, Array]:
        """Forces on the frames, then the shares of friction, by places and velocities of the frames."""
        states, count = len(time), 3 * len(self.frames)
        contacts = {
            name: one if one.held is None else replace(one, held=np.tile(one.held, count))
            for name, one in contacts.items()
        }
        steps = np.zeros((count, len(self.frames) + 1, 3))
        steps[:, :-1] = np.eye(count).reshape(count, -1, 3)
        narrow = [LAW_DIFFERENCES.width * law.stated.width / law.arm for law in self.rubbing.values()]
        found = []
        for place, rate in ((LAW_DIFFERENCES.place, 0.0), (0.0, min(LAW_DIFFERENCES.rate, *narrow, np.inf))):
            parts = []
            for sign in (1.0, -1.0):
                pose, speed = (
                    (part[None] + sign * step * steps[:, None]).reshape(-1, *part.shape[1:])
                    for part, step in ((links.pose, place), (links.rate, rate))
                )
                there = LinkStates(pose, speed)
                whole = _whole(self.exerted(np.tile(time, count), there, contacts))
                values = [np.reshape(whole[:, :-1], (count * states, count))]
                if self.rubbing:
                    held, beyond = self._rubbed(there, contacts)[1]
                    values.append(held + beyond)
                parts.append(np.concatenate(values, axis=1).reshape(count, states, -1))
            found.append(np.moveaxis(parts[0] - parts[1], 0, -1) / (2 * (place + rate)))
        return found[0], found[1]


def _whole(exerted: Mapping[str, Array]) -> Array:
    """Forces on the frames by all laws together, ``(states, frames + 1, 3)``."""
    return np.sum(list(exerted.values()), axis=0)
