"""Motion of a linkage of rigid links: in time where something is free, and led by its drives where nothing is.

The steps are those of `stepping`; they end where contacts open and close. Powers are integrated along with the motion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import partial
from typing import Literal

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError, shortened
from fenics_mech.held_by_friction import Held
from fenics_mech.kinematics import Motion, solve_motion
from fenics_mech.kinematics.free_linkage import FreeLinkage
from fenics_mech.kinematics.motion import coordinates
from fenics_mech.kinematics.run_up import solve_motion_in_time
from fenics_mech.mechanism.rigid_dynamics import RigidDynamics, RigidStates
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.sampling_checks import require_positions
from fenics_mech.response.static.small_motions import SmallMotions
from fenics_mech.response.transient.beside import Beside
from fenics_mech.response.transient.contact_events import ContactEvents
from fenics_mech.response.transient.course import TRANSIENT, ContactCount, StartState, refuse_rough
from fenics_mech.response.transient.free_motion import FREE
from fenics_mech.response.transient.rigid_instants import RigidInstants, instants_of, part_of, states_part
from fenics_mech.response.transient.rigid_state import RigidState
from fenics_mech.response.transient.samples import Samples
from fenics_mech.response.transient.stepping import Collocation, Curve
from fenics_mech.response.transient.strikes import Strikes, loaded, started, strikes_between
from fenics_mech.response.transient.time_steps import stepped
from fenics_mech.scene import Friction, Scene
from fenics_mech.scene.joint_laws import TOUCHING
from fenics_mech.terms.causes import Cause


@dataclass(frozen=True)
class RigidMotionLimits:
    """Limits of motions of rigid links."""

    stages: int = 9  # of a time step, at least: few long steps, as what a step costs hardly grows with its points
    together: int = 2_000_000  # entries of the Jacobians of a led motion that are looked at together
    peaks: int = 60  # points of a step at which the peaks of contacts are looked for
    least: float = 1e-30  # J, for the energy of what nothing moves


RIGID_MOTION = RigidMotionLimits()


@dataclass
class RigidMotion:
    """A motion of rigid links.

    Parameters
    ----------
    scene
        The scene.
    instants
        Parts of the motion, in turn.
    places, rates
        Angles and strokes of the freedoms and their rates, ``(times, freedoms)``, in the same parts.
    work
        Work of each cause over the whole motion (J).
    steps
        Time steps that were made.
    largest
        Largest effort of each joint law, between the instants too.
    contacts
        How often contacts closed and opened.
    vibrations
        Small motions about an equilibrium.
    beside
        What was followed beside a motion in time.
    held
        The place at which friction holds the freedom, and its range.
    """

    scene: Scene
    instants: list[RigidInstants] = field(default_factory=list)
    places: list[Array] = field(default_factory=list)
    rates: list[Array] = field(default_factory=list)
    work: dict[str, float] = field(default_factory=dict)
    steps: int = 0
    largest: dict[str, float] = field(default_factory=dict)
    contacts: ContactCount = field(default_factory=ContactCount)
    vibrations: SmallMotions | None = None
    beside: Beside | None = None
    held: Held | None = None


def by_rigid_motion(scene: Scene, start: StartState | None = None) -> RigidMotion:
    """Find the motion of a linkage of rigid links, and what acts in it.

    Parameters
    ----------
    scene
        A scene of which no link bends, with a freedom for all that can move and no drive leads.
    start
        The state to go on from; None for that at time 0.

    Raises
    ------
    SceneError
        When contacts begin overlapped, or the scene has something that such a motion has not.
    SolverError
        When the time steps fail.
    AssemblyError
        When the linkage cannot be assembled, or comes to a dead centre of its freedoms.
    """
    return free_course(scene, start) if scene.freedoms else led_course(scene)


def led_course(scene: Scene) -> RigidMotion:
    """Give a motion that the drives lead: what acts follows position by position.

    Parameters
    ----------
    scene
        The scene, without freedoms.

    Raises
    ------
    SceneError
        When a joint law is of contact.
    """
    for name in scene.impulses:
        place = f"impulses.{name}"
        raise SceneError("drives lead all rigid links, and an impulse does not change their motion", place=place)
    for name, law in scene.joint_laws.items():
        if isinstance(law, TOUCHING) and scene.analysis.method != "static":
            raise SceneError(
                f"drives lead all links, and what touches at joint {law.joint!r} cannot move them",
                place=f"joint_laws.{name}",
                hint="Give a freedom with an effort in place of a drive",
            )
    count = scene.analysis.sub_intervals
    _refuse_too_many(scene)
    if scene.analysis.method == "transient":
        whole = solve_motion_in_time(
            scene, scene.period / count * np.arange(scene.analysis.cycles * count + 1, dtype=float)
        )
    elif scene.analysis.method == "static":
        whole = solve_motion(scene, np.array([scene.analysis.position])).held()
    else:
        whole = solve_motion(scene, scene.drive_angles(count))
    return led(scene, whole)


def led(scene: Scene, whole: Motion) -> RigidMotion:
    """Give what acts in a motion that drives lead.

    Parameters
    ----------
    scene
        The scene, without freedoms.
    whole
        The motion, at any instants.
    """
    linkage = FreeLinkage(scene)
    dynamics, motion = RigidDynamics(scene, linkage.loops, linkage.start), RigidMotion(scene)
    together = max(1, RIGID_MOTION.together // len(linkage.start) ** 2)
    for first in range(0, len(whole.theta), together):
        part = whole.part(slice(first, first + together))
        q = coordinates(part.position, part.angle)
        velocity, acceleration = coordinates(part.velocity, part.omega), coordinates(part.acceleration, part.alpha)
        inverse = np.asarray(np.linalg.inv(linkage.loops.jacobian(q)), dtype=float)
        states = RigidStates(part.time, part.theta, q, velocity, acceleration, inverse)
        contacts = dynamics.all_closed() if scene.analysis.method == "static" else dynamics.all_open()
        motion.instants.append(part_of(instants_of(dynamics, states, contacts), slice(None)))
        none = np.zeros((len(q), 0))
        motion.places.append(none)
        motion.rates.append(none)
    return motion


def free_course(
    scene: Scene, start: StartState | None = None, rougher: float = 1.0, *, carries: bool = False
) -> RigidMotion:
    """Integrate the motion of the freedoms.

    Parameters
    ----------
    scene
        The scene, with freedoms.
    start
        The state to go on from; None for that at time 0.
    rougher
        Factor on the tolerance of the scene.
    carries
        Whether all disturbances of the state are carried to the end, and not what the scene wants to know of them.
    """
    _refuse_too_many(scene)
    refuse_rough(scene.analysis)
    analysis, linkage = scene.analysis, FreeLinkage(scene)
    state = RigidState(scene, linkage)
    start = start or stated_start(scene)
    state.rewind(start)
    step = scene.period / analysis.sub_intervals
    count = (analysis.cycles if scene.drives else 1) * analysis.sub_intervals
    times = start.time + step * np.arange(count + 1, dtype=float)
    due, unit = strikes_between(scene, start.time, float(times[-1])), np.ones(len(start.displacement))
    strikes = Strikes(state, partial(_momentum, state), due) if due else None
    start = started(strikes, start, unit)
    place, rate = start.displacement, start.velocity
    record = _Recorder(state, times, place, rate, step)
    tableau = Tableau.of(analysis.scheme, max(analysis.stages, RIGID_MOTION.stages))
    tolerance = rougher * analysis.time_tolerance
    context = Collocation(
        state,
        tableau,
        tolerance,
        record.sizes,
        FREE.longest * scene.period,
        record.keep,
        watch=record.watch,
        of_motion=True,
        from_rest=_from_rest(scene),
    )
    record.context = context
    record.motion.beside = Beside.of(scene, context.equation, context.tableau, unit, carries=carries)
    context.beside = record.motion.beside.takes
    record.motion.steps = stepped(context, (place, rate), times, scene.petsc, (strikes, record.forget))
    if strikes is not None:
        record.motion.work[Cause.IMPULSES] = sum(strikes.work)
    return record.motion


def _momentum(state: RigidState, names: tuple[str, ...], time: float, place: Array, _: Array) -> Array:
    """Give what impulses give to the freedoms, ``(freedoms,)``."""
    left, still = [], np.zeros((1, len(place)))
    for acting in ((), names):
        other = RigidState(loaded(state.scene, acting), state.linkage)
        other.rewind(StartState(time, place, still[0], state.known_links))
        left.append(other.residuals(np.array([time]), place[None], still, still)[0])
    return np.asarray(left[0] - left[1])


def stated_start(scene: Scene) -> StartState:
    """Give the state at time 0: angles, strokes and rates that the freedoms state.

    Parameters
    ----------
    scene
        The scene, with freedoms.
    """
    freedoms = scene.freedoms.values()
    names = "start", "rate_at_start"
    place, rate = (np.array([getattr(part, name) for part in freedoms], dtype=float) for name in names)
    return StartState(0.0, place, rate)


def _from_rest(scene: Scene) -> Literal["never", "last", "first"]:
    """When steps of a motion begin from no acceleration: where friction may hold."""
    rubs = [law for law in scene.joint_laws.values() if isinstance(law, Friction)]
    if any(law.static is not None for law in rubs):
        return "first"
    return "last" if rubs else "never"


class _Recorder:
    """Takes samples of the motion step by step, integrates powers, and opens and closes contacts."""

    context: Collocation

    def __init__(self, state: RigidState, times: Array, place: Array, rate: Array, step: float) -> None:
        self.state, self.samples, self.reached = state, Samples(times), float(times[0])
        self.events, self.motion = ContactEvents(state), RigidMotion(state.scene)
        self.events.begin(self.reached, place, rate)
        nodes, weights = np.polynomial.legendre.leggauss(RIGID_MOTION.stages)
        self.nodes, self.weights = (nodes + 1) / 2, weights / 2
        self._take(times[self.samples.taken(self.reached)], place[None], rate[None])
        self.energy = max(self._first_energy(place, rate, step), RIGID_MOTION.least)

    @property
    def sizes(self) -> tuple[tuple[slice, float], ...]:
        """What errors are relative to: the largest energy of the motion so far."""
        return ((slice(None), math.sqrt(self.energy)),)

    def _first_energy(self, place: Array, rate: Array, step: float) -> float:
        """Energy of the motion at the start, and of what it is soon after."""
        state, time = self.state, self.samples.times[:1]
        states = place[None], rate[None], np.zeros((1, len(place)))
        mass, left = state.tangents_at(time, *states)[0][0], state.residuals(time, *states)[0]
        soon = step**2 * float(left @ np.linalg.solve(mass, left)) / 2
        return 2 * max(soon, float(rate @ mass @ rate) / 2)

    def watch(self, start: float, end: float, curve: Curve) -> float | None:
        """Give the time of the first contact event in a step (s)."""
        return self.events.next_event(start, end, curve)

    def keep(self, end: float, curve: Curve) -> bool:
        """Take the samples inside a step and its work; the motion is never settled."""
        start, self.reached = self.reached, end
        samples, inside = self.samples.times[self.samples.taken(end)], start + (end - start) * self.nodes
        time = np.concatenate([samples, inside, [end]])
        place, rate = curve(time)
        states = self.state.states(time, (place, rate, self.state.accelerations(time, place, rate)))
        found = instants_of(self.state.dynamics, states, self.state.contacts)
        count = len(samples)
        for name, power in found.powers.items():
            work = float((end - start) * (self.weights @ power[count:-1]))
            self.motion.work[name] = self.motion.work.get(name, 0.0) + work
        self._note(found.law_efforts)
        self._note_contacts(start, end, curve)
        if count:
            self._add(part_of(found, slice(0, count)), place[:count], rate[:count])
        self.energy = max(self.energy, 2 * float(self.state.dynamics.loads.inertia.kinetic_energy(states.links)[-1]))
        self.context.sizes = self.sizes
        self.state.move_on(states_part(states, slice(-1, None)))
        self.events.settle(end, place[-1], rate[-1])
        self.motion.contacts = self.events.count
        return False

    def forget(self, time: float) -> None:
        """Forget a sample at a time at which an impulse strikes: it is taken after it."""
        if self.samples.forget(time):
            motion, last = self.motion, slice(None, -1)
            motion.instants[-1] = part_of(motion.instants[-1], last)
            motion.places[-1], motion.rates[-1] = motion.places[-1][last], motion.rates[-1][last]

    def _take(self, time: Array, place: Array, rate: Array) -> None:
        """Take samples near to where the equation is."""
        states = self.state.states(time, (place, rate, self.state.accelerations(time, place, rate)))
        found = instants_of(self.state.dynamics, states, self.state.contacts)
        self._note(found.law_efforts)
        self._add(part_of(found, slice(None)), place, rate)

    def _note_contacts(self, start: float, end: float, curve: Curve) -> None:
        """Look for the peaks of contacts between the points of a step: they need no accelerations."""
        closed = {name for name in self.events.laws if self.state.contacts[name].closed.any()}
        if closed:
            time = np.linspace(start, end, RIGID_MOTION.peaks)
            place, rate = curve(time)
            states = self.state.states(time, (place, rate, np.zeros_like(place)))
            wrenches = self.state.dynamics.wrenches(states, self.state.contacts)
            self._note({name: self.state.dynamics.size_of(name, states, wrenches[name]) for name in closed})

    def _note(self, efforts: dict[str, Array]) -> None:
        for name, effort in efforts.items():
            self.motion.largest[name] = max(self.motion.largest.get(name, 0.0), float(np.abs(effort).max()))

    def _add(self, found: RigidInstants, place: Array, rate: Array) -> None:
        self.motion.instants.append(found)
        self.motion.places.append(place)
        self.motion.rates.append(rate)


def _refuse_too_many(scene: Scene) -> None:
    """Raise `SceneError` or `TooLargeError` where there are more positions than a result holds."""
    analysis = scene.analysis
    cycles = analysis.cycles if scene.drives and analysis.method == "transient" else 1
    if (positions := cycles * analysis.sub_intervals + 1) > TRANSIENT.most_positions:
        raise SceneError(
            f"{shortened(positions)} positions are more than a result holds, {TRANSIENT.most_positions}",
            place="analysis.sub_intervals",
            hint="Give fewer cycles or sub_intervals",
        )
    require_positions(scene, positions)
