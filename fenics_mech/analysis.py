"""The walk through the rooms: scene, kinematics, beams, mechanism, modes, response, recovery."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fenics_mech.beams import assemble_beams, mesh_scene
from fenics_mech.kinematics import solve_motion
from fenics_mech.mechanism import System, build_system
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
    """
    system, boundaries = mechanism(scene, progress)
    modes = None
    if scene.analysis.method == "periodic":
        progress("modes")
        modes = scene_modes(scene, system)
        progress("response")
        history = solve_periodic(scene, system, boundaries, modes)
    else:
        progress("response")
        history = solve_static(system, scene.petsc)
    progress("recovery")
    return collect(scene, system, history, modes)


def mechanism(scene: Scene, progress: Callable[[str], None] = lambda step: None) -> tuple[System, System]:
    """Build the mechanism at the middles of the sub-intervals, and at their starts."""
    progress("kinematics")
    middles = drive_angles(scene)
    half = (middles[1] - middles[0]) / 2
    motion = solve_motion(scene, np.concatenate([middles, middles - half]))
    progress("beams")
    system = build_system(scene, assemble_beams(scene, mesh_scene(scene)), motion.part(slice(len(middles))))
    return system, replace(system, motion=motion.part(slice(len(middles), None)))


def drive_angles(scene: Scene) -> NDArray[np.float64]:
    """Middles of the sub-intervals of one turn, in the order of time (rad), ``(sub_intervals,)``."""
    count = scene.analysis.sub_intervals
    return np.sign(scene.drive.speed) * 2 * np.pi * np.arange(count) / count


def scene_modes(scene: Scene, system: System) -> Modes:
    """Solve for the modes that the scene keeps."""
    count = system.size if scene.analysis.modes == "all" else scene.analysis.modes
    return solve_modes(system, count, scene.petsc)
