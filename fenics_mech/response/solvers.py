"""The solver of a scene's response: the one that it asks for, or the simplest that knows all of its effects."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fenics_mech.effects import Effect
from fenics_mech.effects.motor import EFFECT as MOTOR
from fenics_mech.eigenmodes import Modes
from fenics_mech.mechanism import System
from fenics_mech.mechanism.memory_need import require_room
from fenics_mech.response.axial_forces import settle, settles
from fenics_mech.response.damped_modes import damped_modes
from fenics_mech.response.motor_response import by_motor
from fenics_mech.response.periodic.steady_state import by_collocation, by_harmonic_balance
from fenics_mech.response.periodic.steps import Steps
from fenics_mech.response.sampling_checks import refuse_undersampled
from fenics_mech.response.setup import static_response
from fenics_mech.response.solution import PeriodicSolution, StaticSolution
from fenics_mech.scene import Analysis, Scene

SOLVERS: dict[str, Callable[[Scene, System, Modes], PeriodicSolution]] = {
    "collocation": by_collocation,
    MOTOR.solver: by_motor,
    "harmonic-balance": by_harmonic_balance,
}


def periodic_solver(analysis: Analysis, acting: Sequence[Effect]) -> str:
    """Give the solver of a periodic response: the one asked for, or that of an effect.

    Parameters
    ----------
    analysis
        The solver asked for.
    acting
        The effects that act.
    """
    if needed := next((effect.solver for effect in acting if effect.solver), ""):
        return needed
    return "collocation" if analysis.solver in ("auto", "sub-intervals") else analysis.solver


def check_periodic(scene: Scene, system: System, solver: str) -> None:
    """Refuse what a periodic solver cannot resolve or hold, before it begins.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism.
    solver
        Name of the solver.

    Raises
    ------
    SceneError
        When its points of a cycle miss what a load or a drive does between them.
    TooLargeError
        When its matrices do not fit into memory.
    """
    points = scene.analysis.sub_intervals * scene.analysis.stages
    refuse_undersampled(scene, points, by_collocation=solver in ("collocation", MOTOR.solver))
    stages, damped = scene.analysis.stages, bool(np.any(scene.damping.ratio))
    modes = damped_modes(scene, system) if damped and solver != "harmonic-balance" else None
    seen = (modes.count, modes.seen or system.size) if modes else None
    require_room(system, stages * len(Steps.of(scene).start), stages, seen if damped else (0, 0))


def by_statics(scene: Scene, system: System) -> StaticSolution:
    """Solve for the static or quasi-static response, with axial forces that settle if the scene asks for that.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism.
    """
    refuse_undersampled(scene, scene.analysis.sub_intervals)
    if settles(scene.analysis.tension, system.terms):
        system = settle(system, lambda changed: static_response(scene, changed))
    return StaticSolution(scene=scene, system=system, response=static_response(scene, system))
