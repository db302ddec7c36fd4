"""Where a joint of two bodies is, how its bodies move against each other, and what a law exerts on them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech.joints.link_states import BodyForces, LinkStates, quarter
from fenics_mech.scene import Prismatic, Scene, Slot
from fenics_mech.terms.causes import Cause


@dataclass(frozen=True)
class JointState:
    """How the second body of a joint moves against the first, at many states."""

    place: Array  # angle (rad) or stroke (m), and its rate, (states,)
    rate: Array
    gap: Array  # from the point of the first body to that of the second (m, m/s), in the fixed frame, (states, 2)
    gap_rate: Array
    arms: tuple[Array, Array]  # the points, seen from the origins of their bodies (m), (states, 2) each
    turning: tuple[Array, Array]  # angular velocities of both bodies (rad/s), (states,) each
    along: Array  # direction of the guide, (states, 2); of a pin the x axis of the first body
    angle: Array  # of the second body's frame against the first's (rad), (states,)
    links: LinkStates  # how all links move, for laws that look at another joint too


@dataclass(frozen=True)
class Wrench:
    """What a law exerts on the second body of a joint; the opposite acts on the first."""

    force: Array  # along X and Y (N), (states, 2)
    moment: Array  # N m, (states,)
    offset: Array  # where the force acts, seen from the second body's point (m), (states, 2)


@dataclass(frozen=True)
class JointPlace:
    """Two bodies and their points at a joint."""

    name: str  # the joint
    bodies: tuple[int, int]  # their indices among the links; -1 is the ground
    points: tuple[tuple[float, float], tuple[float, float]]  # the points in the frames of their bodies (m)
    guide: float  # direction of the guide in the first body's frame (rad); 0 of a pin
    slides: bool  # whether the second body slides along a guide
    turn: float  # angle of the second body's frame in the first's that a prismatic joint holds (rad); 0 of others
    # whether the opposite of what a law exerts on the second body acts elsewhere than on the first: another side has
    # it, as a follower has that of its cam
    elsewhere: bool = False

    @classmethod
    def of(cls, scene: Scene, name: str) -> JointPlace:
        """Find a joint of two bodies."""
        joint, index = scene.joints[name], {"ground": -1} | {link: i for i, link in enumerate(scene.links)}
        (first, at), (second, pin) = map(scene.point, joint.connect)
        slides = isinstance(joint, Slot | Prismatic)
        guide = scene.guide_angle(joint) if isinstance(joint, Slot | Prismatic) else 0.0
        turn = joint.turn if isinstance(joint, Prismatic) else 0.0
        return cls(name, (index[first], index[second]), (at, pin), guide, slides, turn)

    @property
    def ends(self) -> tuple[float, float]:
        """Strokes at both ends of the guide (m): it is as long as it may be."""
        return -np.inf, np.inf

    def state(self, links: LinkStates) -> JointState:
        """Give how the bodies of the joint move."""
        first, second = self.bodies
        arms = links.turned(first, self.points[0]), links.turned(second, self.points[1])
        (at, speed), (to, other) = links.point(first, arms[0]), links.point(second, arms[1])
        gap, gap_rate = to - at, other - speed
        along = links.turned(first, (np.cos(self.guide), np.sin(self.guide)))
        turning, angle = (
            (links.rate[:, first, 2], links.rate[:, second, 2]),
            links.pose[:, second, 2] - links.pose[:, first, 2],
        )
        if self.slides:
            seen = gap_rate - turning[0][:, None] * quarter(gap)  # by an observer on the first body
            place, rate = np.sum(along * gap, axis=-1), np.sum(along * seen, axis=-1)
        else:
            place, rate = angle, turning[1] - turning[0]
        return JointState(place, rate, gap, gap_rate, arms, turning, along, angle, links)

    def pin(self, state: JointState) -> Array:
        """Give the place of the second body's point (m), ``(states, 2)``."""
        return state.links.point(self.bodies[1], state.arms[1])[0]

    def effort(self, state: JointState, size: Array) -> Wrench:
        """Give a force along the guide, or a moment at a pin, as a wrench."""
        # size (states,)
        none = np.zeros((len(size), 2))
        if self.slides:
            return Wrench(size[:, None] * state.along, np.zeros_like(size), none)
        return Wrench(none, size, none)

    def size(self, links: LinkStates, wrench: Wrench, alone: bool) -> Array:
        """Give the size of a wrench on the second body (N or N m), ``(states,)``."""
        # It is the force along the guide or the moment about the pin; without a constraint it is the size of the
        # force.
        if alone:
            return np.asarray(np.linalg.norm(wrench.force, axis=-1))
        return np.sum(wrench.force * self.state(links).along, axis=-1) if self.slides else wrench.moment

    def exert(self, on: BodyForces, state: JointState, wrench: Wrench) -> None:
        """Add a wrench on the second body, and the opposite one on the first."""
        (first, second), (arm, other) = self.bodies, state.arms
        on.add(second, other + wrench.offset, wrench.force)
        on.turn(second, wrench.moment)
        if self.elsewhere:
            return
        on.add(first, arm + state.gap + wrench.offset, -wrench.force)
        on.turn(first, -wrench.moment)


@dataclass(frozen=True)
class Touching:
    """Which contacts of a law are closed, and how fast they closed."""

    closed: NDArray[np.bool_]  # (contacts,)
    speed: Array  # rate of indentation at the beginning of each (m/s or rad/s), (contacts,)

    @classmethod
    def open(cls, contacts: int) -> Touching:
        """Give contacts that are all open."""
        return cls(np.zeros(contacts, dtype=bool), np.ones(contacts))

    @classmethod
    def shut(cls, contacts: int) -> Touching:
        """Give contacts that are all closed: they push where bodies overlap."""
        return cls(np.ones(contacts, dtype=bool), np.ones(contacts))


class JointLaw(Protocol):
    """A law by which a joint's bodies push each other, from their state."""

    @property
    def joint(self) -> JointPlace:
        """Where it acts."""

    @property
    def cause(self) -> Cause:
        """Under which cause its power is listed."""

    @property
    def contacts(self) -> int:
        """Number of places at which the bodies may touch."""

    @property
    def begins_open(self) -> bool:
        """Whether nothing may touch at the start, as the force goes by the rate at which a contact began."""

    def wrench(self, time: Array, state: JointState, touching: Touching) -> Wrench:
        """What acts on the second body at times (s), ``(states,)``."""

    def depths(self, state: JointState) -> tuple[Array, Array]:
        """Indentation at each contact, negative where it is open, and its rate, ``(contacts, states)`` each."""


class WithoutContact:
    """A law by which bodies do not touch."""

    contacts = 0
    begins_open = True

    def depths(self, state: JointState) -> tuple[Array, Array]:
        """Give no contact."""
        none = np.zeros((0, len(state.place)))
        return none, none
