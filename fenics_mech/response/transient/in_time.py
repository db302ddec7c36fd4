"""Response in time from a given state, through a run-up or at full speed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass, replace
from functools import partial
from typing import Any, TypeVar

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects import Loads
from fenics_mech.effects.geometric_stiffness import EFFECT as GEOMETRIC_STIFFNESS
from fenics_mech.effects.large_rotations import EFFECT as LARGE_ROTATIONS
from fenics_mech.errors import SceneError, shortened
from fenics_mech.forces.elastic_response import ElasticResponse, elastic_response
from fenics_mech.kinematics import Motion
from fenics_mech.kinematics.run_up import solve_motion_in_time
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.axial_forces import settles
from fenics_mech.response.modal_damping import modal_damping
from fenics_mech.response.periodic.steps import corners_to_cut
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.sampling_checks import refuse_hidden_peaks, require_positions
from fenics_mech.response.setup import moved
from fenics_mech.response.solution import TransientSolution
from fenics_mech.response.transient.coefficients import TABLE, Coefficients
from fenics_mech.response.transient.course import TRANSIENT, Course, Schedule
from fenics_mech.response.transient.integration import integrate
from fenics_mech.response.velocity_jumps import impulses_between
from fenics_mech.scene import Analysis, Drive, Scene
from fenics_mech.scene.analysis_options import MOST_POSITIONS, refuse_rough
from fenics_mech.scene.base import SCENE
from fenics_mech.scene.start_state import StartState
from fenics_mech.scene.strikes import passages

Joined = TypeVar("Joined", ElasticResponse, Loads)
# points of a cycle that show what is not cut at hidden corners
SHOWN = math.ceil(TRANSIENT.stages / TRANSIENT.longest_step)


def by_time(scene: Scene, system: System, start: StartState) -> TransientSolution:
    """Integrate the equation of motion in time; the positions are at equal steps of time up to the last cycle's end.

    Parameters
    ----------
    scene
        States the cycles and the tolerances.
    system
        The mechanism over one cycle.
    start
        Time, displacement and velocity at the start.

    Raises
    ------
    SceneError
        When the scene has something that is not solved in time.
    SolverError
        When the time steps fail.
    """
    if not scene.drives:
        what = "nothing is driven or moves freely, and a motion in time is that of a machine"
        raise SceneError(what, place="analysis.method", hint="Write 'static', or give a drive")
    coefficients = _coefficients_of(scene, system, start.time)
    course = course_from(scene, system, start, coefficients)
    parts = []
    for part in cycles_of(course.time, scene.analysis.sub_intervals):
        equation = equation_in_time(scene, system, course.time[part])
        parts.append(elastic_response(equation, course.displacement[part], course.velocity[part]))
    whole = moved(scene, system, solve_motion_in_time(scene, course.time))
    return TransientSolution(
        scene=scene,
        system=whole,
        response=concatenated(parts),
        course=course,
        start=start,
        over_cycle=system,
        coefficients=coefficients,
    )


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
    refuse_rough(analysis)


def cycles_of(time: Array, count: int) -> list[slice]:
    """Cut positions in time into cycles of so many: the matrices of all cycles need too much memory.

    Parameters
    ----------
    time
        The positions (s), ``(times,)``.
    count
        Positions in a cycle.
    """
    return [slice(k, k + count) for k in range(0, len(time), count)]


def course_from(
    scene: Scene, system: System, start: StartState, coefficients: Coefficients, longest: float = TRANSIENT.longest_step
) -> Course:
    """Integrate from the start to the end.

    Parameters
    ----------
    scene
        States the cycles and the tolerances.
    system
        The mechanism over one cycle.
    start
        Time, displacement and velocity at the start.
    coefficients
        Matrices of the equation at any time.
    longest
        Largest step, as a share of a cycle.

    Raises
    ------
    SceneError
        When there are more positions than a result holds.
    SolverError
        When the time steps fail.
    """
    schedule = replace(schedule_of(scene.analysis, scene.drives, scene.period), longest=longest)
    time = start.time
    if (positions := schedule.count(time)) > MOST_POSITIONS:
        raise SceneError(
            f"{shortened(positions)} positions are more than a result holds, {MOST_POSITIONS}",
            place="analysis.cycles",
            hint="Give fewer cycles or sub_intervals, and go on from the result with analysis.start",
        )
    require_positions(scene, positions)
    impulses = impulses_between(scene, system, time, float(schedule.times(time)[-1]))
    return integrate(coefficients, schedule, start, scene.petsc, impulses)


def _coefficients_of(scene: Scene, system: System, start: float) -> Coefficients:
    """Give the matrices of the equation at any time from a start (s) on; `system` is over one cycle."""
    tolerance = max(TRANSIENT.interpolation * scene.analysis.time_tolerance, SCENE.finest_steps)
    enough = TABLE.nodes * TABLE.windows
    seen = [SHOWN if load.cut_where_needed else load.enough_angles(enough) for load in scene.loads.values()]
    return Coefficients(
        partial(equation_in_time, scene, system),
        scene.period,
        start,
        scene.drives[0].run_up or 0.0,
        tolerance,
        max(TABLE.windows, math.ceil(TRANSIENT.longest_gap * max([1, *seen]) / TABLE.nodes)),
        _corners(scene),
    )


def _corners(scene: Scene) -> Callable[[int], Array]:
    """Give the times (s) in a cycle, by its number, at which steps end as loads' factors have hidden corners there."""
    steps = {"sub_intervals": math.ceil(1 / TRANSIENT.longest_step), "scheme": "radau", "stages": TRANSIENT.stages}
    longest = scene.changed(analysis=scene.analysis.model_copy(update=steps))
    refuse_hidden_peaks(longest.changed(analysis__sub_intervals=SHOWN))
    corners = corners_to_cut(longest)

    def during(cycle: int) -> Array:
        begin, end = scene.period * cycle, scene.period * (cycle + 1)
        return np.unique(np.concatenate([np.zeros(0), *(passages(scene, angle, begin, end) for angle in corners)]))

    return during


def schedule_of(analysis: Analysis, drives: Sequence[Drive], period: float) -> Schedule:
    """Give what is to be computed.

    Parameters
    ----------
    analysis
        States the cycles, the positions and the tolerances.
    drives
        The drives; the first one states the run-up.
    period
        Duration of a cycle (s).
    """
    return Schedule(
        cycle=period,
        samples=analysis.sub_intervals,
        cycles=analysis.cycles,
        settled=analysis.settled,
        steady_after=drives[0].run_up or 0.0,
        tolerance=analysis.time_tolerance,
        tableau=Tableau.of(analysis.scheme, max(analysis.stages, TRANSIENT.stages)),
    )


def equation_in_time(scene: Scene, system: System, time: Array) -> Equation:
    """Give the equation of motion at ascending times.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism over one cycle.
    time
        The times (s), ``(times,)``.
    """
    return equation_along(scene, system, solve_motion_in_time(scene, time))


def equation_along(scene: Scene, system: System, motion: Motion) -> Equation:
    """Give the equation of motion along a rigid motion.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism at any angles.
    motion
        The rigid motion.
    """
    here = moved(scene, system, motion)
    return Equation(here, modal_damping(scene.damping.ratio, here))


def concatenated(parts: list[Joined]) -> Joined:
    """Put responses, or loads, of cycles one after the other: all arrays that they have.

    Parameters
    ----------
    parts
        Of one kind, in the order of time.
    """
    values = {f.name: [getattr(part, f.name) for part in parts] for f in fields(parts[0])}
    joined: dict[str, Any] = {
        name: np.concatenate(found) if isinstance(found[0], np.ndarray) else concatenated(found)
        for name, found in values.items()
        if isinstance(found[0], np.ndarray) or is_dataclass(found[0])
    }
    return replace(parts[0], **joined)
