"""The walk through the rooms: scene, kinematics, beams, mechanism, modes, response, recovery."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fenics_mech.beams import assemble_beams, mesh_scene
from fenics_mech.errors import SceneError
from fenics_mech.kinematics import solve_motion
from fenics_mech.mechanism import System, applied_forces, build_system
from fenics_mech.modes import Modes, solve_modes
from fenics_mech.recovery import Result
from fenics_mech.recovery.dataset import collect
from fenics_mech.response import solve_periodic, solve_static
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
        history = solve_periodic(scene, system, modes, boundary_load(scene, system))
    else:
        progress("response")
        history = solve_static(system, scene.petsc)
    progress("recovery")
    return collect(scene, system, history, modes)


def mechanism(scene: Scene, progress: Callable[[str], None] = lambda step: None) -> System:
    """Build the mechanism at the middles of the sub-intervals, or at its one position when nothing drives it."""
    progress("kinematics")
    if scene.analysis.method == "static":
        motion = solve_motion(scene, np.array([scene.analysis.position])).held()
    else:
        motion = solve_motion(scene, scene.drive_angles(scene.analysis.sub_intervals) if scene.drives else np.zeros(1))
    progress("beams")
    return build_system(scene, assemble_beams(scene, mesh_scene(scene)), motion)


def boundary_load(scene: Scene, system: System) -> NDArray[np.float64] | None:
    """Load at the starts of the sub-intervals, ``(angles, coordinates)``, where the scene asks for a linear load."""
    if scene.analysis.load == "constant":
        return None
    half = math.copysign(math.pi / len(system.motion.theta), scene.cycle_rate)
    motion = solve_motion(scene, system.motion.theta - half, near=system.motion)
    return replace(system, motion=motion, applied=applied_forces(scene, system.beams, motion)).load


def scene_modes(scene: Scene, system: System) -> Modes:
    """Solve for the modes that the scene keeps."""
    count = system.size if scene.analysis.modes == "all" else scene.analysis.modes
    return solve_modes(system, count, scene.petsc)
