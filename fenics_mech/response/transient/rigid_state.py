"""The equation of a motion of rigid links at many states at once, for the steps of `stepping`.

Unknown are the angles and strokes r of the freedoms. The links follow from the loop equations. The
equation of each freedom says that the effort which a drive there would need is the one that acts.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import AssemblyError, SolverError
from fenics_mech.joints.joint_state import JointLaw, Touching
from fenics_mech.joints.link_states import LinkStates
from fenics_mech.kinematics.assembly import ASSEMBLY
from fenics_mech.kinematics.free_linkage import FreeLinkage
from fenics_mech.mechanism.rigid_dynamics import Balance, RigidDynamics, RigidStates
from fenics_mech.response.transient.course import StartState
from fenics_mech.scene import Scene

States = tuple[Array, Array, Array]  # r, r' and r'', ``(times, freedoms)`` each


@dataclass(frozen=True)
class RigidDifferences:
    """Steps of central differences, and limits of the accelerations that friction makes nonlinear."""

    place: float = 1e-7  # rad or m: contacts are as stiff as that needs
    rate: float = 1e-7  # of the fastest rate there is, or of 1 rad/s
    width: float = 0.03  # the same at most, of the width over which dry friction changes its sense
    second: float = 1.0  # rad/s^2 or m/s^2
    most_iterations: int = 30
    converged: float = 1e-12  # of the accelerations that the forces of the joints would give, each alone
    near: float = 0.05  # rad or m, between freedoms, up to which the Jacobian of one position serves at the other
    chords: int = 6  # iterations with it


DIFFERENCES = RigidDifferences()


@dataclass(frozen=True)
class Pose:
    """Positions of the links.

    Parameters
    ----------
    given
        Angles and strokes of drives and freedoms, ``(states, drives)``.
    q, inverse
        Coordinates of the links, ``(states, 3 links)``, and the inverse of the loop equations' Jacobian.
    """

    given: Array
    q: Array
    inverse: Array

    def repeated(self, times: int) -> Pose:
        """Give the positions several times, one after the other.

        Parameters
        ----------
        times
            How often.
        """
        return Pose(np.tile(self.given, (times, 1)), np.tile(self.q, (times, 1)), np.tile(self.inverse, (times, 1, 1)))

    def beside(self, other: Pose) -> Pose:
        """Give these positions and then others.

        Parameters
        ----------
        other
            The others.
        """
        pairs = (self.given, other.given), (self.q, other.q), (self.inverse, other.inverse)
        return Pose(*(np.concatenate(pair) for pair in pairs))


@dataclass
class RigidState:
    """The equation of a motion of rigid links near positions that are known.

    Parameters
    ----------
    scene
        The scene, with a freedom for all that can move and no drive leads.
    linkage
        Its links at any angles and strokes of the freedoms.
    """

    scene: Scene
    linkage: FreeLinkage
    linear: bool = field(default=False, init=False)
    contacts: dict[str, Touching] = field(init=False)  # which contacts are closed, by law
    known_links: Array = field(init=False)  # coordinates at the position that others are near to, ``(3 links,)``
    _last: Pose | None = field(default=None, init=False)  # that was asked for

    def __post_init__(self) -> None:
        """Start from the position at time 0, without contact."""
        self.dynamics = RigidDynamics(self.scene, self.linkage.loops, self.linkage.start)
        self.rewind()

    def rewind(self, start: StartState | None = None) -> None:
        """Take the position at a start as the one that others are near to, with all contacts open.

        Parameters
        ----------
        start
            The start; None for time 0.
        """
        self.known_links = self.linkage.start if start is None or start.links is None else start.links
        self.contacts, self._last = self.dynamics.all_open(), None

    def move_on(self, states: RigidStates) -> None:
        """Take a position as the one that others are near to.

        Parameters
        ----------
        states
            The motion at one time.

        Raises
        ------
        AssemblyError
            When the freedoms hardly say how the links move there.
        """
        self.linkage.refuse_dead_centre(float(states.time[0]), states.q[0])
        self.known_links = states.q[0]

    def states(self, time: Array, states: States) -> RigidStates:
        """Give the motion of the links.

        Parameters
        ----------
        time
            Times (s) near to that of the position that is known, ``(times,)``.
        states
            Angles and strokes of the freedoms and two derivatives, ``(times, freedoms)`` each.

        Raises
        ------
        AssemblyError
            When the links cannot be assembled so, or their motion is not determined there.
        """
        given = self.linkage.given(time, states)
        return self._moved(time, states[0], given, self._pose_near(time, given[0]))

    @property
    def laws(self) -> dict[str, JointLaw]:
        """The joint laws, by name."""
        return self.dynamics.laws

    def joint_links(self, time: Array, place: Array, rate: Array) -> LinkStates:
        """Give how the links move, without their accelerations.

        Parameters
        ----------
        time
            As of `states`.
        place, rate
            Angles and strokes of the freedoms, and their rates, ``(times, freedoms)`` each.
        """
        return self.states(time, (place, rate, np.zeros_like(place))).links

    def _pose_near(self, time: Array, given: Array) -> Pose:
        """Pose of the links near to the last one that was asked for, or else to the position that is known."""
        last = self._last
        if last is None or last.given.shape != given.shape or np.abs(given - last.given).max() > DIFFERENCES.near:
            known = np.tile(self.known_links, (len(time), 1))
            last = self._inverted(time, given, self.linkage.pose(time, given, known))
        elif not np.array_equal(given, last.given):
            last = self._from(time, given, last)
        self._last = last
        return last

    def _from(self, time: Array, given: Array, near: Pose) -> Pose:
        """Pose of the links by a near one, whose Jacobian serves to close the loops."""
        loops = self.linkage.loops
        q = near.q + (near.inverse @ loops.driven(given - near.given)[..., None])[..., 0]
        unit = ASSEMBLY.closed * loops.scale * (1 + np.abs(given).max(axis=1, initial=0.0)[:, None])
        for _ in range(DIFFERENCES.chords):
            left = loops.residual(q, given)
            q = q - (near.inverse @ left[..., None])[..., 0]
            if (np.abs(left) < unit).all():
                return self._inverted(time, given, q)
        return self._inverted(time, given, self.linkage.pose(time, given, near.q))

    def _inverted(self, time: Array, given: Array, q: Array) -> Pose:
        try:
            return Pose(given, q, np.asarray(np.linalg.inv(self.linkage.loops.jacobian(q)), dtype=float))
        except np.linalg.LinAlgError as error:
            raise AssemblyError(f"the linkage is at a dead centre of its freedoms at {time[0]:.6g} s") from error

    def _moved(self, time: Array, places: Array, given: tuple[Array, ...], pose: Pose) -> RigidStates:
        """Motion of the links at a pose of theirs."""
        q, inverse, loops = pose.q, pose.inverse, self.linkage.loops
        velocity = (inverse @ loops.driven(given[1])[..., None])[..., 0]  # (6.2)
        forced = loops.driven(given[2]) - loops.convective(q, velocity)
        acceleration = (inverse @ forced[..., None])[..., 0]  # (6.3)
        return RigidStates(time, self.linkage.theta(time, places), q, velocity, acceleration, inverse)

    def balance(self, states: RigidStates) -> Balance:
        """Give what acts in a motion.

        Parameters
        ----------
        states
            The motion.
        """
        return self.dynamics.balance(states, self.contacts)

    def left(self, time: Array, states: States, multipliers: Array) -> Array:
        """Give what is left of the equation (N m or N), ``(times, freedoms)``.

        Parameters
        ----------
        time, states
            As of `states`.
        multipliers
            Those of a balance.
        """
        efforts = self.dynamics.efforts(multipliers)[:, len(self.scene.drives) :]
        places, rates, seconds = (part.T for part in states)
        rows = [
            effort - freedom.effort_at(time, place, rate) + freedom.inertia * second
            for effort, freedom, place, rate, second in zip(
                efforts.T, self.scene.freedoms.values(), places, rates, seconds
            )
        ]
        return np.column_stack(rows)

    def residuals(self, time: Array, place: Array, rate: Array, second: Array) -> Array:
        """What is left of the equation (N m or N), ``(times, freedoms)``.

        Parameters
        ----------
        time
            Times (s), ``(times,)``.
        place, rate, second
            Angles and strokes of the freedoms, and two derivatives, ``(times, freedoms)`` each.
        """
        states = place, rate, second
        return self.left(time, states, self.balance(self.states(time, states)).multipliers)

    def tangents_at(self, time: Array, place: Array, rate: Array, second: Array) -> States:
        """Tangents by r'', r' and r, ``(times, freedoms, freedoms)`` each, by central differences.

        Parameters
        ----------
        time, place, rate, second
            As of `residuals`.
        """
        states = place, rate, second
        count, n = place.shape
        fastest = max(1.0, float(np.abs(states[1]).max(initial=0.0)))
        narrow = [DIFFERENCES.width * law.stated.width / law.arm for law in self.dynamics.rubbing.values()]
        steps = DIFFERENCES.place, min(DIFFERENCES.rate * fastest, *narrow, np.inf), DIFFERENCES.second
        shifted = [[np.tile(part, (2 * n, 1)) for part in states] for _ in steps]
        signs = np.repeat([1.0, -1.0], n)
        for which, step in enumerate(steps):
            by = signs[:, None] * step * np.tile(np.eye(n), (2, 1))
            shifted[which][which] += np.repeat(by, count, axis=0)
        times = np.tile(time, 2 * n)
        near = self._pose_near(time, self.linkage.given(time, states)[0]).repeated(2 * n)
        joined = tuple(np.concatenate(parts) for parts in zip(*shifted))
        given = self.linkage.given(np.tile(times, 3), joined)
        shifted_pose = self._from(times, given[0][: len(times)], near)
        moved = self._moved(np.tile(times, 3), joined[0], given, shifted_pose.beside(near.repeated(2)))
        left = self.left(np.tile(times, 3), (joined[0], joined[1], joined[2]), self.balance(moved).multipliers)
        left = left.reshape(3, 2, n, count, n)
        by_place, by_rate, by_second = (
            np.moveaxis(part[0] - part[1], 0, -1) / (2 * step) for part, step in zip(left, steps)
        )
        return by_second, by_rate, by_place

    def accelerations(self, time: Array, place: Array, rate: Array) -> Array:
        """Give r'' at states, ``(times, freedoms)``: without friction the equation is linear in it.

        Parameters
        ----------
        time
            Times (s), ``(times,)``.
        place, rate
            Angles and strokes, and their rates, ``(times, freedoms)`` each.

        Raises
        ------
        SolverError
            When friction leaves no acceleration.
        """
        count, n = place.shape
        second, times = np.zeros_like(place), np.tile(time, 1 + n)
        if not n:
            return second
        pose = self._pose_near(time, self.linkage.given(time, (place, rate, second))[0]).repeated(1 + n)
        places, rates = np.tile(place, (1 + n, 1)), np.tile(rate, (1 + n, 1))
        ahead = np.repeat(np.vstack([np.zeros(n), DIFFERENCES.second * np.eye(n)]), count, axis=0)
        for _ in range(DIFFERENCES.most_iterations):
            states = places, rates, np.tile(second, (1 + n, 1)) + ahead
            moved = self._moved(times, places, self.linkage.given(times, states), pose)
            multipliers = self.balance(moved).multipliers
            left = self.left(times, states, multipliers).reshape(1 + n, count, n)
            tangent = np.moveaxis(left[1:] - left[0], 0, -1) / DIFFERENCES.second
            self._refuse_massless(tangent[0])
            change = np.linalg.solve(tangent, -left[0][..., None])[..., 0]
            second = second + change
            by_forces = np.abs(np.linalg.inv(tangent)).sum() * np.abs(multipliers).max()  # also where they balance
            if not self.dynamics.rubbing or np.abs(change).max() <= DIFFERENCES.converged * by_forces:
                return second
        raise SolverError("the friction of the joints leaves no acceleration of the freedoms")

    def _refuse_massless(self, mass: Array) -> None:
        """Raise `SolverError` where a freedom moves no mass, by the tangent ``(freedoms, freedoms)``."""
        for name, size in zip(self.scene.freedoms, np.diag(mass)):
            if size == 0:
                raise SolverError(f"the freedom at joint {name} moves no mass: give its links mass or inertia")
