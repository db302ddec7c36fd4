"""The equation of a free motion at many states at once: what is left of it, its tangents, its accelerations.

Unknown are the elastic coordinates q and the angles or strokes r of the freedoms, ``y = (q, r)``. The links are
measured against the rigid motion at r. The rows of q are those of (4.66). The row of a freedom is the principle of
virtual work on the bent mechanism: the effort that a drive there would need is the one that acts. See `virtual_work`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.forces.elastic_response import ElasticResponse, response_at
from fenics_mech.forces.joint_forces import nodal_forces
from fenics_mech.forces.virtual_work import Forces
from fenics_mech.kinematics.free_linkage import FreeLinkage
from fenics_mech.kinematics.motion import Motion, coordinates
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.modal_damping import modal_damping
from fenics_mech.response.setup import moved
from fenics_mech.scene import Scene

States = tuple[Array, Array, Array]  # y, y' and y'', ``(times, coordinates)`` each


@dataclass(frozen=True)
class DifferenceSteps:
    """Steps of central differences by the freedoms."""

    place: float = 1e-5  # rad, or of the linkage's size: error about 1e-10
    rate: float = 1e-3  # of the fastest rate there is, or of 1 rad/s
    elastic: float = 1e-6  # m or rad
    elastic_rate: float = 1e-3  # m/s or rad/s
    second: float = 1.0  # rad/s^2: the equation is linear in them


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
    _known: tuple[float, Array, Array] = field(init=False)  # time (s), coordinates of the links and their rates

    def __post_init__(self) -> None:
        """Start from the position at time 0."""
        self.linkage = FreeLinkage(self.scene)
        self.rewind()
        self.size, self.freedoms = self.system.size, len(self.scene.freedoms)

    def rewind(self) -> None:
        """Take the position at time 0 as the one that others are near to."""
        start = self.system.motion
        q = coordinates(start.position, start.angle)[0]
        self._known = 0.0, q, np.zeros_like(q)

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
        q, velocity = coordinates(here.position, here.angle)[0], coordinates(here.velocity, here.omega)[0]
        self.linkage.refuse_dead_centre(time, q)
        self._known = time, q, velocity

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
            then, q, velocity = self._known
            near = q + velocity * (time - then)[:, None]
        places, rates, seconds = (part[:, self.size :] for part in states)
        return self.linkage.motion(time, places, rates, seconds, near)

    def along(self, time: Array, states: States, near: Array) -> tuple[System, ElasticResponse]:
        """Give the mechanism and its response at states whose y'' fulfils the equation or not.

        Parameters
        ----------
        time, states
            As of `system_at`.
        near
            Coordinates of the links near to the positions, ``(times, 3 links)``.
        """
        system = moved(self.scene, self.system, self._motion(time, states, near))
        return system, self._response(system, states)

    def positions(self, time: Array, y: Array) -> Array:
        """Give the coordinates of the links, ``(times, 3 links)``, at coordinates y, ``(times, coordinates)``.

        Parameters
        ----------
        time, y
            Times (s) and y near to the position that is known.
        """
        motion = self._motion(time, (y, np.zeros_like(y), np.zeros_like(y)))
        return coordinates(motion.position, motion.angle)

    def _response(self, system: System, states: States) -> ElasticResponse:
        equation = Equation(system, modal_damping(self.scene.damping.ratio, system))
        q, rate, second = (part[:, : self.size] for part in states)
        return response_at(equation, q, rate, second)

    def residual(self, time: Array, states: States) -> Array:
        """What is left of the equation: forces on q (N, N m) and efforts (N m or N), ``(times, coordinates)``.

        Parameters
        ----------
        time, states
            As of `system_at`.
        """
        system = self.system_at(time, states)
        response = self._response(system, states)
        forces = nodal_forces(system, response)
        needed = list(Forces(self.scene, system, response).efforts().values())[len(self.scene.drives) :]
        places, rates, seconds = (part[:, self.size :].T for part in states)
        rows = [
            effort - freedom.effort_at(time, place, rate) + freedom.inertia * second
            for effort, freedom, place, rate, second in zip(
                needed, self.scene.freedoms.values(), places, rates, seconds
            )
        ]
        return np.column_stack([system.on_coordinates(forces), *rows])

    def tangents(self, time: Array, states: States) -> tuple[Array, Array, Array]:
        """Tangents by y'', y' and y, ``(times, coordinates, coordinates)`` each, for Newton's method.

        Rows and columns of the freedoms are by central differences. With the freedoms' rows by symmetry alone, without
        gyroscopic forces, Newton's method gains less than half a digit in an iteration: bent members that hardly
        stretch make the matrices ill-conditioned.

        Parameters
        ----------
        time, states
            As of `system_at`.
        """
        count, n = len(time), self.size
        system = self.system_at(time, states)
        equation = Equation(system, modal_damping(self.scene.damping.ratio, system))
        by_q = equation.about(states[0][:, :n], states[1][:, :n]).full
        found = [np.zeros((count, n + self.freedoms, n + self.freedoms)) for _ in range(3)]
        fastest = max(1.0, float(np.abs(states[1][:, n:]).max(initial=0.0)))
        steps = {2: DIFFERENCES.second, 1: DIFFERENCES.rate * fastest, 0: DIFFERENCES.place}
        by_r = self._differences(time, states, steps, range(n, n + self.freedoms))
        for whole, elastic, columns in zip(found, by_q, by_r):
            whole[:, :n, :n], whole[:, :, n:] = elastic, columns
        found[0][:, n:, :n] = found[0][:, :n, n:].transpose(0, 2, 1)
        steps = {1: DIFFERENCES.elastic_rate, 0: DIFFERENCES.elastic}
        if n:
            for whole, columns in zip(found[1:], self._differences(time, states, steps, range(n))):
                whole[:, n:, :n] = columns[:, n:]
        return found[0], found[1], found[2]

    def _differences(self, time: Array, states: States, steps: dict[int, float], columns: range) -> tuple[Array, ...]:
        """Some columns of tangents, ``(times, coordinates, columns)`` each; `steps` are by order of the derivative."""
        several = []
        for which, step in steps.items():
            for j in columns:
                for sign in (1.0, -1.0):
                    other = [part.copy() for part in states]
                    other[which][:, j] += sign * step
                    several.append(other)
        joined = tuple(np.concatenate(parts) for parts in zip(*several))
        values = self.residual(np.tile(time, len(several)), (joined[0], joined[1], joined[2]))
        values = values.reshape(len(steps), len(columns), 2, len(time), -1)
        by = (values[:, :, 0] - values[:, :, 1]) / (2 * np.array(list(steps.values())))[:, None, None, None]
        return tuple(np.moveaxis(part, 0, -1) for part in by)

    def _mass(self, time: Array, states: States) -> Array:
        """Tangent by y'', ``(times, coordinates, coordinates)``: it is exact and symmetric."""
        n = self.size
        mass = np.zeros((len(time), n + self.freedoms, n + self.freedoms))
        mass[:, :n, :n] = Equation(self.system_at(time, states)).linear.mass.full
        mass[:, :, n:] = self._differences(time, states, {2: DIFFERENCES.second}, range(n, n + self.freedoms))[0]
        mass[:, n:, :n] = mass[:, :n, n:].transpose(0, 2, 1)
        return mass

    def accelerations(self, time: Array, y: Array, rate: Array) -> Array:
        """Give y'' at states, ``(times, coordinates)``: the equation is linear in it.

        Parameters
        ----------
        time
            Times (s), ``(times,)``.
        y, rate
            Coordinates and rates, ``(times, coordinates)`` each.
        """
        states = y, rate, np.zeros_like(y)
        mass = self._mass(time, states)
        return np.asarray(-np.linalg.solve(mass, self.residual(time, states)[..., None])[..., 0])
