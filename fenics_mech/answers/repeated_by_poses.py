"""Motions with freedoms that repeat, by the equation of poses: limit cycles, and machines that a motor or weight turns.

The search is that of `solve.repeated`. Here is what scenes ask of it, and how links that bend are followed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech._constants import TINY
from fenics_mech.answers.by_poses import planned
from fenics_mech.answers.in_time_by_poses import InTime, collected, estimated, going_on, start_of, times_of
from fenics_mech.errors import SceneError
from fenics_mech.geometry import PLANE, PoseMotion, Rest
from fenics_mech.machine import Machine
from fenics_mech.machine.assembly import closed
from fenics_mech.machine.from_scene import SceneMachine, machine_of
from fenics_mech.machine.motion import coordinates
from fenics_mech.machine.rigid_from_scene import driven, near_links, rigid_motion
from fenics_mech.planning.start_state import GoneOn
from fenics_mech.recovery.result import Result
from fenics_mech.scene import Scene
from fenics_mech.scene.analysis_options import refuse_rough
from fenics_mech.solve import Step
from fenics_mech.solve.disturbances import Transition, allowed
from fenics_mech.solve.repeated import (
    ANGLE,
    SHOOTING,
    STROKE,
    History,
    Lap,
    RepeatedMotion,
    Runner,
    Search,
    State,
    repeated_motion,
    sizes_of,
)

OTHER_TIMES = 0.131, 0.317, 0.573, 0.811  # of a period, at which the equation is compared
APART = 1e-5  # rad, or m, by which the motion of rigid links is differentiated
Led = Callable[[Array], tuple[PoseMotion, Array]]  # poses, and turns ``(1, poses, 2, 2)``, by a way of freedoms
SAME = 1e-9  # of the accelerations, up to which they are the same at another time


def repeated_by_poses(scene: Scene) -> Result:
    """Find the motion of freedoms and links that bend which repeats, and give one cycle of it."""
    refuse_rough(scene.analysis)
    if np.any(scene.damping.ratio):
        raise SceneError(
            "a motion that repeats has no modes to damp, as its freedoms move on",
            place="damping.ratio",
            hint="Give damping.material in its place",
        )
    runner = BendingRunner(planned(scene))
    cycle, found = repeated_in(runner.scene, runner)
    start = runner.going_on(found.start)
    whole = InTime.of(cycle, times_of(cycle, start.time), start=start)
    if scene.analysis.repeats == 1:
        whole = replace(whole, change=found.change)
    errors = estimated(whole, start) if scene.analysis.error_estimates else None
    return collected(whole, errors, found)


def repeated_in(scene: Scene, runner: Runner) -> tuple[Scene, RepeatedMotion]:
    """Find the motion of a scene that repeats."""
    analysis, is_driven = scene.analysis, bool(scene.drives)
    tolerance = SHOOTING.closed * analysis.time_tolerance
    search = Search(scene.period, is_driven, analysis.cycles, analysis.repeats, analysis.settled, tolerance)
    found = repeated_motion(search, runner)
    if not analysis.allow_unstable:
        found.refuse_unstable(analysis.repeats)
    cycle = {"cycles": analysis.repeats} if is_driven else {"duration": found.period}
    return scene.changed({f"analysis.{key}": value for key, value in cycle.items()}), found


@dataclass(frozen=True)
class BendingRunner:
    """Integrates the motion of links that bend, for the search of one that repeats."""

    # Coordinates are places and turns of all poses. Measures of all terms tell whole turns.

    scene: Scene  # the scene, with its effects chosen

    @cached_property
    def made(self) -> SceneMachine:
        """The machine."""
        return machine_of(self.scene)

    @cached_property
    def kinds(self) -> Index:
        """Kind of each coordinate, ``(coordinates,)``."""
        machine = self.made.machine
        turns = np.isin(np.arange(machine.n), machine.places[:, machine.geometry.d :])
        return np.where(turns, ANGLE, STROKE)

    def begin(self) -> State:
        """Give the state that the freedoms state, on the slow motion, which does not vibrate."""
        v = start_of(self.made)
        return self._here(0.0, v[: self.made.machine.n], None)

    def run(self, start: State, duration: float, samples: int) -> tuple[State, History]:
        """Let the motion go on from a state for so long (s); give its end, and what it was at equal steps of time."""
        return _seen(self._whole(start, duration, samples))

    def lap(self, start: State, duration: float, shares: Array | None = None) -> Lap:
        """Give the motion from a state on, with all disturbances of it."""
        machine = self._at(start)
        disturbed, _ = allowed(machine, start.time, start.velocity)
        carried, ends = Transition(disturbed), [start.time]

        def take(step: Step) -> None:
            ends.append(step.t + step.h)
            carried.take(step)

        whole = self._whole(start, duration, SHOOTING.samples, take, shares)
        end, (_, place, rate) = _seen(whole)
        sizes = sizes_of(place, rate, self.kinds)
        passed = np.array(ends) - start.time
        rough = whole.closings > 0 or carried.rough
        forces = np.concatenate([self._forces(start, np.array([at.time]), at.known) for at in (start, end)])
        return Lap(
            start,
            end,
            forces,
            sizes,
            disturbed,
            self._brought_back(start, end, carried.states),
            rough,
            passed / passed[-1],
        )

    def moved(self, start: State, change: Array) -> State:
        """Give a state beside another one, by the change of coordinates and rates; rows of joints stay fulfilled."""
        machine, t = self._at(start), np.array([start.time])
        n, rows = machine.n, slice(machine.n, machine.n + machine.held)
        zero = np.zeros((1, machine.size))
        here = self._poses(start)
        there = self._turned(start, here, change)
        machine.chart = Rest(PLANE, there.r[0], there.R[0])
        q = closed(machine, start.time, zero)[0]
        machine.rebase(q[0], zero[0], zero[0])
        way = q.copy()
        way[0, :n] += _between(machine, here, there)[:n]
        angles = machine.turned(start.known, way)
        v = coordinates(machine, there.v, there.w)[0, :n]
        demanded = np.zeros(machine.held)
        demanded[self.made.driven] = driven(self.made, t)[1][0]
        by_place = machine.pattern.dense(machine.residual(t, zero, zero, zero, loads=0.0, moving=False).K)[0, rows, :n]
        v = v - allowed(machine, start.time, v)[1] @ (by_place @ v - demanded)
        return self._here(start.time, v, angles)

    def depends_on_time(self, start: State) -> bool:
        """Whether the equation at a state is another one at other times."""
        times = start.time + self.scene.period * np.append(0.0, OTHER_TIMES)
        force = self._forces(start, times, start.known)
        return differs(force[0], force[1:])

    def _forces(self, start: State, times: Array, known: Sequence[Array] | None) -> Array:
        """Give forces at a state at some times, whole turns by some measures ``(times, coordinates)``."""
        machine = self._at(start)
        states = np.zeros((2, len(times), machine.size))
        states[1, :, : machine.n] = start.velocity
        angles = None if known is None else [np.repeat(x, len(times), axis=0) for x in known]
        return machine.residual(times, states[0], states[1], states[0], angles=angles).force[:, : machine.n]

    def missed(self, start: State, end: State) -> Array:
        """Give the change of coordinates and rates from a state to another one, but for whole turns."""
        machine, here = self._at(start), self._poses(start)
        places, led = self._led(start, here)
        by, _ = self._by_freedoms(led, places.size)
        self._at(end)
        there = self._poses(end)
        way = self._freedoms(end, there) - places
        way[0] -= np.where(kinds_of(self.scene) == ANGLE, 2 * np.pi * np.round(way[0] / (2 * np.pi)), 0.0)
        at, turn = led(way.ravel())
        left = _between(machine, at, there)
        return by @ way.ravel() + _rotated(machine, np.swapaxes(turn, -1, -2), left, at, here)

    def _brought_back(self, start: State, end: State, states: Array) -> Array:
        """Give what disturbances of an end change of what it misses a start by ``(2 n, disturbances)``."""
        units, columns = np.tile(self.made.machine.units[: len(start.velocity)], 2), []
        for one in states.T:
            step = APART / max(float(np.abs(one / units).max()), TINY)
            sides = []
            for sign in (step, -step):
                way, faster = np.split(sign * one, 2)
                beside = replace(end, displacement=end.displacement + way, velocity=end.velocity + faster)
                sides.append(self.missed(start, beside))
            columns.append((sides[0] - sides[1]) / (2 * step))
        return np.stack(columns, axis=1)

    def _turned(self, start: State, here: PoseMotion, change: Array) -> PoseMotion:
        """Give the poses after a change of coordinates and rates: links turn with the freedoms as they are bent."""
        # A straight way of all poses would stretch links that turn.
        machine = self.made.machine
        places, led = self._led(start, here)
        by, units = self._by_freedoms(led, places.size)
        way = np.linalg.lstsq(by / units[:, None], change / units, rcond=None)[0]
        at, turn = led(way)
        left = _rotated(machine, turn, change - by @ way, here, at)
        left = np.append(left.reshape(2, -1), np.zeros((2, machine.size - machine.n + 1)), axis=1)
        place, rate = left[:, machine.places[None, :, :2]]
        angle, spin = left[:, machine.places[None, :, 2:]]
        return replace(at, r=at.r + place, R=PLANE.turn(angle) @ at.R, v=at.v + rate, w=at.w + spin)

    def _poses(self, state: State) -> PoseMotion:
        """Give all poses at a state, where the chart of the machine rests."""
        machine, zero = self.made.machine, np.zeros((1, self.made.machine.size))
        v = zero.copy()
        v[0, : machine.n] = state.velocity
        return machine.with_rates(machine.known.at(np.array([state.time])), v, zero)

    def _freedoms(self, state: State, here: PoseMotion) -> Array:
        """Give angles and strokes of the freedoms, and their rates, where the chart rests ``(2, freedoms)``."""
        made, machine, t = self.made, self.made.machine, np.array([state.time])
        zero = np.zeros((1, machine.size))
        at = machine.moved(t, zero, coordinates(machine, here.v, here.w), zero)
        terms = [machine.terms.index(made.acting[f"freedoms.{name}"]) for name in made.scene.freedoms]
        near = [machine.terms[k].near(t) if state.known is None else state.known[k] for k in terms]
        found = [machine.groups[k].measure(at, x) for k, x in zip(terms, near)]
        return np.array([[x.x[0, 0, 0] for x in found], [x.rate[0, 0, 0] for x in found]])

    def _led(self, start: State, here: PoseMotion) -> tuple[Array, Led]:
        """Give the freedoms, and what gives the poses, as bent as here, with these elsewhere, and the turns of each."""
        made, t, links = self.made, np.array([start.time]), near_links(self.made, here)
        places = self._freedoms(start, here)

        def moved(way: Array) -> PoseMotion:
            place, rate = (places + way.reshape(2, -1))[:, None]
            return rigid_motion(made, t, links, (place, rate, np.zeros_like(rate))).motion

        rigid = moved(np.zeros(places.size))
        beside = here.r - rigid.r
        slower = here.v - rigid.v - _across(rigid.w, beside)

        def led(way: Array) -> tuple[PoseMotion, Array]:
            new = moved(way)
            turn = new.R @ np.swapaxes(rigid.R, -1, -2)
            arm = _by(turn, beside)
            v = new.v + _across(new.w, arm) + _by(turn, slower)
            return replace(new, r=new.r + arm, R=turn @ here.R, v=v, w=new.w + here.w - rigid.w), turn

        return places, led

    def _by_freedoms(self, led: Led, count: int) -> tuple[Array, Array]:
        """Give derivatives of coordinates and rates by freedoms and their rates, and the units of the former."""
        machine = self.made.machine
        steps = APART * np.eye(count)
        columns = [_between(machine, led(-one)[0], led(one)[0]) / (2 * APART) for one in steps]
        return np.stack(columns, axis=1), np.tile(machine.units[: machine.n], 2)

    def going_on(self, state: State) -> GoneOn:
        """Give a state as one from which a motion goes on."""
        at = np.array([state.displacement, state.velocity])
        return GoneOn(state.time, at, np.zeros((2, 0)), state.known or [])

    def _at(self, state: State) -> Machine:
        """Let the chart of the machine rest at a state."""
        going_on(self.made, np.array([state.displacement, state.velocity]))
        return self.made.machine

    def _here(self, time: float, v: Array, angles: Sequence[Array] | None) -> State:
        """Give the state where the chart of the machine rests, with rates."""
        machine, motion = self.made.machine, self.made.machine.known.at(np.array([time]))
        place = coordinates(machine, motion.r, PLANE.vector(motion.R))[0, : machine.n]
        return State(time, place, v, angles)

    def _whole(
        self,
        start: State,
        duration: float,
        samples: int,
        also: Callable[[Step], None] | None = None,
        shares: Array | None = None,
    ) -> InTime:
        """Give the motion from a state on; `also` is called with every step, and these end at shares of it."""
        scene, begin = lasting(self.scene, duration, samples), self.going_on(start)
        ends = None if shares is None else start.time + duration * shares
        return InTime.of(scene, times_of(scene, begin.time), settled=0.0, start=begin, also=also, ends=ends)


def _by(turn: Array, vectors: Array) -> Array:
    """Turn vectors of poses ``(1, poses, 2)``."""
    return np.asarray((turn @ vectors[..., None])[..., 0])


def _across(spin: Array, arms: Array) -> Array:
    """Give velocities of arms that turn ``(1, poses, 2)``."""
    return spin * np.stack([-arms[..., 1], arms[..., 0]], axis=-1)


def _rotated(machine: Machine, turn: Array, change: Array, one: PoseMotion, other: PoseMotion) -> Array:
    """Turn a change of coordinates and rates with the links from one state to another ``(2 n,)``."""
    whole = np.append(change.reshape(2, -1), np.zeros((2, machine.size - machine.n + 1)), axis=1)
    (place, rate), turns = whole[:, machine.places[None, :, :2]], whole[:, machine.places[None, :, 2:]]
    moved = _by(turn, place)
    faster = _by(turn, rate - _across(one.w, place)) + _across(other.w, moved)
    parts = (moved, turns[0]), (faster, turns[1])
    return np.concatenate([coordinates(machine, *x)[0, : machine.n] for x in parts])


def _between(machine: Machine, one: PoseMotion, other: PoseMotion) -> Array:
    """Give coordinates and rates from one state to another ``(2 n,)``."""
    turned = PLANE.vector(other.R @ np.swapaxes(one.R, -1, -2))
    parts = (other.r - one.r, turned), (other.v - one.v, other.w - one.w)
    return np.concatenate([coordinates(machine, *x)[0, : machine.n] for x in parts])


def _seen(whole: InTime) -> tuple[State, History]:
    """Give the end of a motion, and coordinates and rates at its positions, whose angles count turns."""
    motion = whole.positions.motion
    machine, poses = motion.machine, motion.poses
    turns = np.unwrap(PLANE.vector(poses.R), axis=0)
    place = coordinates(machine, poses.r, turns)[:, : machine.n]
    rate = coordinates(machine, poses.v, poses.w)[:, : machine.n]
    assert motion.angles is not None
    angles = [x[-1:] for x in motion.angles]
    return State(float(motion.t[-1]), place[-1], rate[-1], angles), (motion.t, place, rate)


def kinds_of(scene: Scene) -> Index:
    """Give the kind of each freedom, ``(freedoms,)``."""
    return np.array([ANGLE if scene.joints[name].kind == "revolute" else STROKE for name in scene.freedoms], dtype=int)


def lasting(scene: Scene, duration: float, samples: int) -> Scene:
    """Give the scene of a motion that goes on for so long, without what else is wanted to be known of it."""
    # duration: how long (s): of drives, whole cycles
    cycles = round(duration / scene.period) if scene.drives else 1
    changes: dict[str, Any] = {"cycles": cycles} if scene.drives else {"duration": duration}
    changes |= {"sub_intervals": max(4, samples // cycles), "lyapunov": False, "poincare": None}
    return scene.model_copy(update={"analysis": scene.analysis.model_copy(update=changes)})


def differs(here: Array, others: Array) -> bool:
    """Whether accelerations or forces at other times are others."""
    # here, others: ``(coordinates,)`` and ``(times, coordinates)``
    return bool(np.abs(others - here).max() > SAME * max(float(np.abs(here).max()), float(np.abs(others).max())))
