"""The walk through the rooms: scene, kinematics, beams, mechanism, modes, response, recovery."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from fenics_mech._guard import ADVICE, guarded
from fenics_mech.accuracy.mesh_residual import neglected
from fenics_mech.accuracy.motion_errors import of_mesh, still_better
from fenics_mech.accuracy.sub_interval_errors import Neighbours
from fenics_mech.effects import Terms, active
from fenics_mech.effects.effect import Choice
from fenics_mech.effects.springs import refuse_too_stiff
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.kinematics import reachable_range
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import require_dense
from fenics_mech.modes import Modes
from fenics_mech.planning.effect_choice import choose
from fenics_mech.planning.meet_tolerance import within
from fenics_mech.recovery import Result
from fenics_mech.recovery.dataset import collect
from fenics_mech.recovery.strength import exceeded
from fenics_mech.response import History, solve_periodic
from fenics_mech.response.motor_response import by_motor
from fenics_mech.response.periodic.steady_state import by_collocation, by_harmonic_balance
from fenics_mech.response.periodic.steps import Steps
from fenics_mech.response.periodic.sub_intervals import SubIntervals, require_joined
from fenics_mech.response.setup import (
    boundary_load,
    mechanism,
    modes_kept,
    refuse_unseen,
    scene_modes,
    settle,
    static_response,
)
from fenics_mech.response.transient.in_time import by_time
from fenics_mech.scene import Scene
from fenics_mech.scene.plausibility import implausible

STEPS = ("effects", "kinematics", "beams", "modes", "response", "recovery")


@guarded()
def analyse(scene: Scene, progress: Callable[[str], None] = lambda step: None) -> Result:
    """Analyse a scene as its `analysis` states.

    Parameters
    ----------
    scene
        The scene.
    progress
        Called with the name of each of `STEPS` as it begins.

    Raises
    ------
    AssemblyError
        When the links cannot be assembled at some drive angle.
    SolverError
        When a solver does not converge.
    SceneError
        When a periodic response is asked for and nothing is driven.
    """
    if scene.analysis.method == "periodic" and not scene.drives:
        free = "".join(f"; {freedom}" for freedom in reachable_range(scene).free)
        raise SceneError(
            f"a periodic response needs a drive, and the scene has none: there is no period{free}",
            place="analysis.method",
            hint="Add a [drive], or write method = 'quasi-static'",
        )
    progress("effects")
    if scene.tolerance is not None:
        result = within(scene, lambda trial, choices: _as_stated(trial, choices, progress))
    else:
        result = _as_stated(*choose(scene), progress)
    result.data.attrs["warnings"] = json.dumps([*implausible(scene), *exceeded(scene, result.data)])
    return result


def _as_stated(scene: Scene, choices: Sequence[Choice], progress: Callable[[str], None]) -> Result:
    """Analyse a scene with the effects, the mesh and the steps that it states."""
    refuse_too_stiff(scene)
    system = mechanism(scene, progress)
    modes, solver = None, str(scene.analysis.method)
    if scene.analysis.method == "periodic":
        solver = periodic_solver(scene, system.terms)
        points = scene.analysis.sub_intervals * (1 if solver == "sub-intervals" else scene.analysis.stages)
        refuse_unseen(scene, points, by_collocation=solver in ("collocation", "motor"))
        if solver != "sub-intervals":
            require_dense(system.size, scene.analysis.stages * len(Steps.of(scene).start))
        else:
            require_joined(modes_kept(scene, system), points)
        progress("modes")
        modes = scene_modes(scene, system)
        progress("response")
        system, history = SOLVERS[solver](scene, system, modes)
    else:
        progress("response")
        if scene.analysis.method == "transient":
            system, history = by_time(scene, system)
        else:
            refuse_unseen(scene, scene.analysis.sub_intervals)
            if scene.analysis.tension == "settled" and system.terms.tension is not None:
                system = settle(system, lambda changed: static_response(scene, changed))
            history = static_response(scene, system)
            history = replace(history, better={"mesh": still_better(scene, system, history)})
    progress("recovery")
    result = collect(scene, system, history, modes, choices)
    _refuse_infinite(result)
    result.data.attrs["solver"] = solver
    return result


def _refuse_infinite(result: Result) -> None:
    """Raise where a result holds what is no number."""
    for name in ("strain", "deflection", "joint_force", "input_torque"):
        if name in result.data and not np.isfinite(result.data[name]).all():
            raise SolverError(f"the {name.replace('_', ' ')} is not finite: the equations have no answer. {ADVICE}")


def periodic_solver(scene: Scene, terms: Terms) -> str:
    """Give the solver of a periodic response: the one asked for, or the simplest that knows all effects.

    Raises
    ------
    SceneError
        When the solver asked for does not know them.
    """
    asked = scene.analysis.solver
    if any(drive.motor is not None for drive in scene.drives):
        return "motor"
    beyond = bool(terms.coupled or terms.law or terms.material or terms.drag or terms.damping or terms.follower)
    beyond = beyond or bool(scene.impulses) or (terms.tension is not None and scene.analysis.tension == "settled")
    if beyond and asked == "sub-intervals":
        names = ", ".join(effect.name for effect in active(scene))
        raise SceneError(
            f"the sub-intervals of chapter 5 do not know all effects of the scene ({names})",
            place="analysis.solver",
            hint="Write solver = 'collocation'",
        )
    if asked != "auto":
        return asked
    return "collocation" if beyond else "sub-intervals"


def _by_sub_intervals(scene: Scene, system: System, modes: Modes) -> tuple[System, History]:
    at_starts = boundary_load(scene, system)
    joined = SubIntervals.of(scene, modes)
    history = solve_periodic(scene, system, modes, joined, at_starts)
    neighbours = Neighbours(scene, system, modes, joined, history, at_starts)
    step = scene.period / len(modes.theta)
    found = neighbours.better(lambda there, motion: neglected(there, motion, step), of_mesh)
    return system, replace(history, better=found)


SOLVERS = {
    "sub-intervals": _by_sub_intervals,
    "collocation": by_collocation,
    "motor": by_motor,
    "harmonic-balance": by_harmonic_balance,
}
