"""Errors of a response in time: those of its time steps, of its mesh, and of the modes left out of members."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.accuracy.corrected_response import ESTIMATES, CorrectedResponse, corrected_for_mesh
from fenics_mech.accuracy.linear_response import change_in_time, too_fast
from fenics_mech.accuracy.mesh_residual import neglected
from fenics_mech.effects import Loads
from fenics_mech.forces.elastic_response import ElasticResponse, elastic_response
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.solution import TransientSolution
from fenics_mech.response.transient.course import TRANSIENT, Course
from fenics_mech.response.transient.in_time import (
    concatenated,
    course_from,
    cycles_of,
    equation_in_time,
    schedule_of,
)
from fenics_mech.scene import Analysis

OWN_STEPS = ("transient_ts_rtol", "transient_ts_atol", "transient_ts_adapt")  # options beside the tolerance


def transient_errors(solution: TransientSolution) -> dict[str, CorrectedResponse]:
    """Give a response in time without the errors of its steps ("time"), of its mesh, and of the modes left out.

    Parameters
    ----------
    solution
        The solution.

    Returns
    -------
    dict
        Responses by source: "time" where the tolerance governs the steps, "mesh", and "modes" of reduced
        members from rest.

    Raises
    ------
    SolverError
        When the rougher steps fail.
    """
    scene, system, course = solution.scene, solution.over_cycle, solution.course
    rough = None if own_steps(scene.petsc) else _rough_course(solution)
    step, duration = scene.period / scene.analysis.sub_intervals, float(np.ptp(course.time))
    roughly, responses, loads, fast, state = [], [], [], [], np.zeros((4, course.displacement.shape[1]))
    for part in cycles_of(course.time, scene.analysis.sub_intervals):
        equation = equation_in_time(scene, system, course.time[part])
        motion = course.displacement[part], course.velocity[part]
        fast.append(too_fast(equation.linear, motion, step, duration))
        if rough is not None:
            roughly.append(elastic_response(equation, rough.displacement[part], rough.velocity[part]))
        found, missing, state = _without_mesh(equation, motion, step, state)
        responses.append(found)
        loads.append(missing)
    errors: dict[str, CorrectedResponse] = {
        "mesh": corrected_for_mesh(system, concatenated(responses), concatenated(loads))
    }
    if slowest := [frequency for frequency in fast if frequency is not None]:
        remark = (
            f"what the mesh does to vibration from {min(slowest):.3g} Hz on, which {scene.analysis.sub_intervals} "
            "sub_intervals are too few for"
        )
        errors["mesh"] = replace(errors["mesh"], remark=remark)
    if roughly:
        errors = {"time": CorrectedResponse(concatenated(roughly), 1, ESTIMATES.rough_share), **errors}
    return errors


def under_loads(solution: TransientSolution, loads: Loads) -> ElasticResponse:
    """Give a response in time under small loads more.

    Parameters
    ----------
    solution
        The solution.
    loads
        The loads at its positions.
    """
    scene, course = solution.scene, solution.course
    step, responses, state = scene.period / scene.analysis.sub_intervals, [], np.zeros((4, solution.system.size))
    for part in cycles_of(course.time, scene.analysis.sub_intervals):
        equation = equation_in_time(scene, solution.over_cycle, course.time[part])
        motion, beside = (course.displacement[part], course.velocity[part]), loads.part(part)
        load = equation.system.on_coordinates_by(beside)
        change = change_in_time(load, equation.about(*motion), step, state)
        responses.append(elastic_response(equation, motion[0] + change[0], motion[1] + change[1], load))
        state = change[:, -1]
    return concatenated(responses)


def trial_of_steps(analysis: Analysis, parted: bool) -> tuple[float, float] | None:
    """Tolerance of the steps that tell the error of those of a free motion, and the factor on the difference.

    Parameters
    ----------
    analysis
        What the scene asks for.
    parted
        Whether contacts opened.

    Returns
    -------
    tuple or None
        The tolerance over that of the motion, and the factor. None where contacts opened and their estimate is not
        asked for.
    """
    if not parted:
        return ESTIMATES.rougher, ESTIMATES.rough_share
    return (ESTIMATES.finer, ESTIMATES.finer_share) if analysis.error_estimates == "contacts" else None


def own_steps(petsc: Mapping[str, Any]) -> bool:
    """Whether options of PETSc choose the steps in time, whatever the tolerance.

    Parameters
    ----------
    petsc
        Options of PETSc by name, without a leading dash.
    """
    return any(name.startswith(OWN_STEPS) for name in petsc)


def cycles_done(solution: TransientSolution) -> int:
    """Cycles after which a motion in time ended, which settles before those that its scene asks for.

    Parameters
    ----------
    solution
        The motion.
    """
    scene, time = solution.scene, solution.course.time
    lead = schedule_of(scene.analysis, scene.drives, scene.period).lead(float(time[0]))
    return max(1, math.ceil((len(time) - 1 - lead) / scene.analysis.sub_intervals))


def _rough_course(solution: TransientSolution) -> Course:
    """Integrate over the same times with a larger tolerance, and longer steps where that does not govern them."""
    scene, cycles = solution.scene, cycles_done(solution)
    tolerance = min(ESTIMATES.rougher * scene.analysis.time_tolerance, 0.9)
    rough = scene.changed(analysis__time_tolerance=tolerance, analysis__cycles=cycles, analysis__settled=0.0)
    return course_from(
        rough, solution.over_cycle, solution.start, solution.coefficients, ESTIMATES.longer * TRANSIENT.longest_step
    )


def _without_mesh(
    equation: Equation, motion: tuple[Array, Array], step: float, state: Array
) -> tuple[ElasticResponse, Loads, Array]:
    """Give a part of a response without the error of the mesh, the load that it has beside, and its change at its end.

    Positions of the part are a `step` (s) apart. `motion` is its q and q', and `state` the change of q, q', q'' and
    force by the mesh one step before it, ``(4, coordinates)``.
    """
    missing = neglected(equation.system, elastic_response(equation, *motion), step, closed=False)
    load = equation.system.on_coordinates_by(missing)
    change = change_in_time(load, equation.about(*motion), step, state)
    q, rate = change[:2]
    return elastic_response(equation, motion[0] + q, motion[1] + rate, load), missing, change[:, -1]
