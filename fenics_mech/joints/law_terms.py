"""A law of a joint as a term: it looks at the frames of the points that it pushes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.geometry import End
from fenics_mech.joints.joint_state import JointLaw, Touching, Wrench
from fenics_mech.joints.link_states import BodyForces, LinkStates
from fenics_mech.terms import Look, Measure, Response, Term

PLACE, RATE = 1e-8, 1e-7  # m or rad, and per second, of central differences: contacts are as stiff as that needs


class LawTerm(Term):
    """What a law exerts on the frames of the points at its joint, by their places and angles."""

    # Which of its contacts are closed is a function of time that is constant between events. A march states it on its
    # way, and afterwards it is known.

    measures = (Measure(Look.PLACE, 0), Measure(Look.PLACE, 1), Measure(Look.ANGLE))

    def __init__(self, name: str, ground: End, ends: Sequence[End], law: JointLaw, start: Sequence[float]) -> None:
        # start (rad)
        super().__init__([(ground, end) for end in ends])
        self.name, self.law, self.start, self.together = name, law, np.array(start), len(ends)
        self.contacts = law.contacts
        self._since, self._states = [-np.inf], [Touching.open(law.contacts)]

    def near(self, t: Array) -> Array:
        """Give the angles at the start: steps in time count whole turns from them."""
        return np.tile(self.start[:, None], (len(t), 1, 3))

    @property
    def closed(self) -> NDArray[np.bool_]:
        """Whether each contact is closed since the last event ``(contacts,)``."""
        return self._states[-1].closed

    @property
    def speed(self) -> Array:
        """Rate of indentation at which each contact began last (m/s or rad/s) ``(contacts,)``."""
        return self._states[-1].speed

    @property
    def closings(self) -> int:
        """How often contacts closed."""
        return sum(int((after.closed & ~one.closed).sum()) for one, after in zip(self._states, self._states[1:]))

    @property
    def openings(self) -> int:
        """How often contacts opened."""
        return sum(int((one.closed & ~after.closed).sum()) for one, after in zip(self._states, self._states[1:]))

    def begin(self, depth: Array) -> None:
        """State which contacts are closed at first, by indentations ``(contacts,)``."""
        if self.law.begins_open and depth.max(initial=0.0) > 0:
            raise SceneError(
                f"at the start the bodies of joint {self.law.joint.name!r} overlap by {depth.max():.3g}",
                place=f"joint_laws.{self.name}",
                hint="Start from another place, where they do not touch",
            )
        self._since, self._states = [-np.inf], [Touching(depth > 0, np.ones(self.contacts))]

    def shut(self) -> None:
        """Close all contacts: they push where bodies overlap."""
        self._since, self._states = [-np.inf], [Touching.shut(self.contacts)]

    def change(self, t: float, contact: int, rate: float) -> None:
        """Close or open a contact after an instant (s), at a rate of indentation."""
        closed, speed = self.closed.copy(), self.speed.copy()
        closed[contact] = not closed[contact]
        speed[contact] = rate if closed[contact] else speed[contact]
        self._since.append(t)
        self._states.append(Touching(closed, speed))

    def depths(self, x: Array, v: Array) -> tuple[Array, Array]:
        """Give how far bodies are in each other at each contact, and the rate of that ``(contacts, instants)`` each."""
        return self.law.depths(self.law.joint.state(links_of(x, v)))

    def exerted(self, t: Array, x: Array, v: Array) -> Array:
        """Give forces and moments on the frames ``(instants, frames, 3)`` (N, N m)."""
        found, since = np.zeros(x.shape), np.searchsorted(self._since, t) - 1
        for k in np.unique(since):
            here = since == k
            links = links_of(x[here], v[here])
            state, on = self.law.joint.state(links), BodyForces.none(len(links.pose), x.shape[1])
            self.law.joint.exert(on, state, self.law.wrench(t[here], state, self._states[k]))
            found[here] = on.values[:, :-1]
        return found

    def size(self, t: Array, x: Array, v: Array, alone: bool) -> Array:
        """Give the size of what the law exerts on the second body; see `JointPlace.size` ``(instants,)`` (N or N m)."""
        on = self.exerted(t, x, v)[:, self.law.joint.bodies[1]]
        wrench = Wrench(on[:, :2], on[:, 2], np.zeros_like(on[:, :2]))
        return self.law.joint.size(links_of(x, v), wrench, alone)

    def respond(self, t: Array, x: Array, v: Array) -> Response:
        """Give minus what the law exerts, and its derivatives by central differences."""
        if self.contacts and not self.closed.any() and (t > self._since[-1]).all():
            return Response(np.zeros(x.shape))
        (T, k, m), n = x.shape, x[0].size
        steps = np.concatenate([np.zeros((1, n)), PLACE * np.eye(n), -PLACE * np.eye(n), np.zeros((2 * n, n))])
        rates = np.roll(steps, 2 * n, axis=0) * (RATE / PLACE)
        several = [(y + by.reshape(-1, 1, k, m)).reshape(-1, k, m) for y, by in ((x, steps), (v, rates))]
        values = self.exerted(np.tile(t, len(steps)), *several).reshape(len(steps), T, n)
        ahead, back, faster, slower = np.moveaxis(values[1:].reshape(4, n, T, n), 1, -1)
        by_place, by_rate = (back - ahead) / (2 * PLACE), (slower - faster) / (2 * RATE)
        return Response(-values[0].reshape(x.shape), by_place[:, None], by_rate[:, None])


def links_of(x: Array, v: Array) -> LinkStates:
    """Give frames as bodies, with the ground behind them."""
    # x, v (instants, frames, 3) each
    return LinkStates(*(np.pad(y, ((0, 0), (0, 1), (0, 0))) for y in (x, v)))
