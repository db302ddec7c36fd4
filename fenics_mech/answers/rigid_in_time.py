"""Motion in time of rigid links with freedoms, by the equation of poses: a start, steps, errors, energy, a result.

Unknown are the freedoms alone. Steps are few and long: forces at a position follow from places and rates of the
freedoms there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array, Index
from fenics_mech._constants import TINY
from fenics_mech._progress import reached
from fenics_mech.answers.by_poses import read_off
from fenics_mech.answers.in_time_by_poses import LONGEST, SHARPER, noted_peaks, times_of
from fenics_mech.answers.repeated_by_poses import OTHER_TIMES, differs, kinds_of, lasting, repeated_in
from fenics_mech.answers.rigid_by_poses import acting
from fenics_mech.errors import AssemblyError
from fenics_mech.estimate.quantities import measures_of_efforts
from fenics_mech.estimate.remarks import after_contacts
from fenics_mech.joints.law_terms import LawTerm
from fenics_mech.kinematics import coordinates as of_links
from fenics_mech.machine.energy import energy_of_terms, energy_of_weight, kinetic_energy
from fenics_mech.machine.freed import Carried, Driven, Freed, StrayedError
from fenics_mech.machine.from_scene import SceneMachine, lead, machine_of
from fenics_mech.machine.rigid_from_scene import coordinates_of_links, driven
from fenics_mech.recovery.balance import balance_of, given_by
from fenics_mech.recovery.beside_motion import Beside, beside_motion, times_of_growth
from fenics_mech.recovery.dataset import joined
from fenics_mech.recovery.freedoms_and_laws import law_efforts, of_freedoms, running
from fenics_mech.recovery.of_poses import OfRigid
from fenics_mech.recovery.result import Result
from fenics_mech.recovery.variables import with_units
from fenics_mech.scene import Prismatic, Scene, Slot
from fenics_mech.scene.analysis_options import refuse_rough
from fenics_mech.scene.start_state import StartState
from fenics_mech.scene.strikes import ROUNDING, Strike, strikes_between
from fenics_mech.solve import Step, steps_in_time
from fenics_mech.solve.blows import jumps
from fenics_mech.solve.disturbances import Growth, Transition
from fenics_mech.solve.repeated import ANGLE, SHOOTING, History, Lap, State, sizes_of
from fenics_mech.terms.causes import Cause

STAGES = 9  # of a step, at least: few long steps, as what a step costs hardly grows with its stages
LEAST = 1e-10  # of what a step may miss by: Newton's method ends at a thousandth of it, above rounding
MISSED = 1e-3  # of the tolerance, which a step may miss by: rates and forces lose digits to places
BOUNCED = 0.1  # of the tolerance, which a step in a contact may miss its rate by: what bounces keeps it


def rigid_in_time(scene: Scene, start: StartState | None = None) -> Result:
    """Analyse a motion in time of rigid links."""
    refuse_rough(scene.analysis)
    repeated = None
    if scene.analysis.start == "periodic":
        scene, repeated = repeated_in(scene, Runner(scene))
        start = _start_of(repeated.start)
    course = Course.of(scene, start)
    data = _labelled(course)
    beside = (
        running(scene, course.at.t, course.at.r, course.rate),
        beside_motion(course.beside, course.at.t, repeated),
    )
    parts = [data, _powers(course), _errors(course, data, start), *beside]
    return Result.with_scene(scene, with_units(scene, xr.merge(parts, combine_attrs="no_conflicts")))


def freed_of(made: SceneMachine, start: StartState) -> Freed:
    """Give the machine of a scene as one of its freedoms."""
    holding = replace(made, machine=copy(made.machine))
    holding.machine.rows = list(made.machine.rows)
    own = [lead(holding, name, np.zeros_like) for name in made.scene.freedoms]
    machine = holding.machine

    def demanded(t: Array) -> Driven:
        first, second = np.zeros((2, len(t), len(machine.rows)))
        _, first[:, made.driven], second[:, made.driven] = driven(made, t)
        return Driven(first, second)

    near = np.zeros(machine.n) if start.links is None else coordinates_of_links(made, start.links[None])[0]
    return Freed(machine, own, demanded, start.displacement, start.time, near)


def found_at(made: SceneMachine, freed: Freed, known: Carried, rate: Array) -> OfRigid:
    """Give what acts where freedoms are at places, with rates ``(instants, freedoms)``, and nothing holds them."""
    scene, (moved, held) = made.scene, freed.freely(known, rate)
    if scene.drives:
        theta = scene.coordinate(known.t).value
    else:  # of the first freedom, where it turns; else a phase
        slides = isinstance(scene.joints[next(iter(scene.freedoms))], Slot | Prismatic)
        theta = scene.cycle_rate * known.t if slides else known.r[:, 0]
    poses = [made.end(f"{name}.{next(iter(link.points))}").pose for name, link in scene.links.items()]
    angle = np.array([made.bodies.at_start[name] for name in scene.links]) + moved.Q[:, freed.machine.places[poses, 2]]
    return acting(replace(made, machine=freed.machine), known.t, freed.motion(moved), angle, theta, held.pulls)


@dataclass
class _Struck:
    """Impulses that strike in a motion: rates change by what they give to the freedoms' rows over the mass."""

    scene: Scene
    freed: Freed
    due: dict[float, Strike]
    works: list[float] = field(default_factory=list)
    after: dict[float, Array] = field(default_factory=dict)  # rates, by instant

    def __call__(self, t: float, v: Array) -> Array:
        """Give the rates after what strikes at an instant."""
        if t not in self.due:
            return v
        freed, at, zero = self.freed, np.array([t]), np.zeros((1, len(v)))
        machine, names = freed.machine, list(self.scene.impulses)
        numbers = [names.index(name) for name in self.due[t].names]
        q = np.pad(freed.carried(at, freed.place[None], zero, zero).Q, ((0, 0), (0, machine.size - machine.n)))
        momentum = jumps(machine, numbers, t, q)[0].sum(axis=0)[machine.n + freed.own]
        mass = freed.residual(at, zero, v[None], zero).M.reshape(1, len(v), len(v))
        after = v + freed.by_mass(mass, momentum[None])[0]
        self.works.append(float(momentum @ (v + after)) / 2)
        self.after[t] = after
        return after


@dataclass(frozen=True)
class Course:
    """A motion in time."""

    scene: Scene
    made: SceneMachine  # made, freed: its machine
    freed: Freed
    # at, rate: links at the positions of the result, and rates of the freedoms there ``(instants, freedoms)``
    at: Carried
    rate: Array
    # stages, rates, weights: the same at the stages of all steps, and their weights in an integral over time (s)
    stages: Carried
    rates: Array
    weights: Array
    steps: int
    peaks: dict[str, float]  # the most that each law of contact exerts
    beside: Beside  # what was followed beside the motion
    works: float  # energy that impulses gave (J)

    @classmethod
    def of(
        cls,
        scene: Scene,
        start: StartState | None = None,
        sharper: float = 1.0,
        also: Callable[[Step], None] | None = None,
        shares: Array | None = None,
    ) -> Course:
        """Follow a motion from its start."""
        start = start or StartState.stated(scene)
        times, analysis = times_of(scene, start.time), scene.analysis
        made = machine_of(scene)
        freed = freed_of(made, start)
        strokes = [isinstance(scene.joints[name], Slot | Prismatic) for name in scene.freedoms]
        share = sharper * BOUNCED * analysis.time_tolerance
        allowed = sharper * max(MISSED * analysis.time_tolerance, LEAST) * np.where(strokes, freed.extent, 1.0)
        stages = max(analysis.stages, STAGES)
        ends, struck, longest = times[[0, -1]], None, scene.period * LONGEST[0 if scene.drives else 1]
        if shares is not None:
            ends, longest = times[0] + (times[-1] - times[0]) * shares, math.inf
        if scene.impulses:
            due = {strike.time: strike for strike in strikes_between(scene, start.time, float(times[-1]))}
            struck = _Struck(scene, freed, due)
            ends = np.unique([*ends, *due])
        freed.freely(freed.stages, start.velocity[None])  # which says where a freedom moves no mass
        n, growth = freed.n, None
        if analysis.lyapunov:
            growth = Growth(np.eye(2 * n), lambda step, shares, states: states, times_of_growth(times))
        beside = Beside.of(scene, _freedoms_in, growth)
        taken = _Taken(freed, times, start.velocity)
        steps = steps_in_time(
            freed,  # type: ignore[arg-type]  # it is a machine to them
            start.velocity,
            ends,
            tolerance=allowed,
            share=share,
            stages=stages,
            longest=longest,
            h=None if shares is None else float(np.ptp(ends)),
            struck=struck,
        )
        try:
            for step in steps:
                taken.over(step, scene)
                beside.take(step)
                if also is not None:
                    also(step)
        except StrayedError as error:
            raise _refusal(scene, freed, error.t) from error
        return taken.whole(scene, made, beside, struck)

    @cached_property
    def positions(self) -> OfRigid:
        """What acts at the positions of the result."""
        return found_at(self.made, self.freed, self.at, self.rate)

    @cached_property
    def inside(self) -> OfRigid:
        """What acts at the stages of all steps."""
        return found_at(self.made, self.freed, self.stages, self.rates)

    @property
    def contacts(self) -> list[LawTerm]:
        """Laws of contact."""
        return [term for term in self.freed.terms if isinstance(term, LawTerm) and term.contacts]

    @property
    def closings(self) -> int:
        """How often contacts closed."""
        return sum(term.closings for term in self.contacts)


def _refusal(scene: Scene, freed: Freed, t: float) -> AssemblyError:
    """Say that the freedoms do not tell at an instant how links move."""
    # Where the joints' own rows are singular, those with a freedom at any joint are too.
    J, count = freed._here.J[-1], len(scene.moved_joints)
    motion = np.abs(np.linalg.svd(J)[2][-1, freed.machine.places[1:, 2]])
    moved = ", ".join(list(scene.links)[k] for k in np.argsort(-motion) if motion[k] > MOVED * motion.max())
    kind, advice = "dead centre", "State the freedom at another joint, such as that of a link that can turn fully"
    leads = [row.leads or k in freed.own for k, row in enumerate(freed.machine.rows)]
    if np.linalg.svd(J[~np.array(leads)], compute_uv=False).min(initial=1.0) < IN_TWO_WAYS:
        kind = "change point"
        advice = (
            "No other joint says it either, as the links can go on in two ways. Take other lengths, or stops that "
            "keep the links away from it"
        )
    assert count
    return AssemblyError(
        f"at {t:.6g} s the linkage comes to a {kind}: the motion of joint {', '.join(scene.moved_joints)} does not "
        f"say how {moved} moves. {advice}"
    )


IN_TWO_WAYS = 1e-5  # singular value of the joints' rows at a position that is found: below it links go on in two ways
MOVED = 0.05  # of the largest turn in a motion: links that turn by more are named


class _Taken:
    """Takes the positions of the result as steps come to them."""

    def __init__(self, freed: Freed, times: Array, v: Array) -> None:
        self.freed, self.times = freed, times
        self.at: list[Carried] = [freed.stages]
        self.rates: list[Array] = [v[None]]
        self.stages: list[Carried] = []
        self.inside: list[Array] = []
        self.weights: list[Array] = []
        self.peaks: dict[str, float] = {}

    def over(self, step: Step, scene: Scene) -> None:
        """Take the positions in a step, and its stages."""
        freed, times, end = self.freed, self.times, step.t + step.h
        last = end >= times[-1] * (1 - 1e-12)
        reached(end, float(times[0]), float(times[-1]))
        due = times[(times > step.t) & ((times <= end) | last)]
        near = freed.stages
        if len(due):
            q, v, _ = step.at(np.minimum((due - step.t) / step.h, 1.0))
            Q, k = near.predicted(due)
            self.at.append(replace(near.part(k), t=due, r=freed.place + q, Q=Q))
            self.rates.append(v)
        q, v, _ = step.at(step.tableau.c)
        self.stages.append(replace(near, r=freed.place + q))
        self.inside.append(v)
        self.weights.append(step.h * step.tableau.A[-1])
        noted_peaks(self.peaks, step, scene)

    def whole(self, scene: Scene, made: SceneMachine, beside: Beside, struck: _Struck | None) -> Course:
        """Give the motion."""
        at, rate, works = Carried.joined(self.at), np.concatenate(self.rates), 0.0
        if struck is not None:
            works = sum(struck.works)
            for t, after in struck.after.items():
                rate[np.abs(at.t - t) <= ROUNDING * max(abs(float(at.t[-1])), scene.period)] = after
            if self.times[0] in struck.after:  # what is stored at the start has it
                works -= struck.works[0]
        return Course(
            scene,
            made,
            self.freed,
            at,
            rate,
            Carried.joined(self.stages),
            np.concatenate(self.inside),
            np.concatenate(self.weights),
            len(self.stages),
            self.peaks,
            beside,
            works,
        )


def _labelled(course: Course) -> xr.Dataset:
    """Label the motion, and forces and efforts in it."""
    data = read_off(course.positions).assign_attrs(time_steps=course.steps)
    laws = law_efforts(course.positions, course.inside, course.peaks, course.closings)
    return joined(data, of_freedoms(course.scene, course.at.r, course.rate), laws)


def _powers(course: Course) -> xr.Dataset:
    """Give the mean power of every cause, and what is stored, by the stages of all steps."""
    # Efforts in freedoms count without what accelerates their rotors. What drives give at impulses is not known.
    if course.scene.impulses and course.scene.drives:
        return xr.Dataset()
    inside, ends = course.inside, course.positions.motion
    powers, duration = inside.powers(), float(np.ptp(ends.t))
    mean = {cause: float(course.weights @ power) / duration for cause, power in powers.items()}
    if course.scene.impulses:
        mean[Cause.IMPULSES] = course.works / duration
    rotors = np.array([part.inertia for part in course.scene.freedoms.values()])
    energy = kinetic_energy(ends) + energy_of_terms(ends) - course.rate**2 @ rotors / 2
    mean[Cause.STORED] = given_by(energy, duration)
    if Cause.WEIGHT in mean:
        mean[Cause.WEIGHT] = given_by(energy_of_weight(ends), duration)
    return balance_of(mean, powers)


def _errors(course: Course, data: xr.Dataset, start: StartState | None) -> xr.Dataset:
    """Give errors by the time steps, from a motion with a sharper tolerance; after contacts opened where asked."""
    scene = course.scene
    if not scene.analysis.error_estimates:
        return xr.Dataset()
    parted = any(term.openings for term in course.contacts)
    attributes: dict[str, Any] = {"not_estimated": after_contacts(scene.analysis, "a tenth of")} if parted else {}
    if parted and scene.analysis.error_estimates != "contacts":
        return xr.Dataset(attrs=attributes)
    other = _labelled(Course.of(scene, start, SHARPER))
    found: dict[str, Any] = {}
    for name, axis in {"joint_force": "joint", "drive_effort": "drive", "freedom_place": "freedom"}.items():
        here = data[name].to_numpy()
        values = np.abs(np.stack([other[name].to_numpy() - here, here]))
        by_part, largest = np.moveaxis(values, 2, 1).reshape(2, values.shape[2], -1).max(axis=2)
        found[f"{name}_error"] = (("source", axis), by_part[None])
        measure = np.full_like(largest, max(float(largest.max(initial=0.0)), TINY))
        if name == "drive_effort":
            measure = measures_of_efforts(scene, largest, float(abs(data["joint_force"]).max()))
        relative = float((by_part / measure).max(initial=0.0))
        found[f"{name}_relative_error"] = (("source",), [relative])
        attributes[f"{name}_error_estimate"] = relative
    return xr.Dataset(found, {"source": ["time"]}, attributes)


@dataclass(frozen=True)
class Runner:
    """Integrates the motion of rigid links for the search of one that repeats; see `solve.repeated.Runner`."""

    scene: Scene  # the scene, with a freedom for all that can move and no drive leads

    @property
    def kinds(self) -> Index:
        """Kind of each freedom, ``(freedoms,)``."""
        return kinds_of(self.scene)

    def begin(self) -> State:
        """Give the state that the freedoms state."""
        start = StartState.stated(self.scene)
        return State(start.time, start.displacement, start.velocity)

    def run(self, start: State, duration: float, samples: int) -> tuple[State, History]:
        """Let the motion go on from a state for so long (s); give its end, and what it was at equal steps of time."""
        course = Course.of(lasting(self.scene, duration, samples), _start_of(start))
        return _end_of(course), (course.at.t, course.at.r, course.rate)

    def lap(self, start: State, duration: float, shares: Array | None = None) -> Lap:
        """Give the motion from a state on, with all disturbances of it."""
        every, ends = np.eye(2 * len(start.velocity)), [start.time]
        carried, scene = Transition(every), lasting(self.scene, duration, SHOOTING.samples)

        def take(step: Step) -> None:
            ends.append(step.t + step.h)
            carried.take(step)

        course = Course.of(scene, _start_of(start), also=take, shares=shares)
        end = _end_of(course)
        seconds = np.stack([self._second(state, state.time) for state in (start, end)])
        sizes = sizes_of(course.at.r, course.rate, self.kinds)
        passed = np.array(ends) - start.time
        rough = course.closings > 0 or carried.rough
        return Lap(start, end, seconds, sizes, every, carried.states, rough, passed / passed[-1])

    def moved(self, start: State, change: Array) -> State:
        """Give a state beside another one, by the change of places and rates of the freedoms."""
        place, rate = np.split(change, 2)
        return replace(start, displacement=start.displacement + place, velocity=start.velocity + rate)

    def missed(self, start: State, end: State) -> Array:
        """Give the change of places and rates from a state to another one, but for whole turns of pins."""
        way = end.displacement - start.displacement
        way = way - np.where(self.kinds == ANGLE, 2 * np.pi * np.round(way / (2 * np.pi)), 0.0)
        return np.concatenate([way, end.velocity - start.velocity])

    def depends_on_time(self, start: State) -> bool:
        """Whether the equation at a state is another one at other times."""
        here = self._second(start, start.time)
        others = [self._second(start, start.time + share * self.scene.period) for share in OTHER_TIMES]
        return differs(here, np.array(others))

    @cached_property
    def _made(self) -> SceneMachine:
        return machine_of(self.scene)

    def _second(self, start: State, time: float) -> Array:
        freed = freed_of(self._made, _start_of(replace(start, time=time)))
        found = freed.freely(freed.stages, start.velocity[None])[0]
        return np.asarray(found.a[0])


def _freedoms_in(step: Step, shares: Array) -> tuple[Array, Array]:
    """Give the freedoms at shares of a step."""
    machine = step.machine
    assert isinstance(machine, Freed)
    q, v, _ = step.at(shares)
    return machine.place + q, v


def _start_of(state: State) -> StartState:
    return StartState(state.time, state.displacement, state.velocity, state.known)


def _end_of(course: Course) -> State:
    links = course.positions.links().part(slice(-1, None))
    at = of_links(links.position, links.angle)[0]
    return State(float(course.at.t[-1]), course.at.r[-1], course.rate[-1], at)
