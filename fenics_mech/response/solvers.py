"""The solver of a scene's response: the one that it asks for, or the simplest that knows all of its effects."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from fenics_mech.effects import Effect, Terms
from fenics_mech.effects.motor import EFFECT as MOTOR
from fenics_mech.eigenmodes import Modes, modes_kept
from fenics_mech.errors import SceneError
from fenics_mech.mechanism import System
from fenics_mech.mechanism.memory_need import require_room
from fenics_mech.response.axial_forces import settle, settles
from fenics_mech.response.damped_modes import damped_modes
from fenics_mech.response.motor_response import by_motor
from fenics_mech.response.periodic.steady_state import by_collocation, by_harmonic_balance, by_sub_intervals
from fenics_mech.response.periodic.steps import Steps
from fenics_mech.response.periodic.sub_intervals import require_joined
from fenics_mech.response.sampling_checks import refuse_undersampled
from fenics_mech.response.setup import static_response
from fenics_mech.response.solution import PeriodicSolution, StaticSolution
from fenics_mech.scene import Analysis, Impulse, Scene

SOLVERS: dict[str, Callable[[Scene, System, Modes], PeriodicSolution]] = {
    "sub-intervals": by_sub_intervals,
    "collocation": by_collocation,
    MOTOR.solver: by_motor,
    "harmonic-balance": by_harmonic_balance,
}


def periodic_solver(analysis: Analysis, acting: Sequence[Effect], terms: Terms, impulses: Mapping[str, Impulse]) -> str:
    """Give the solver of a periodic response: the one asked for, or the simplest that knows all effects.

    Parameters
    ----------
    analysis
        The solver asked for, and whether axial forces settle.
    acting
        The effects that act.
    terms
        What they add.
    impulses
        The impulses, by name.

    Raises
    ------
    SceneError
        When the solver asked for does not know them.
    """
    asked = analysis.solver
    if needed := next((effect.solver for effect in acting if effect.solver), ""):
        return needed
    damped = bool(terms.damping.material or terms.damping.drag or terms.matrices.damping)
    beyond = bool(terms.coupled or terms.law or damped or terms.matrices.follower)
    beyond = beyond or bool(impulses) or settles(analysis.tension, terms)
    if beyond and asked == "sub-intervals":
        names = ", ".join(effect.name for effect in acting)
        raise SceneError(
            f"solver = 'sub-intervals' does not support all effects of the scene ({names})",
            place="analysis.solver",
            hint="Write solver = 'collocation'",
        )
    if asked != "auto":
        return asked
    return "collocation" if beyond else "sub-intervals"


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
    points = scene.analysis.sub_intervals * (1 if solver == "sub-intervals" else scene.analysis.stages)
    refuse_undersampled(scene, points, by_collocation=solver in ("collocation", MOTOR.solver))
    if solver == "sub-intervals":
        require_joined(modes_kept(scene.analysis.modes, system.size), points)
    else:
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
