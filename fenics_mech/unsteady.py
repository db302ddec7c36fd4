"""Response in time from a given state, through a run-up or at full speed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields, replace

import numpy as np
from numpy.typing import NDArray

from fenics_mech.building import system_at
from fenics_mech.errors import SceneError
from fenics_mech.kinematics.run_up import solve_motion_in_time
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.recovery import Result
from fenics_mech.response import History
from fenics_mech.response.damping import modal_damping
from fenics_mech.response.history import history_of
from fenics_mech.response.transient import Coefficients, Span, integrate
from fenics_mech.scene import Scene

Array = NDArray[np.float64]
MOST_POSITIONS = 100_000  # at which a result is held


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
    _check(scene)
    analysis, run_up = scene.analysis, scene.drives[0].run_up or 0.0

    def equation_at(time: Array) -> Equation:
        here = system_at(scene, system.beams, solve_motion_in_time(scene, time))
        return Equation(here, modal_damping(scene, here))

    coefficients = Coefficients(equation_at, scene.period, math.ceil(analysis.sub_intervals / 4), run_up)
    span = Span(
        scene.period, analysis.sub_intervals, analysis.cycles, analysis.settled, run_up, analysis.time_tolerance
    )
    course = integrate(coefficients, span, *_start(scene, system, equation_at), scene.petsc)
    parts = []
    for k in range(0, len(course.time), analysis.sub_intervals):  # a cycle at a time: the matrices are dense
        part = slice(k, k + analysis.sub_intervals)
        parts.append(history_of(equation_at(course.time[part]), course.displacement[part], course.velocity[part]))
    whole = system_at(scene, system.beams, solve_motion_in_time(scene, course.time))
    return whole, replace(_joined(parts), course=course)


def _check(scene: Scene) -> None:
    """Refuse what the integration in time does not know."""
    if not scene.drives:
        raise SceneError("a motion in time needs a drive, and the scene has none", place="analysis.method")
    for place, what in (("impulses", scene.impulses), ("drive.motor", any(drive.motor for drive in scene.drives))):
        if what:
            raise SceneError(
                "a solution in time does not know it yet", place=place, hint="Write analysis.method = 'periodic'"
            )
    positions = scene.analysis.cycles * scene.analysis.sub_intervals
    if positions > MOST_POSITIONS:
        raise SceneError(
            f"{positions} positions are more than a result holds, {MOST_POSITIONS}",
            place="analysis.cycles",
            hint="Give fewer cycles or sub_intervals, and go on from the result with analysis.start",
        )


def _start(scene: Scene, system: System, equation_at: Callable[[Array], Equation]) -> tuple[float, Array, Array]:
    """Time, displacement and velocity at the start."""
    start, still = scene.analysis.start, np.zeros(system.size)
    if start == "rigid":
        return 0.0, still, still
    if start == "static":
        linear = equation_at(np.zeros(1)).linear
        return 0.0, np.linalg.solve(linear.stiffness[0], linear.load[0]), still
    data = Result.load(start).data
    if "state" not in data or data.sizes["dof"] != system.size:
        held = f"{data.sizes['dof']} degrees of freedom" if "state" in data else "no state"
        raise SceneError(
            f"{start} holds {held}, and the scene has {system.size}: it cannot go on from there",
            place="analysis.start",
            hint="Give the result of a transient analysis of the same scene",
        )
    displacement, velocity = data["state"].transpose("derivative", "dof").to_numpy()
    return float(data["time"][-1]), displacement, velocity


def _joined(parts: list[History]) -> History:
    """Put histories one after the other."""
    values = {field.name: [getattr(part, field.name) for part in parts] for field in fields(History)}
    given = {name: np.concatenate(found) for name, found in values.items() if found[0] is not None}
    return replace(parts[0], **given)
