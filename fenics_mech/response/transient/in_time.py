"""Response in time from a given state, through a run-up or at full speed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from fenics_mech.accuracy.estimate import own_steps
from fenics_mech.accuracy.linear_response import change_in_time, too_fast
from fenics_mech.accuracy.mesh_residual import at_the_start, neglected
from fenics_mech.accuracy.motion_errors import of_mesh
from fenics_mech.effects import Terms
from fenics_mech.errors import ResultError, SceneError, shortened
from fenics_mech.forces.history import Better, history_of
from fenics_mech.kinematics.run_up import solve_motion_in_time
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.recovery import Result
from fenics_mech.response import History, solve_static
from fenics_mech.response.modal_damping import modal_damping
from fenics_mech.response.periodic.steps import corners_to_cut
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.setup import moved, refuse_hidden, require_positions
from fenics_mech.response.transient.coefficients import NODES, WINDOWS, Coefficients
from fenics_mech.response.transient.integration import LONGEST_STEP, Course, Schedule, integrate
from fenics_mech.response.velocity_jumps import blows_between, passages
from fenics_mech.scene import Scene
from fenics_mech.scene.analysis_options import FINEST_STEPS

Array = NDArray[np.float64]
Joined = TypeVar("Joined", History, Terms)
MOST_POSITIONS = 100_000  # at which a result is held
STAGES = 5  # of a time step by collocation, at least: order 9, for steps that are few and long
FINEST = FINEST_STEPS  # error of interpolated matrices
OF_MODES = 2.0  # power of the cutoff with which the answer of the modes left out falls
WANTED = "Give the result of a transient analysis of the same scene"
SAME_ANGLE = 1e-6  # rad, or of the angle turned, by which a start may miss the drive
ROUGHER, ROUGH_SHARE = 10.0, 0.5  # tolerance of steps that tell the error of others, and its share in the difference
INTERPOLATION = 1e-2  # of the tolerance of a step, to which matrices are interpolated
LONGER = 1.3  # longest of those steps over that of others, which bounds them whatever the tolerance
LARGEST_TOLERANCE = 0.02  # beyond it steps are as long as they may be
SHOWN = math.ceil(STAGES / LONGEST_STEP)  # points of a cycle that show what is not cut at hidden corners
LONGEST_GAP = 2.0  # between nodes of the interpolation, over the mean one, at most


def by_time(scene: Scene, system: System) -> tuple[System, History]:
    """Integrate the equation of motion in time.

    Parameters
    ----------
    scene
        States the start, the cycles and the tolerances.
    system
        The mechanism over one cycle.

    Returns
    -------
    tuple
        The mechanism and its motion at equal steps of time, from the start to the end of the last cycle.

    Raises
    ------
    SceneError
        When the scene has something that is not solved in time, or its start does not fit.
    SolverError
        When the time steps fail.
    """
    analysis = scene.analysis
    if not scene.drives:
        raise SceneError("a motion in time needs a drive, and the scene has none", place="analysis.method")
    if analysis.tension == "settled" and system.terms.tension is not None:
        raise SceneError(
            "a motion in time does not update axial forces",
            place="analysis.tension",
            hint="Take the effect 'moderate-rotations' in place of 'geometric-stiffness'",
        )
    if analysis.reduction != "none" and system.terms.law is not None:
        raise SceneError(
            "a motion in time does not know members that are reduced and rotate moderately",
            place="analysis.reduction",
            hint="Write reduction = 'none', or leave the effect 'moderate-rotations' out",
        )
    if analysis.time_tolerance > LARGEST_TOLERANCE:
        raise SceneError(
            f"{analysis.time_tolerance:g} is more than {LARGEST_TOLERANCE:g}, up to which it governs the steps in time",
            place="analysis.time_tolerance",
            hint="Take a smaller one: the error of the steps is not known with this one",
        )
    course = _course(scene, system)
    rough = None if own_steps(scene) else _rougher(scene, system, course)
    parts, roughly, better, fast, state = [], [], [], [], np.zeros((4, system.size))
    for k in range(0, len(course.time), analysis.sub_intervals):  # a cycle at a time: the matrices are dense
        part = slice(k, k + analysis.sub_intervals)
        equation = _equation(scene, system, course.time[part])
        motion = course.displacement[part], course.velocity[part]
        parts.append(history_of(equation, *motion))
        fast.append(
            too_fast(equation.linear, motion, scene.period / analysis.sub_intervals, float(np.ptp(course.time)))
        )
        if rough is not None:
            roughly.append(history_of(equation, rough.displacement[part], rough.velocity[part]))
        *meshless, state = _without_mesh(equation, parts[-1], motion, scene.period / analysis.sub_intervals, state)
        better.append(meshless)
    whole = moved(scene, system, solve_motion_in_time(scene, course.time))
    histories, loads = map(list, zip(*better))
    found = {"mesh": of_mesh(system, _joined(histories), _joined(loads))}
    if roughly:
        found = {"time": Better(_joined(roughly), 1, ROUGH_SHARE), **found}
    course = replace(course, too_fast=min((found for found in fast if found is not None), default=None))
    history = replace(_joined(parts), course=course)
    if analysis.reduction != "none" and analysis.start == "rigid":
        found["modes"] = Better(history, OF_MODES, loads=at_the_start(whole))
    return whole, replace(history, better=found)


def _rougher(scene: Scene, system: System, course: Course) -> Course:
    """Integrate over the same times with a larger tolerance, and longer steps where that does not govern them."""
    lead = _schedule(scene).lead(float(course.time[0]))
    cycles = max(1, math.ceil((len(course.time) - 1 - lead) / scene.analysis.sub_intervals))
    tolerance = min(ROUGHER * scene.analysis.time_tolerance, 0.9)
    return _course(
        scene.changed(analysis__time_tolerance=tolerance, analysis__cycles=cycles, analysis__settled=0.0),
        system,
        LONGER * LONGEST_STEP,
    )


def _without_mesh(
    equation: Equation, history: History, motion: tuple[Array, Array], step: float, state: Array
) -> tuple[History, Terms, Array]:
    """Give a part of a motion without the error of the mesh.

    Parameters
    ----------
    equation, history, motion
        The equation of the part, its history, and its q and q'.
    step
        Of its positions (s).
    state
        Changes of q, q', q'' and force, by the mesh, one step before the part, ``(4, coordinates)``.

    Returns
    -------
    tuple
        The motion, the load that it has beside, and the change at its end.
    """
    law, matrices = equation.system.terms.law, equation.linear
    if law is not None:
        matrices = equation.linearised(*motion, law.tension(*equation.in_links(*motion)))
    lack = neglected(equation.system, history, step, closed=False)
    load = equation.system.on_coordinates(equation.system.applied_by(lack))
    change = change_in_time(load, matrices, step, state)
    q, rate = change[:2]
    found = history_of(equation, motion[0] + q, motion[1] + rate, load)
    return found, lack, change[:, -1]


def _course(scene: Scene, system: System, longest: float = LONGEST_STEP) -> Course:
    """Integrate from the start to the end, in steps of at most that share of a cycle."""
    analysis, schedule = scene.analysis, replace(_schedule(scene), longest=longest)
    time, displacement, velocity = _start(scene, system)
    if (positions := schedule.count(time)) > MOST_POSITIONS:
        raise SceneError(
            f"{shortened(positions)} positions are more than a result holds, {MOST_POSITIONS}",
            place="analysis.cycles",
            hint="Give fewer cycles or sub_intervals, and go on from the result with analysis.start",
        )
    require_positions(scene, positions)
    tolerance = max(INTERPOLATION * analysis.time_tolerance, FINEST)
    cut = [load.cut_where_needed for load in scene.loads.values()]
    seen = [SHOWN if apart else load.enough_angles(NODES * WINDOWS) for load, apart in zip(scene.loads.values(), cut)]
    coefficients = Coefficients(
        partial(_equation, scene, system),
        scene.period,
        time,
        schedule.steady_after,
        tolerance,
        max(WINDOWS, math.ceil(LONGEST_GAP * max([1, *seen]) / NODES)),
        _corners(scene),
    )
    blows = blows_between(scene, system, time, float(schedule.times(time)[-1]))
    return integrate(coefficients, schedule, time, displacement, velocity, scene.petsc, blows)


def _corners(scene: Scene) -> Callable[[int], Array]:
    """Give the times (s) in a cycle, by its number, at which steps end as loads' factors have hidden corners there."""
    steps = {"sub_intervals": math.ceil(1 / LONGEST_STEP), "scheme": "radau", "stages": STAGES}
    longest = scene.changed(analysis=scene.analysis.model_copy(update=steps))
    refuse_hidden(longest.changed(analysis__sub_intervals=SHOWN))
    corners = corners_to_cut(longest, Tableau.of("radau", STAGES))

    def during(cycle: int) -> Array:
        begin, end = scene.period * cycle, scene.period * (cycle + 1)
        return np.unique(np.concatenate([np.zeros(0), *(passages(scene, angle, begin, end) for angle in corners)]))

    return during


def _schedule(scene: Scene) -> Schedule:
    """Give what is to be computed."""
    analysis = scene.analysis
    return Schedule(
        cycle=scene.period,
        samples=analysis.sub_intervals,
        cycles=analysis.cycles,
        settled=analysis.settled,
        steady_after=scene.drives[0].run_up or 0.0,
        tolerance=analysis.time_tolerance,
        tableau=Tableau.of(analysis.scheme, max(analysis.stages, STAGES)),
    )


def _equation(scene: Scene, system: System, time: Array) -> Equation:
    """Give the equation of motion at ascending times (s)."""
    here = moved(scene, system, solve_motion_in_time(scene, time))
    return Equation(here, modal_damping(scene, here))


def _start(scene: Scene, system: System) -> tuple[float, Array, Array]:
    """Time, displacement and velocity at the start."""
    start, still = scene.analysis.start, np.zeros(system.size)
    if start == "rigid":
        return 0.0, still, still
    if start == "static":
        here = moved(scene, system, solve_motion_in_time(scene, np.zeros(1)))
        return 0.0, solve_static(here, scene.petsc).displacement[0], still
    if not Path(start).is_file():
        raise SceneError(
            f"there is no file {start!r}",
            place="analysis.start",
            hint="Write 'rigid', 'static', or the file of a result of a transient analysis",
        )
    try:
        data = Result.load(start).data
    except ResultError as error:
        raise SceneError(f"{start!r} is not a result of this program", place="analysis.start", hint=WANTED) from error
    goes_on = {"state", "time", "theta"} <= set(data.variables) and data["state"].dims == ("dof", "derivative")
    if not goes_on or data["state"].shape != (system.size, 2):
        held = f"{data.sizes['dof']} degrees of freedom" if goes_on else "no state"
        raise SceneError(
            f"{start} holds {held}, and the scene has {system.size}: it cannot go on from there",
            place="analysis.start",
            hint=WANTED,
        )
    time, angle = float(data["time"][-1]), float(data["theta"][-1])
    turned = float(scene.coordinate(np.array([time])).value[0])
    if abs(angle - turned) > SAME_ANGLE * max(1.0, abs(turned)):
        raise SceneError(
            f"{start} ends after {time:.6g} s at drive angle {math.degrees(angle):.6g} deg, where the scene's drive is "
            f"at {math.degrees(turned):.6g} deg: it cannot go on from there",
            place="analysis.start",
            hint=WANTED,
        )
    displacement, velocity = data["state"].transpose("derivative", "dof").to_numpy()
    return time, displacement, velocity


def _joined(parts: list[Joined]) -> Joined:
    """Put histories, or loads, one after the other: all arrays that they have."""
    values = {f.name: [getattr(part, f.name) for part in parts] for f in fields(parts[0])}
    return replace(parts[0], **{n: np.concatenate(v) for n, v in values.items() if isinstance(v[0], np.ndarray)})
