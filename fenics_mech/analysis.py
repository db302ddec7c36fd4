"""The walk through the rooms: scene, kinematics, beams, mechanism, modes, response, recovery."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fenics_mech.beams import Beams, assemble_beams, mesh_scene
from fenics_mech.effects import Situation, Terms, active, build_terms, shaped
from fenics_mech.errors import SceneError
from fenics_mech.kinematics import Motion, solve_motion
from fenics_mech.mechanism import System, build_system
from fenics_mech.mechanism.equation import Equation
from fenics_mech.modes import Modes, solve_modes
from fenics_mech.recovery import Result
from fenics_mech.recovery.dataset import collect
from fenics_mech.recovery.members import mean_tension
from fenics_mech.response import History, solve_periodic, solve_static
from fenics_mech.response.collocation import solve_collocation
from fenics_mech.response.damping import modal_damping
from fenics_mech.response.history import history_of
from fenics_mech.response.tableau import Tableau
from fenics_mech.scene import Scene

STEPS = ("kinematics", "beams", "modes", "response", "recovery")


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
        raise SceneError(
            "a periodic response needs a drive, and the scene has none: there is no period",
            place="analysis.method",
            hint="Add a [drive], or write method = 'quasi-static'",
        )
    system = mechanism(scene, progress)
    modes = None
    if scene.analysis.method == "periodic":
        progress("modes")
        modes = scene_modes(scene, system)
        progress("response")
        solver = periodic_solver(scene, system.terms)
        history = (_by_collocation if solver == "collocation" else _by_sub_intervals)(scene, system, modes)
    else:
        progress("response")
        history = solve_static(system, scene.petsc)
    progress("recovery")
    return collect(scene, system, history, modes)


def periodic_solver(scene: Scene, terms: Terms) -> str:
    """Give the solver of a periodic response: the one asked for, or the simplest that knows all effects.

    Raises
    ------
    SceneError
        When the solver asked for does not know them.
    """
    asked = scene.analysis.solver
    beyond = terms.coupled or terms.law is not None or terms.material or terms.external or terms.damping
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


def _by_sub_intervals(scene: Scene, system: System, modes: Modes) -> History:
    return solve_periodic(scene, system, modes, boundary_load(scene, system))


def _by_collocation(scene: Scene, system: System, modes: Modes) -> History:
    """Solve at collocation points; the history is that at the starts of the sub-intervals."""
    tableau = Tableau.of(scene.analysis.scheme, scene.analysis.stages)
    count = len(system.motion.theta)
    step = math.copysign(2 * math.pi / count, scene.cycle_rate)
    theta = (system.motion.theta[:, None] + step * tableau.points).ravel()
    inside = system_at(scene, system.beams, solve_motion(scene, theta, near=system.motion))
    equation = Equation(inside, modal_damping(scene, inside))
    tension = rigid_tension(scene, inside) if inside.terms.law is not None else None
    orbit = solve_collocation(equation, tableau, scene.period / count, scene.petsc, tension)
    return history_of(Equation(system, modal_damping(scene, system)), orbit.start, orbit.start_velocity)


def mechanism(scene: Scene, progress: Callable[[str], None] = lambda step: None) -> System:
    """Build the mechanism at equal steps over a cycle, or at its one position when nothing drives it."""
    progress("kinematics")
    if scene.analysis.method == "static":
        motion = solve_motion(scene, np.array([scene.analysis.position])).held()
    else:
        motion = solve_motion(scene, scene.drive_angles(scene.analysis.sub_intervals) if scene.drives else np.zeros(1))
    progress("beams")
    return system_at(scene, shaped(scene, assemble_beams(scene, mesh_scene(scene))), motion)


def system_at(scene: Scene, beams: Beams, motion: Motion) -> System:
    """Build the mechanism at the angles of a motion, with its effects."""
    bare = build_system(scene, beams, motion)
    situation = Situation(scene, beams, motion, tension=lambda: rigid_tension(scene, bare))
    return replace(bare, terms=build_terms(situation))


def rigid_tension(scene: Scene, bare: System) -> NDArray[np.float64]:
    """Axial force of each element from loads and rigid motion (N), ``(angles, elements)``."""
    effects = tuple(name for name in scene.effects if name not in ("geometric-stiffness", "moderate-rotations"))
    linear = scene.changed(effects=effects)
    situation = Situation(linear, bare.beams, bare.motion, tension=lambda: rigid_tension(linear, bare))
    system = replace(bare, terms=build_terms(situation))
    return mean_tension(system, solve_static(system, scene.petsc))


def boundary_load(scene: Scene, system: System) -> NDArray[np.float64] | None:
    """Load at the starts of the sub-intervals, ``(angles, coordinates)``, where the scene asks for a linear load."""
    if scene.analysis.load == "constant":
        return None
    half = math.copysign(math.pi / len(system.motion.theta), scene.cycle_rate)
    motion = solve_motion(scene, system.motion.theta - half, near=system.motion)
    situation = Situation(scene, system.beams, motion, tension=lambda: np.zeros((len(motion.theta), 1)))
    return replace(system, motion=motion, terms=build_terms(situation)).load


def scene_modes(scene: Scene, system: System) -> Modes:
    """Solve for the modes that the scene keeps."""
    count = system.size if scene.analysis.modes == "all" else scene.analysis.modes
    return solve_modes(system, count, scene.petsc)
