"""The equation of a free motion at many states at once: what is left of it, its tangents, its accelerations.

Unknown are the elastic coordinates q and the angles or strokes r of the freedoms, ``y = (q, r)``. The links are
measured against the rigid motion at r. The rows of q are those of (4.66). The row of a freedom is the principle of
virtual work on the bent mechanism: the effort that a drive there would need is the one that acts. See `virtual_work`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fenics_mech._arrays import Array, solved, times
from fenics_mech.effects.joint_frames import LawForces
from fenics_mech.forces.bent_joints import BentJoints
from fenics_mech.forces.elastic_response import ElasticResponse, response_at
from fenics_mech.forces.joint_forces import nodal_forces
from fenics_mech.forces.virtual_work import Forces
from fenics_mech.joints.joint_state import JointLaw, Touching
from fenics_mech.joints.link_states import LinkStates
from fenics_mech.kinematics.free_linkage import FreeLinkage
from fenics_mech.kinematics.influence import drive_influences
from fenics_mech.kinematics.motion import Motion, coordinates
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.modal_damping import modal_damping
from fenics_mech.response.setup import moved
from fenics_mech.response.transient.course import FreeCourse
from fenics_mech.scene import Scene
from fenics_mech.scene.start_state import StartState

States = tuple[Array, Array, Array]  # y, y' and y'', ``(times, coordinates)`` each


@dataclass(frozen=True)
class DifferenceSteps:
    """Steps of central differences by the freedoms."""

    place: float = 1e-5  # rad, or of the linkage's size: error about 1e-10
    rate: float = 1e-3  # of the fastest rate there is, or of 1 rad/s
    elastic: float = 1e-6  # m or rad
    elastic_rate: float = 1e-3  # m/s or rad/s
    second: float = 1.0  # rad/s^2: the equation is linear in them, but for friction


DIFFERENCES = DifferenceSteps()


@dataclass
class FreeState:
    """The equation of a free motion near positions that are known.

    Parameters
    ----------
    scene
        The scene, with a freedom for all that can move.
    system
        Its mechanism at the start.
    """

    scene: Scene
    system: System
    contacts: dict[str, Touching] = field(init=False)  # which contacts are closed, by law
    known_links: Array = field(init=False)  # coordinates at the position that others are near to, ``(3 links,)``

    def __post_init__(self) -> None:
        """Start from the position at time 0, without contact."""
        self.linkage, self.joints = FreeLinkage(self.scene), None
        if self.scene.joint_laws:
            self.joints = BentJoints.of(self.scene, self.system, of_sines=self.system.terms.law is not None)
        self.rewind()
        self.size, self.freedoms = self.system.size, len(self.scene.freedoms)

    def rewind(self, start: StartState | None = None) -> None:
        """Take the position at a start as the one that others are near to.

        Parameters
        ----------
        start
            The start; None for time 0.
        """
        motion = self.system.motion
        self.known_links = coordinates(motion.position, motion.angle)[0]
        if start is not None and start.links is not None:
            self.known_links = start.links
        self.contacts = {name: Touching.open(law.contacts) for name, law in self.laws.items()}
        self._held: dict[str, float] = {}  # where friction was held at the end of the last step, by law

    def hold(self, time: Array, y: Array, rate: Array) -> float:
        """Take dry friction as linear about where Newton's method has brought it; say how far that is from its law.

        Parameters
        ----------
        time, y, rate
            As of `accelerations`.
        """
        assert self.joints is not None
        self.contacts, off = self.joints.hold(self.joint_links(time, y, rate), self.contacts, self._held)
        return off

    def let_go(self) -> None:
        """Take dry friction by its law."""
        held = {name: one.held for name, one in self.contacts.items() if one.held is not None}
        self._held |= {name: float(one[-1]) for name, one in held.items()}
        self.contacts |= {name: replace(self.contacts[name], held=None) for name in held}

    @property
    def laws(self) -> dict[str, JointLaw]:
        """The joint laws, by name."""
        return {} if self.joints is None else self.joints.laws

    def move_on(self, time: float, y: Array, rate: Array) -> None:
        """Take the position at a time as the one that others are near to.

        Parameters
        ----------
        time
            Time (s).
        y, rate
            Coordinates and rates there, ``(coordinates,)`` each.

        Raises
        ------
        AssemblyError
            When the freedoms hardly say how the links move there.
        """
        here = self._motion(np.array([time]), (y[None], rate[None], np.zeros((1, len(y)))))
        q = coordinates(here.position, here.angle)[0]
        self.linkage.refuse_dead_centre(time, q)
        self.known_links = q

    def system_at(self, time: Array, states: States) -> System:
        """Give the mechanism as it moves.

        Parameters
        ----------
        time
            Times (s), ``(times,)``.
        states
            y, y' and y'' there, ``(times, coordinates)`` each.
        """
        return moved(self.scene, self.system, self._motion(time, states))

    def _motion(self, time: Array, states: States, near: Array | None = None) -> Motion:
        """Give the rigid motion, near to coordinates of the links or else to those that are known."""
        if near is None:
            near = np.tile(self.known_links, (len(time), 1))
        places, rates, seconds = (part[:, self.size :] for part in states)
        return self.linkage.motion(time, places, rates, seconds, near)

    def along(self, states: States, course: FreeCourse) -> tuple[System, ElasticResponse]:
        """Give the mechanism and its response at states whose y'' fulfils the equation or not.

        Parameters
        ----------
        states
            As of `system_at`.
        course
            The motion: its times, coordinates of the links near to the positions, and what joint laws exert there.
        """
        system = moved(self.scene, self.system, self._motion(course.time, states, course.links))
        response = self.response(system, states)
        if self.joints is None or course.laws is None:
            return system, response
        return _with(system, self.joints.on_nodes(system, response, course.laws.forces).values()), response

    def positions(self, time: Array, y: Array) -> Array:
        """Give the coordinates of the links, ``(times, 3 links)``, at coordinates y, ``(times, coordinates)``.

        Parameters
        ----------
        time, y
            Times (s) and y near to the position that is known.
        """
        motion = self._motion(time, (y, np.zeros_like(y), np.zeros_like(y)))
        return coordinates(motion.position, motion.angle)

    def response(self, system: System, states: States) -> ElasticResponse:
        """Give the response of the links.

        Parameters
        ----------
        system, states
            The mechanism at states, and these: see `system_at`.
        """
        equation = Equation(system, modal_damping(self.scene.damping.ratio, system))
        q, rate, second = (part[:, : self.size] for part in states)
        return response_at(equation, q, rate, second)

    def with_laws(self, system: System, response: ElasticResponse) -> System:
        """Give the mechanism with what its joint laws exert in a motion.

        Parameters
        ----------
        system, response
            The mechanism and its motion.
        """
        if self.joints is None:
            return system
        return _with(system, self.joints.forces(system, response, self.contacts).values())

    def residual(self, time: Array, states: States) -> Array:
        """What is left of the equation: forces on q (N, N m) and efforts (N m or N), ``(times, coordinates)``.

        Parameters
        ----------
        time, states
            As of `system_at`.
        """
        system = self.system_at(time, states)
        response = self.response(system, states)
        return self._left(self.with_laws(system, response), response, states)

    def _left(self, system: System, response: ElasticResponse, states: States) -> Array:
        """What is left of the equation by the forces of a system."""
        forces, time = nodal_forces(system, response), system.motion.time
        needed = list(Forces(self.scene, system, response).efforts().values())[len(self.scene.drives) :]
        places, rates, seconds = (part[:, self.size :].T for part in states)
        rows = [
            effort - freedom.effort_at(time, place, rate) + freedom.inertia * second
            for effort, freedom, place, rate, second in zip(
                needed, self.scene.freedoms.values(), places, rates, seconds
            )
        ]
        return np.column_stack([system.on_coordinates(forces), *rows])

    def _smooth(self, time: Array, states: States) -> Array:
        """What is left without joint laws, then the forces of the joints that rub, ``(times, coordinates + rows)``."""
        system = self.system_at(time, states)
        response = self.response(system, states)
        left = self._left(system, response, states)
        if not self.rubs:
            return left
        assert self.joints is not None
        forces = nodal_forces(system, response)
        return np.hstack([left, self.joints.pressing(system, self.joints.states(system, response), forces)])

    @property
    def rubs(self) -> bool:
        """Whether joints have dry friction."""
        return self.joints is not None and bool(self.joints.rubbing)

    def tangents(self, time: Array, states: States) -> tuple[Array, Array, Array]:
        """Tangents by y'', y' and y, ``(times, coordinates, coordinates)`` each, for Newton's method.

        Rows and columns of the freedoms are by central differences. With the freedoms' rows by symmetry alone, without
        gyroscopic forces, Newton's method gains less than half a digit in an iteration: bent members that hardly
        stretch make the matrices ill-conditioned. Forces of joint laws change too fast for these differences, and have
        their own. How their directions turn with the mechanism is left out.

        Parameters
        ----------
        time, states
            As of `system_at`.
        """
        n, size = self.size, self.size + self.freedoms
        system = self.system_at(time, states)
        equation = Equation(system, modal_damping(self.scene.damping.ratio, system))
        by_q = equation.about(*(part[:, :n] for part in states)).full
        fastest = max(1.0, float(np.abs(states[1][:, n:]).max(initial=0.0)))
        of_freedoms = DIFFERENCES.second, DIFFERENCES.rate * fastest, DIFFERENCES.place
        of_links = DIFFERENCES.second if self.rubs else 0.0, DIFFERENCES.elastic_rate, DIFFERENCES.elastic
        steps = [np.repeat([elastic, free], (n, size - n)) for elastic, free in zip(of_links, of_freedoms)]
        columns = self._differences(time, states, steps)
        found = [part[:, :size].copy() for part in columns]
        for whole, elastic in zip(found, by_q):
            whole[:, :n, :n] = elastic
        found[0][:, n:, :n] = found[0][:, :n, n:].transpose(0, 2, 1)
        if self.joints is not None:
            pressing = [part[:, size:] for part in columns] if self.rubs else None
            self._add_laws(found, pressing, system, states)
        return found[0], found[1], found[2]

    def _add_laws(self, tangents: list[Array], pressing: list[Array] | None, system: System, states: States) -> None:
        """Add what joint laws do to tangents by y'', y' and y; `pressing` has those of the forces where joints rub."""
        assert self.joints is not None
        response = self.response(system, states)
        slopes, reach = self.joints.slopes(system, response, self.contacts), self._reach(system, response)
        back = -reach.transpose(0, 2, 1)
        tangents[1] += back @ slopes.by_rate @ reach
        tangents[2] += back @ slopes.by_place @ reach
        for i, part in enumerate(pressing or ()):
            tangents[i] += back @ slopes.by_pressing @ part

    def _reach(self, system: System, response: ElasticResponse) -> Array:
        """How the frames of the joints move by the coordinates, ``(times, 3 frames, coordinates)``."""
        assert self.joints is not None
        v, transformation = system.to_links(response.displacement), system.transformation
        each = np.broadcast_to(np.eye(self.size), (len(v), self.size, self.size))
        moved = transformation.forward(system.values[:, None], each)
        nodes = system.on_nodes(moved.reshape(-1, moved.shape[-1])).reshape(len(v), self.size, -1)
        forces = Forces(self.scene, system, response)
        units = drive_influences(self.scene, system.motion)[len(self.scene.drives) :]
        rates = [
            self.joints.frames.states(by.motion, v, by.deformation).rate[:, :-1].reshape(len(v), -1)
            for by in forces.rates_of(units)
        ]
        return np.concatenate(
            [self.joints.frames.reach(system.motion, v, nodes), *(rate[..., None] for rate in rates)], axis=2
        )

    def _differences(self, time: Array, states: States, steps: Sequence[Array]) -> list[Array]:
        """Tangents of `_smooth` by y'', y' and y, ``(times, rows, coordinates)`` each; 0 where a step is 0.

        The steps of each coordinate are by order too.
        """
        wanted = [(order, j) for order in range(3) for j in np.flatnonzero(steps[order])]
        ahead = np.zeros((3, 2 * len(wanted), 1, len(steps[0])))
        for k, (order, j) in enumerate(wanted):
            ahead[order, 2 * k : 2 * k + 2, 0, j] = steps[order][j], -steps[order][j]
        place, rate, second = (
            (part + by).reshape(-1, part.shape[1]) for part, by in zip(states, (ahead[2], ahead[1], ahead[0]))
        )
        values = self._smooth(np.tile(time, 2 * len(wanted)), (place, rate, second))
        values = values.reshape(len(wanted), 2, len(time), -1)
        found = np.zeros((3, len(time), values.shape[-1], len(steps[0])))
        for (order, j), (up, down) in zip(wanted, values):
            found[order, :, :, j] = (up - down) / (2 * steps[order][j])
        return list(found)

    def accelerations(self, time: Array, y: Array, rate: Array) -> Array:
        """Give y'' at states, ``(times, coordinates)``: without friction the equation is linear in it.

        So are the forces of the joints, of which dry friction is a share.

        Parameters
        ----------
        time
            Times (s), ``(times,)``.
        y, rate
            Coordinates and rates, ``(times, coordinates)`` each.

        Raises
        ------
        SolverError
            When friction locks the linkage.
        """
        n, size, still = self.size, self.size + self.freedoms, np.zeros_like(y)
        system = self.system_at(time, (y, rate, still))
        ahead = np.vstack([np.zeros(size), DIFFERENCES.second * np.eye(size)[0 if self.rubs else n :]])
        several = (len(ahead), *y.shape)
        y_all, rates, seconds = (np.broadcast_to(part, several).reshape(-1, size) for part in (y, rate, ahead[:, None]))
        values = self._smooth(np.tile(time, len(ahead)), (y_all, rates, seconds)).reshape(*several[:2], -1)
        by = np.moveaxis(values[1:] - values[0], 0, -1) / DIFFERENCES.second  # (times, rows, columns)
        left, mass = values[0, :, :size], np.zeros((len(time), size, size))
        mass[:, :n, :n] = Equation(system).mass_at(y[:, :n]).full
        mass[:, :, n:] = by[:, :size, -self.freedoms :] if self.freedoms else 0.0
        mass[:, n:, :n] = mass[:, :n, n:].transpose(0, 2, 1)
        if self.joints is None:
            return -solved(mass, left)
        response = self.response(system, (y, rate, still))
        back = self._reach(system, response).transpose(0, 2, 1)
        acting = self.joints.acting(system, response, self.contacts)
        second = solved(mass, times(back, acting.exerted) - left)
        if acting.friction is None:
            return second
        # accelerations by friction of size 1 change the joints' forces too
        moved = np.asarray(np.linalg.solve(mass, back @ acting.units), dtype=np.float64)
        pressing = by[:, size:]
        sizes, _ = acting.friction.with_motion(times(pressing, second), pressing @ moved).solve()
        return np.asarray(second + times(moved, sizes))

    def joint_links(self, time: Array, y: Array, rate: Array) -> LinkStates:
        """Give the frames that the joint laws act on.

        Parameters
        ----------
        time, y, rate
            As of `accelerations`.
        """
        assert self.joints is not None
        states = y, rate, np.zeros_like(y)
        system = self.system_at(time, states)
        return self.joints.states(system, self.response(system, states))

    def exerted(self, time: Array, states: States) -> tuple[LinkStates, dict[str, LawForces], Array]:
        """Give the frames that the joint laws act on, what each law exerts, and twice the linear strain energy (J).

        Parameters
        ----------
        time, states
            As of `system_at`.
        """
        assert self.joints is not None
        system = self.system_at(time, states)
        response = self.response(system, states)
        v, laws = system.to_links(response.displacement), self.joints.forces(system, response, self.contacts)
        return self.joints.states(system, response), laws, np.sum(v * (system.nodal_stiffness @ v.T).T, axis=1)


def _with(system: System, laws: Iterable[LawForces]) -> System:
    return system.with_terms(replace(system.terms, joint_laws=tuple(laws)))
