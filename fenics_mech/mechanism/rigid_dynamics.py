"""Balance of forces on a linkage of rigid links: what its joints transmit, and the efforts of drives and freedoms.

With coordinates x of the links and J the Jacobian of the loop equations, ``J^T l = m x'' - f - sum e F``. The
multipliers l are the forces of the joints, and the efforts at drives and freedoms. m is the inertia of the links and f
the known forces. F is the unknown size of the friction in each joint, and e the forces by friction of size 1. The
friction is a share of the joint's force, ``F = s |l|``, which Newton's method finds.
Source: Nikravesh, Computer-Aided Analysis of Mechanical Systems (1988), chapter 11.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.joints.dry_friction import DryFriction
from fenics_mech.joints.friction_balance import FrictionBalance
from fenics_mech.joints.joint_state import JointLaw, JointPlace, JointState, Touching, Wrench
from fenics_mech.joints.laws import laws_of, rubbing_of
from fenics_mech.joints.link_states import BodyForces, LinkStates, cross
from fenics_mech.kinematics.loops import Loops
from fenics_mech.mechanism.rigid_loads import RigidLoads
from fenics_mech.scene import Scene
from fenics_mech.terms.causes import Cause

FROM_OUTSIDE = (Cause.WEIGHT, Cause.LOADS, Cause.EXTERNAL_DRAG)  # what acts on links and not on the frame
Contacts = Mapping[str, Touching]  # by law


@dataclass(frozen=True)
class RigidStates:
    """A motion of the links at many states.

    Parameters
    ----------
    time, theta
        Times (s) and drive angles (rad), ``(states,)`` each.
    q, velocity, acceleration
        Coordinates of the links and two derivatives, ``(states, 3 links)`` each.
    inverse
        Inverse of the loop equations' Jacobian, ``(states, 3 links, equations)``.
    """

    time: Array
    theta: Array
    q: Array
    velocity: Array
    acceleration: Array
    inverse: Array

    @cached_property
    def links(self) -> LinkStates:
        """How the bodies move."""
        return LinkStates.of(self.q, self.velocity)


@dataclass(frozen=True)
class Balance:
    """What acts in a motion.

    Parameters
    ----------
    multipliers
        Forces of the joints and efforts of drives and freedoms, by loop equation, ``(states, equations)``.
    friction
        Dry friction on the second body (N or N m) by law, ``(states,)`` each.
    forces
        Forces on the coordinates of the links by cause, ``(states, 3 links)`` each.
    """

    multipliers: Array
    friction: dict[str, Array]
    forces: dict[Cause, Array]


@dataclass(frozen=True)
class RigidDynamics:
    """Forces of a linkage of rigid links.

    Parameters
    ----------
    scene
        The scene, of which no link bends.
    loops
        Its loop equations, as many as coordinates.
    start
        Coordinates of the links at the start, ``(3 links,)``.
    at_rest
        Friction on the second body (N or N m) by law, where joints rest and their forces leave it open.
    """

    scene: Scene
    loops: Loops
    start: Array
    at_rest: Mapping[str, float] = field(default_factory=dict)

    @cached_property
    def loads(self) -> RigidLoads:
        """Forces that are no joints'."""
        return RigidLoads(self.scene, self.start)

    @cached_property
    def laws(self) -> dict[str, JointLaw]:
        """Laws of the joints, by name."""
        start = LinkStates.of(self.start[None], np.zeros_like(self.start[None]))
        return laws_of(self.scene, start, partial(JointPlace.of, self.scene))

    @cached_property
    def rubbing(self) -> dict[str, DryFriction]:
        """Those of them that are dry friction."""
        return rubbing_of(self.laws)

    def all_open(self) -> dict[str, Touching]:
        """Give all contacts open."""
        return {name: Touching.open(law.contacts) for name, law in self.laws.items()}

    def all_closed(self) -> dict[str, Touching]:
        """Give all contacts closed: they push where bodies overlap."""
        return {name: Touching.shut(law.contacts) for name, law in self.laws.items()}

    def law_states(self, links: LinkStates) -> dict[str, JointState]:
        """Give the state of each law's joint, by law.

        Parameters
        ----------
        links
            How the links move.
        """
        return {name: law.joint.state(links) for name, law in self.laws.items()}

    def wrenches(self, states: RigidStates, contacts: Contacts) -> dict[str, Wrench]:
        """Give what each law exerts, but for dry friction.

        Parameters
        ----------
        states
            The motion.
        contacts
            Which contacts are closed.
        """
        joints = self.law_states(states.links)
        return {name: law.wrench(states.time, joints[name], contacts[name]) for name, law in self.laws.items()}

    def size_of(self, name: str, states: RigidStates, wrench: Wrench) -> Array:
        """Give the size of what a law exerts, as `JointPlace.size` does.

        Parameters
        ----------
        name
            The law.
        states
            The motion.
        wrench
            What it exerts.
        """
        place = self.laws[name].joint
        return place.size(states.links, wrench, place.name in self.scene.open_joints)

    def balance(self, states: RigidStates, contacts: Contacts) -> Balance:
        """Give the forces of a motion.

        Parameters
        ----------
        states
            The motion.
        contacts
            Which contacts are closed.

        Raises
        ------
        SolverError
            When friction locks the linkage.
        """
        unsolved, units, forces = self.unsolved(states, contacts)
        if not self.rubbing:
            return Balance(unsolved.alone, {}, forces)
        if self.at_rest:
            found = np.array([[self.at_rest[name] for name in self.rubbing]] * len(unsolved.alone))
            multipliers = unsolved.forces(found)
        else:
            found, multipliers = unsolved.solve()
        forces[Cause.FRICTION] = forces[Cause.FRICTION] + (units @ found[..., None])[..., 0]
        return Balance(multipliers, dict(zip(self.rubbing, found.T)), forces)

    def unsolved(self, states: RigidStates, contacts: Contacts) -> tuple[FrictionBalance, Array, dict[Cause, Array]]:
        """Give what friction has to fulfil, forces by friction of size 1, and those of all else by cause.

        Parameters
        ----------
        states, contacts
            As of `balance`.

        Returns
        -------
        tuple
            The balance of multipliers, ``(states, 3 links, laws)`` and ``(states, 3 links)`` each.
        """
        links = states.links
        forces = self.loads.by_cause(states.theta, states.time, links)
        joints = self.law_states(links)
        for name, law in self.laws.items():
            wrench = law.wrench(states.time, joints[name], contacts[name])
            forces[law.cause] = forces.get(law.cause, 0.0) + self._on_coordinates(law, joints[name], wrench)
        needed = self.loads.inertia.needed(links, states.acceleration) - sum(forces.values())
        transposed = states.inverse.transpose(0, 2, 1)
        multipliers = (transposed @ needed[..., None])[..., 0]
        shares, units = np.zeros((len(needed), 0)), np.zeros((*needed.shape, 0))
        if self.rubbing:
            units = np.stack([self._unit(law, joints[name]) for name, law in self.rubbing.items()], axis=-1)
            shares = np.stack([law.share(joints[name]) for name, law in self.rubbing.items()], axis=-1)
        return FrictionBalance(multipliers, transposed @ units, shares, self._pressed), units, forces

    def _on_coordinates(self, law: JointLaw, state: JointState, wrench: Wrench) -> Array:
        on = BodyForces.none(len(state.place), len(self.loops.links))
        law.joint.exert(on, state, wrench)
        return on.on_coordinates

    def _unit(self, law: DryFriction, state: JointState) -> Array:
        """Forces on the coordinates by friction of size 1, ``(states, 3 links)``."""
        return self._on_coordinates(law, state, law.joint.effort(state, np.ones_like(state.place)))

    @cached_property
    def _pressed(self) -> list[Index]:
        """Loop equations whose multipliers press the bodies of each friction's joint against each other."""
        points, lines = self.loops.points.name, self.loops.lines.name
        found = []
        for law in self.rubbing.values():
            name = law.joint.name
            if law.joint.slides:
                found.append(np.array([2 * len(points) + lines.index(name)]))
            else:
                found.append(2 * points.index(name) + np.arange(2))
        return found

    def efforts(self, multipliers: Array) -> Array:
        """Efforts at the drives, then at the freedoms (N m or N), ``(states, drives)``.

        Parameters
        ----------
        multipliers
            Those of a balance.
        """
        count = self.loops.drives
        found = np.empty((len(multipliers), count))
        found[:, list(self.loops.drive_order)] = multipliers[:, multipliers.shape[1] - count :]
        return found

    def on_frame(self, states: RigidStates, balance: Balance) -> Array:
        """Force on the frame (N) and its moment about the origin of the ground (N m), ``(states, 3)``.

        The frame gives what the links need, but for weight, loads and drag of the surroundings.
        Source: Berkof and Lowen, Trans. ASME J. Eng. Ind. 91 (1969), p. 21.

        Parameters
        ----------
        states, balance
            A motion, and what acts in it.
        """
        links, rate = states.links, states.acceleration.reshape(len(states.q), -1, 3)
        given = sum((balance.forces[cause] for cause in FROM_OUTSIDE if cause in balance.forces), np.zeros(()))
        needed = (self.loads.inertia.needed(links, states.acceleration) - given).reshape(rate.shape)
        force, place = needed[..., :2], links.pose[:, :-1, :2]
        moment = np.sum(needed[..., 2] + cross(place, force), axis=1)
        bodies = [*self.scene.links]
        for name, freedom in self.scene.freedoms.items():
            first, second = (point.split(".")[0] for point in self.scene.joints[name].connect[:2])
            if freedom.inertia and "ground" in (first, second):  # what turns in the rotor, the frame turns back
                moment = moment + freedom.inertia * rate[:, bodies.index(second if first == "ground" else first), 2]
        return -np.column_stack([force.sum(axis=1), moment])

    def joint_forces(self, states: RigidStates, balance: Balance, contacts: Contacts) -> dict[str, Array]:
        """Force of each joint's first body on its second (N), ``(states, 2)`` each, or of its pin on a body.

        Parameters
        ----------
        states, balance, contacts
            A motion, what acts in it, and which contacts are closed.
        """
        loops, multipliers = self.loops, balance.multipliers
        found: dict[str, list[Array]] = {name: [] for name in self.scene.joints}
        for i, name in enumerate(loops.points.name):
            found[name].append(multipliers[:, 2 * i : 2 * i + 2])
        normals = loops.tangents(states.q, loops.lines)[..., ::-1] * [-1.0, 1.0]
        for i, name in enumerate(loops.lines.name):
            found[name].append(multipliers[:, 2 * len(loops.points) + i, None] * normals[:, i])
        strokes = loops.driven_strokes
        along, first = loops.tangents(states.q, strokes), multipliers.shape[1] - len(strokes)
        for i, name in enumerate(strokes.name):
            found[name][0] = found[name][0] + multipliers[:, first + i, None] * along[:, i]
        joints = self.law_states(states.links)
        for name, wrench in self.wrenches(states, contacts).items():
            self._add_to(found, self.laws[name], wrench)
        for name, size in balance.friction.items():
            law = self.rubbing[name]
            self._add_to(found, law, law.joint.effort(joints[name], size))
        return {
            label: force
            for name, joint in self.scene.joints.items()
            for label, force in _labelled(name, joint.connect, found[name])
        }

    def _add_to(self, found: dict[str, list[Array]], law: JointLaw, wrench: Wrench) -> None:
        """Add a law's force to that of its joint."""
        forces = found[law.joint.name]
        if law.joint.elsewhere:
            return
        if forces:
            forces[0] = forces[0] + wrench.force
        else:
            forces.append(wrench.force)


def _labelled(name: str, connect: tuple[str, ...], forces: list[Array]) -> list[tuple[str, Array]]:
    """Names of a joint's forces, as `joint_names` gives them."""
    if len(connect) == 2:
        return [(name, forces[0])]
    return [(f"{name}:{point.split('.')[0]}", force) for point, force in zip(connect[1:], forces)]
