"""Motion in time of a linkage that its drives do not lead wholly: freedoms and vibration together.

The steps are those of `stepping`. The equation is that of `free_state`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.effects.geometric_stiffness import EFFECT as GEOMETRIC_STIFFNESS
from fenics_mech.effects.large_rotations import EFFECT as LARGE_ROTATIONS
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.mechanism import System
from fenics_mech.response.axial_forces import settles
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.setup import mechanism
from fenics_mech.response.solution import FreeSolution
from fenics_mech.response.transient.contact_events import ContactEvents
from fenics_mech.response.transient.course import (
    TRANSIENT,
    ContactCount,
    FreeCourse,
    LawCourse,
    PointsInside,
)
from fenics_mech.response.transient.free_state import FreeState, States
from fenics_mech.response.transient.samples import Samples
from fenics_mech.response.transient.scaled_state import ScaledState
from fenics_mech.response.transient.stepping import Collocation, Curve, Sizes, StepCurve
from fenics_mech.response.transient.strikes import Strikes, loaded, started
from fenics_mech.response.transient.time_steps import stepped
from fenics_mech.scene import Analysis, Scene
from fenics_mech.scene.start_state import StartState
from fenics_mech.scene.strikes import strikes_between


@dataclass(frozen=True)
class FreeLimits:
    """Limits of a free motion's steps and of its start."""

    longest: float = 1 / 20  # of the whole motion
    small: float = 1e-6  # of the energy of the motion, below which the links' own does not govern the steps
    most_iterations: int = 30  # of Newton's method for a smooth start
    converged: float = 1e-10  # of its accelerations
    least: float = 1e-30  # (rad/s)^2, for the energy of freedoms that nothing moves
    spacing: float = 1e-4  # s, over the time in which a freedom moves by its unit: differences of a smooth start
    looked_at: tuple[float, ...] = (0.0, 0.13, 0.32, 0.57, 0.81)  # of the motion, for loads that begin late
    peaks: int = 20  # points of a step at which the peaks of contacts are looked for


FREE = FreeLimits()


def refuse_in_time(analysis: Analysis, system: System) -> None:
    """Raise `SceneError` where a scene has something that is not solved in time.

    Parameters
    ----------
    analysis
        What the scene asks for.
    system
        Its mechanism.
    """
    if settles(analysis.tension, system.terms):
        raise SceneError(
            "method = 'transient' does not update axial forces",
            place="analysis.tension",
            hint=f"Take the effect {LARGE_ROTATIONS.name!r} in place of {GEOMETRIC_STIFFNESS.name!r}",
        )


def by_free_motion(scene: Scene, system: System, start: StartState | None = None) -> FreeSolution:
    """Integrate the equation of motion of freedoms and links in time.

    Parameters
    ----------
    scene
        A scene with a freedom for all that can move.
    system
        Its mechanism at time 0.
    start
        The state to go on from; None for that which `analysis.start` states.

    Raises
    ------
    SceneError
        When the scene has something that a free motion has not.
    SolverError
        When the time steps fail.
    AssemblyError
        When the linkage comes to a dead centre of its freedoms.
    """
    state = FreeState(scene, system)
    start = start or start_of(state)
    return solution_from(state, start, course_of(state, start))


def solution_from(state: FreeState, start: StartState, course: FreeCourse) -> FreeSolution:
    """Give the solution of a course.

    Parameters
    ----------
    state
        The equation.
    start, course
        The state that the motion starts from, and the motion.
    """
    system, response = state.along((course.displacement, course.velocity, course.acceleration), course)
    return FreeSolution(scene=state.scene, system=system, response=response, course=course, start=start, state=state)


def start_of(state: FreeState) -> StartState:
    """Give the state that the motion starts from, as `analysis.start` states it.

    Parameters
    ----------
    state
        The equation.

    Raises
    ------
    SolverError
        When no smooth start is found.
    """
    freedoms = state.scene.freedoms.values()
    places, rates = (np.array([getattr(part, name) for part in freedoms]) for name in ("start", "rate_at_start"))
    n, start = state.size, state.scene.analysis.start
    y, rate = np.append(np.zeros(n), places), np.append(np.zeros(n), rates)
    if start == "smooth":
        return _smooth(state, y, rate)
    if start == "static":
        y[:n] = _slow(state, 0.0, y, rate, np.zeros((2, n)))[0]
    return StartState(0.0, y, rate)


def _slow(state: FreeState, time: float, y: Array, rate: Array, elastic: Array) -> tuple[Array, Array]:
    """Displacement q without vibration, and accelerations of the freedoms, at a state of them.

    `elastic` holds q' and q'' that are known, ``(2, coordinates)``.
    """
    n, y, rate = state.size, y.copy(), rate.copy()
    second = np.zeros_like(y)
    rate[:n], second[:n] = elastic
    for _ in range(FREE.most_iterations):
        states = y[None], rate[None], second[None]
        left = state.residual(np.array([time]), states)[0]
        mass, _, stiffness = (part[0] for part in state.tangents(np.array([time]), states))
        matrix = np.hstack([stiffness[:, :n], mass[:, n:]])
        change = np.linalg.solve(matrix, -left)
        y[:n] += change[:n]
        second[n:] += change[n:]
        stiff = np.abs(change[:n]).max(initial=0.0) <= FREE.converged * max(np.abs(y[:n]).max(initial=0.0), TINY)
        moved = np.abs(change[n:]).max(initial=0.0)
        if stiff and moved <= FREE.converged * max(np.abs(second[n:]).max(initial=0.0), 1e-6):
            return y[:n], second[n:]
    raise SolverError("no start without vibration is found: take start = 'rigid', or stiffer members")


def _smooth(state: FreeState, y: Array, rate: Array) -> StartState:
    """Give the start on the slow motion: q and q' follow the freedoms without vibration."""
    n = state.size
    h = FREE.spacing / max(1.0, float(np.abs(rate[n:]).max(initial=0.0)))
    elastic = np.zeros((2, n))
    for _ in range(3):  # each time one more derivative of the slow motion is known
        here, second = _slow(state, 0.0, y, rate, elastic)
        around = []
        for sign in (-1.0, 1.0):
            there, speed = y.copy(), rate.copy()
            there[n:] += sign * h * rate[n:] + h**2 / 2 * second
            speed[n:] += sign * h * second
            around.append(_slow(state, sign * h, there, speed, elastic)[0])
        elastic = np.stack([(around[1] - around[0]) / (2 * h), (around[1] - 2 * here + around[0]) / h**2])
    return StartState(0.0, np.append(here, y[n:]), np.append(elastic[0], rate[n:]))


def course_of(state: FreeState, start: StartState, rougher: float = 1.0) -> FreeCourse:
    """Integrate from a start to the end.

    Parameters
    ----------
    state, start
        The equation, and the state that the motion starts from.
    rougher
        Factor on the tolerance of the scene.
    """
    state.rewind(start)
    scene, analysis = state.scene, state.scene.analysis
    cycles = analysis.cycles if scene.drives else 1
    step = scene.period / analysis.sub_intervals
    times = start.time + step * np.arange(cycles * analysis.sub_intervals + 1, dtype=float)
    weight, sizes = _scales(state, start)
    tolerance = rougher * analysis.time_tolerance
    due = strikes_between(scene, start.time, float(times[-1]))
    scaled = ScaledState(state, weight)
    strikes = Strikes(scaled, partial(_momentum, state, weight), due) if due else None
    start = started(strikes, start, weight)
    record = _Record(times, start, state, weight)
    watch = record.watch if record.events.laws else None
    tableau = Tableau.of(analysis.scheme, max(analysis.stages, TRANSIENT.stages))
    context = Collocation(scaled, tableau, tolerance, sizes, FREE.longest * scene.period, record.keep, watch)
    context.held = scaled if state.rubs else None
    record.context = context
    here = start.displacement * weight, start.velocity * weight
    steps = stepped(context, here, times, scene.petsc, (strikes, record.forget))
    return record.course(steps)


def _momentum(state: FreeState, weight: Array, names: tuple[str, ...], time: float, place: Array, _: Array) -> Array:
    """Give what impulses give to the scaled coordinates, ``(coordinates,)``."""
    at, y = np.array([time]), (place / weight)[None]
    left = []
    for acting in ((), names):
        scene = loaded(state.scene, acting)
        other = replace(state, scene=scene, system=mechanism(scene))
        other.rewind(StartState(time, y[0], np.zeros_like(y[0]), state.known_links))
        left.append(other.residual(at, (y, np.zeros_like(y), np.zeros_like(y)))[0])
    return np.asarray((left[0] - left[1]) / weight)


class _Record:
    """Takes samples of the motion step by step, and takes the equation on to where it is."""

    context: Collocation

    def __init__(self, times: Array, start: StartState, state: FreeState, weight: Array) -> None:
        self.samples, self.state, self.weight, self.reached = Samples(times), state, weight, start.time
        self.states = np.zeros((2, len(times), len(weight)))
        self.accelerations = np.zeros(self.states.shape[1:])
        self.links = np.zeros((len(times), 3 * len(state.scene.links)))
        self.exerted, self.inside = _Exerted(state), _Inside(state)
        self.events = ContactEvents(state)
        self.events.begin(start.time, start.displacement, start.velocity)
        self._take(self.samples.taken(start.time), start.displacement[None], start.velocity[None])

    def course(self, steps: int) -> FreeCourse:
        """Give the motion, which took so many time steps."""
        inside = self.inside.points()
        laws = self.exerted.course(self.events.count) if self.state.laws else None
        if laws is not None and inside.course.laws is not None:  # peaks between the positions too
            for name, size in inside.course.laws.largest.items():
                laws.largest[name] = max(laws.largest[name], size)
        time, (place, rate) = self.samples.times, self.states
        return FreeCourse(time, place, rate, math.inf, steps, 0.0, self.accelerations, self.links, laws, inside)

    def watch(self, start: float, end: float, curve: Curve) -> float | None:
        """Give the time of the first contact event in a step (s)."""
        return self.events.next_event(start, end, self._unscaled(curve))

    def _unscaled(self, curve: Curve) -> Curve:
        def coordinates(times: Array) -> tuple[Array, Array]:
            place, rate = curve(times)
            return place / self.weight, rate / self.weight

        return coordinates

    def keep(self, end: float, curve: StepCurve) -> bool:
        """Take the samples inside a step; the motion is never settled."""
        here = self.samples.taken(end)
        if here.stop > here.start:
            self._take(here, *self._unscaled(curve)(self.samples.times[here]))
        points, weights = curve.points
        self.inside.take(points, weights, (*self._unscaled(curve)(points), curve.made / self.weight))
        y, rate = (part[0] for part in self._unscaled(curve)(np.array([end])))
        if self.events.laws:
            self.exerted.note_contacts(self.reached, end, self._unscaled(curve))
            (part, size), *rest = self.context.sizes  # of a blow that bent links, what rings after it is a part
            self.context.sizes = ((part, max(size, math.sqrt(self.inside.exerted.strain))), *rest)
        self.reached = end
        self.state.move_on(end, y, rate)
        self.events.settle(end, y, rate)
        return False

    def forget(self, time: float) -> None:
        """Forget a sample at a time at which an impulse strikes: it is taken after it."""
        if self.samples.forget(time):
            self.exerted.forget_last()

    def _take(self, here: slice, y: Array, rate: Array) -> None:
        """Take some samples, which are near to where the equation is."""
        time = self.samples.times[here]
        self.states[:, here] = y, rate
        self.links[here] = self.state.positions(time, y)
        self.accelerations[here] = self.state.accelerations(time, y, rate)
        if self.state.laws:
            self.exerted.take(time, (y, rate, self.accelerations[here]))


@dataclass
class _Inside:
    """Keeps a motion at the collocation points of its steps, where it fulfils the equation."""

    state: FreeState

    def __post_init__(self) -> None:
        self.exerted, self.parts = _Exerted(self.state), list[tuple[Array, ...]]()

    def take(self, time: Array, weight: Array, states: States) -> None:
        """Take the points inside a step, before the equation is taken on to its end."""
        self.parts.append((time, weight, *states, self.state.positions(time, states[0])))
        if self.state.laws:
            self.exerted.take(time, states)

    def points(self) -> PointsInside:
        """Give what was kept."""
        time, weight, place, rate, second, links = (np.concatenate(parts) for parts in zip(*self.parts))
        laws = self.exerted.course(ContactCount()) if self.state.laws else None
        course = FreeCourse(time, place, rate, math.inf, len(self.parts), 0.0, second, links, laws)
        return PointsInside(course, weight / weight.sum())


@dataclass
class _Exerted:
    """Keeps what joint laws exert along a motion, and its peaks between the samples."""

    state: FreeState

    def __post_init__(self) -> None:
        self.parts: list[tuple[dict[str, Array], ...]] = []  # forces, efforts and depths by law
        self.largest: dict[str, float] = {}
        self.strain = 0.0  # twice the largest strain energy of the links (J)

    def take(self, time: Array, states: States) -> None:
        """Take samples near to where the equation is."""
        joints, (links, found, strain) = self.state.joints, self.state.exerted(time, states)
        assert joints is not None
        forces = {name: law.values for name, law in found.items()}
        efforts = {name: joints.size_of(name, links, values) for name, values in forces.items()}
        depths = {
            name: law.depths(law.joint.state(links))[0].max(axis=0) for name, law in joints.laws.items() if law.contacts
        }
        self.parts.append((forces, efforts, depths))
        self.strain = max(self.strain, float(strain.max()))
        self._note(efforts)

    def forget_last(self) -> None:
        """Forget the last sample."""
        if self.parts:
            self.parts[-1] = tuple(
                {name: values[:-1] for name, values in by_name.items()} for by_name in self.parts[-1]
            )

    def note_contacts(self, start: float, end: float, curve: Curve) -> None:
        """Look for the peaks of contacts between the points of a step: they need no accelerations."""
        joints, contacts = self.state.joints, self.state.contacts
        closed = [name for name, touching in contacts.items() if touching.closed.any()]
        if joints is None or not closed:
            return
        time = np.linspace(start, end, FREE.peaks)
        links = self.state.joint_links(time, *curve(time))
        values = joints.exerted(time, links, contacts)
        self._note({name: joints.size_of(name, links, values[name]) for name in closed})

    def _note(self, efforts: dict[str, Array]) -> None:
        for name, effort in efforts.items():
            self.largest[name] = max(self.largest.get(name, 0.0), float(np.abs(effort).max()))

    def course(self, contacts: ContactCount) -> LawCourse:
        """Give what was kept, over all samples."""
        forces, efforts, depths = (
            {name: np.concatenate([part[name] for part in parts]) for name in parts[0]} for parts in zip(*self.parts)
        )
        return LawCourse(forces, efforts, depths, self.largest, contacts)


def _scales(state: FreeState, start: StartState) -> tuple[Array, Sizes]:
    """Give the scale of each coordinate, and what errors of the links' motion and of the freedoms are relative to.

    A unit of an elastic coordinate has about the same strain energy as any other. That of a freedom is 1 rad, or the
    size of the linkage, in the energy of the motion. Loads may begin later, so that those of other times count too.
    """
    n, scene = state.size, state.scene
    time = start.time + scene.period * np.array((0.0,) if scene.drives else FREE.looked_at)
    y, rate = (np.tile(part, (len(time), 1)) for part in (start.displacement, start.velocity))
    still = np.zeros_like(y)
    mass, _, stiffness = (part[0] for part in state.tangents(time[:1], (y[:1], rate[:1], still[:1])))
    left = state.residual(time, (y, rate, still))
    diagonal = np.abs(np.diag(stiffness)[:n])
    kinetic = float(rate[0, n:] @ mass[n:, n:] @ rate[0, n:])
    least = float(np.abs(np.diag(mass)[n:]).min(initial=np.inf)) if state.freedoms else 1.0
    energy = max(kinetic, float(np.abs(left[:, n:]).max(initial=0.0)), least * FREE.least)
    deflection = np.linalg.solve(stiffness[:n, :n], -left[:, :n].T)
    bent = max(float(np.abs(np.sum(deflection.T * left[:, :n], axis=1)).max()), FREE.small**2 * energy)
    weight = np.append(np.sqrt(np.where(diagonal > 0, diagonal, 1.0)), np.full(state.freedoms, math.sqrt(energy)))
    parts = ((slice(0, n), math.sqrt(bent)), (slice(n, None), math.sqrt(energy)))
    return weight, tuple((part, size) for part, size in parts if len(weight[part]))
