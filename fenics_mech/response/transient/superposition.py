"""Response in time by superposition of modes (E.13), in sub-intervals with constant coefficients from a start on.

Sub-interval k is centred at position k, where M, K and the modes are taken. In it each mode is an oscillator,
``y'' + 2 zeta omega y' + omega^2 y = p`` (E.13), with an exact answer under a load that is linear in time. They are
joined as the sub-intervals of the periodic response are. The motion starts in the middle of the first, from
``y = Phi^T M u`` (E.10) and ``y' = Phi^T M u'`` (E.11).

Source: Winfrey, Trans. ASME J. Eng. Ind. 93 (1971), p. 268; appendix E of the dissertation.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.effects import active
from fenics_mech.eigenmodes import Modes, modes_kept, solve_modes
from fenics_mech.errors import SceneError, UnresolvedError
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.kinematics.run_up import solve_motion_in_time
from fenics_mech.mechanism import System
from fenics_mech.response.periodic.sub_intervals import (
    SubIntervals,
    require_joined,
    straining,
    superpose,
    superposed,
)
from fenics_mech.response.setup import moved
from fenics_mech.response.solution import SuperposedSolution
from fenics_mech.response.solvers import periodic_solver
from fenics_mech.response.transient.course import Course, StartState
from fenics_mech.response.transient.in_time import schedule_of
from fenics_mech.scene import Scene


@dataclass(frozen=True)
class Superposition:
    """Modes of a mechanism in time and what moves them.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism at the positions.
    modes
        The modes there.
    state
        y and y'/omega of each mode, ``(times, modes, 2)``.
    viscous
        Coordinates y whose elastic forces are those of the damping, ``(times, modes)``.
    load
        Modal loads (N/sqrt(kg)), ``(times, modes)``.
    """

    scene: Scene
    system: System
    modes: Modes
    state: Array
    viscous: Array
    load: Array

    @property
    def response(self) -> ElasticResponse:
        """The response of the mechanism."""
        return superpose(self.system, self.modes, self.state[..., 0], self.viscous, self.load, self.scene)

    def course(self, time: Array, settled: tuple[float, int]) -> Course:
        """Give the motion of the mechanism.

        Parameters
        ----------
        time
            Times of the positions (s), ``(times,)``.
        settled
            Difference of the last two cycles, and the number of positions.
        """
        place, rate = self.state[..., 0], self.state[..., 1] * self.modes.omega
        return Course(time, superposed(self.modes, place), superposed(self.modes, rate), settled[0], settled[1], 0.0)


def by_superposition(scene: Scene, system: System, start: StartState) -> SuperposedSolution:
    """Superpose modes in time.

    Parameters
    ----------
    scene
        The scene, without effects beyond the truncated equation (5.1).
    system
        The mechanism over one cycle.
    start
        Time, displacement and velocity at the start.

    Raises
    ------
    SceneError
        When the scene has effects that this method does not know.
    UnresolvedError
        When modes swing more than once in two sub-intervals.
    """
    periodic_solver(scene.analysis, active(scene), system.terms, scene.impulses)  # which refuses other effects
    schedule = schedule_of(scene.analysis, scene.drives, scene.period)
    time = schedule.times(start.time)
    found = superposition(scene, system, start, time)
    count, change = _settled(superposed(found.modes, found.state[..., 0]), schedule.lead(start.time), scene)
    part = slice(0, count)
    if count < len(time):
        found = superposition(scene, system, start, time[part])
    course = found.course(time[part], (change, count))
    return SuperposedSolution(
        scene=scene, system=found.system, response=found.response, course=course, start=start, over_cycle=system
    )


def superposition(scene: Scene, system: System, start: StartState, time: Array) -> Superposition:
    """Give the modes of a mechanism and their motion from a start on.

    Parameters
    ----------
    scene, system, start
        As of `by_superposition`.
    time
        Equally spaced times from that of the start on (s), ``(times,)``.
    """
    require_joined(modes_kept(scene.analysis.modes, system.size), len(time))
    whole = moved(scene, system, solve_motion_in_time(scene, time))
    modes = solve_modes(whole, scene.analysis.modes, scene.petsc)
    step = float(time[1] - time[0])
    if not scene.analysis.allow_ringing:
        _refuse_too_fast(modes, step, scene.period)
    load, slope = _loads(scene, system, whole, modes, time)
    joined = SubIntervals.of(scene, modes, straining(whole, modes), np.full(len(time), step))
    state = _marched(joined, _at_start(whole, modes, start), load, slope)
    return Superposition(scene, whole, modes, state, joined.viscous(state), load)


def _loads(scene: Scene, system: System, whole: System, modes: Modes, time: Array) -> tuple[Array, Array]:
    """Modal loads at the positions (E.6), and their slopes in time from the start to the end of each sub-interval."""
    load = np.einsum("kmi,ki->km", modes.shapes, whole.load)
    if scene.analysis.load == "constant":
        return load, np.zeros_like(load)
    step = float(time[1] - time[0])
    ends = np.append(time, time[-1] + step) - step / 2
    ends[0] = time[0]
    there = moved(scene.changed(effects=()), system, solve_motion_in_time(scene, ends)).load
    rates = np.diff(there, axis=0) / np.diff(ends)[:, None]
    return load, np.einsum("kmi,ki->km", modes.shapes, rates)


def _at_start(system: System, modes: Modes, start: StartState) -> Array:
    """State of the modes at the start, ``(modes, 2)``."""
    shapes = modes.shapes[0]
    momenta = np.stack([start.displacement, start.velocity])[None].repeat(len(modes.theta), axis=0)
    place, rate = (shapes @ part for part in system.mass_times(momenta)[0])  # (E.10), (E.11)
    return np.stack([place, rate / modes.omega[0]], axis=-1)


def _marched(joined: SubIntervals, first: Array, load: Array, slope: Array) -> Array:
    """States at the middles of all sub-intervals from that of the first on, ``(times, modes, 2)``."""
    oscillators, half = joined.oscillators, joined.duration / 2
    free = oscillators.transition(half)
    to_end = oscillators.forced(load, slope, half)
    to_middle = oscillators.forced(load - slope * half, slope, half)
    states = np.empty((*load.shape, 2))
    states[0] = first
    for k in range(len(load) - 1):
        y, rate = np.moveaxis(np.einsum("mij,mj->mi", free[k], states[k]) + to_end[k], -1, 0)
        rate = rate * oscillators.omega[k]
        ahead = joined.join[k] @ rate + joined.kick[k] @ y
        begun = np.stack([joined.join[k] @ y, ahead / oscillators.omega[k + 1]], axis=-1)
        states[k + 1] = np.einsum("mij,mj->mi", free[k + 1], begun) + to_middle[k + 1]
    return states


def _refuse_too_fast(modes: Modes, step: float, period: float) -> None:
    """Raise `UnresolvedError` where modes swing more than once in two sub-intervals: they ring at the joins."""
    fastest = modes.frequency.max(axis=0)
    if (slow := int((2 * fastest * step <= 1).sum())) < len(fastest):
        keep, count = f"Keep {slow} modes, or t" if slow else "T", math.ceil(2 * fastest.max() * period)
        raise UnresolvedError(
            f"mode {slow + 1} ({fastest[slow]:.4g} Hz) is too fast for these sub_intervals, at whose joins it is set "
            f"vibrating. {keep}ake at least {count} sub_intervals; "
            "analysis.allow_ringing lets it pass"
        ).finer_by(sub_intervals=count)


def _settled(displacement: Array, lead: int, scene: Scene) -> tuple[int, float]:
    """Number of positions up to which the motion settles, and the difference of the last two cycles."""
    samples, change = scene.analysis.sub_intervals, math.inf
    for index in range(lead + 2 * samples, len(displacement), samples):
        now, then = displacement[index - samples : index], displacement[index - 2 * samples : index - samples]
        change = float(np.abs(now - then).max() / max(np.abs(now).max(), TINY))
        if change < scene.analysis.settled:
            return index + 1, change
    return len(displacement), change


def refuse_modes_in_time(scene: Scene) -> None:
    """Raise `SceneError` where modes are to be superposed in a motion that has none.

    Parameters
    ----------
    scene
        The scene.
    """
    if scene.freedoms or scene.joint_laws:
        raise SceneError(
            "modes are superposed in time where drives lead all links, and no joint has a law",
            place="analysis.solver",
            hint="Write solver = 'auto'",
        )


def finer(solution: SuperposedSolution, *, modes: bool) -> Superposition:
    """Give the superposition with sub-intervals of half the length, at the same positions, or with more modes.

    Parameters
    ----------
    solution
        The solution.
    modes
        Whether it has twice as many modes instead.
    """
    scene, time = solution.scene, solution.course.time
    if modes:
        kept = scene.analysis.modes
        more = kept if kept == "all" else 2 * kept
        changes = {"modes": more, "allow_ringing": True}
        return superposition(_with(scene, changes), solution.over_cycle, solution.start, time)
    between = np.linspace(time[0], time[-1], 2 * len(time) - 1)
    found = superposition(scene, solution.over_cycle, solution.start, between)
    every = slice(None, None, 2)
    coarse = replace(
        found.modes,
        theta=found.modes.theta[every],
        omega=found.modes.omega[every],
        shapes=found.modes.shapes[every],
    )
    parts = (part[every] for part in (found.state, found.viscous, found.load))
    return Superposition(scene, solution.system, coarse, *parts)


def _with(scene: Scene, changes: Mapping[str, object]) -> Scene:
    return scene.model_copy(update={"analysis": scene.analysis.model_copy(update=changes)})
