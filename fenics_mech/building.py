"""From a scene to its mechanism at the drive angles, with the effects that act in it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fenics_mech.beams import Beams, assemble_beams, mesh_scene
from fenics_mech.effects import Situation, build_terms, shaped
from fenics_mech.errors import SolverError
from fenics_mech.kinematics import Motion, solve_motion
from fenics_mech.mechanism import System, build_system
from fenics_mech.modes import Modes, solve_modes
from fenics_mech.recovery.members import mean_tension
from fenics_mech.response import History, solve_static
from fenics_mech.scene import Scene

MOST_UPDATES = 60  # of the axial forces by the response
SETTLED = 1e-7  # change of the axial forces, of the largest


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
    linear = tuple(name for name in scene.named_effects if name not in ("geometric-stiffness", "moderate-rotations"))
    situation = Situation(scene.changed(effects=linear), bare.beams, bare.motion)
    system = replace(bare, terms=build_terms(situation))
    return mean_tension(system, solve_static(system, scene.petsc))


def boundary_load(scene: Scene, system: System) -> NDArray[np.float64] | None:
    """Load at the starts of the sub-intervals, ``(angles, coordinates)``, where the scene asks for a linear load."""
    if scene.analysis.load == "constant":
        return None
    half = math.copysign(math.pi / len(system.motion.theta), scene.cycle_rate)
    motion = solve_motion(scene, system.motion.theta - half, near=system.motion)
    situation = Situation(scene.changed(effects=()), system.beams, motion)  # axial forces load nothing by themselves
    return replace(system, motion=motion, terms=build_terms(situation)).load


def scene_modes(scene: Scene, system: System) -> Modes:
    """Solve for the modes that the scene keeps."""
    count = system.size if scene.analysis.modes == "all" else scene.analysis.modes
    return solve_modes(system, count, scene.petsc)


def settle(system: System, respond: Callable[[System], History]) -> System:
    """Update the tension of the geometric stiffness with the response until it settles.

    Parameters
    ----------
    system
        The mechanism with the effect 'geometric-stiffness'.
    respond
        Gives the response of a mechanism.

    Raises
    ------
    SolverError
        When the axial forces do not settle.
    """
    for _ in range(MOST_UPDATES):
        tension = mean_tension(system, respond(system))
        before = system.terms.tension
        assert before is not None
        change = np.abs(tension - before).max() / max(float(np.abs(tension).max()), 1e-300)
        system = with_tension(system, tension)
        if change < SETTLED:
            return system
    raise SolverError(
        f"the axial forces do not settle: after {MOST_UPDATES} updates they still change by {change:.1e} of the "
        "largest. Take the effect 'moderate-rotations' instead of 'geometric-stiffness' with tension = 'settled'"
    )


def with_tension(system: System, tension: NDArray[np.float64]) -> System:
    """Give a system whose geometric stiffness comes from another axial force (N), ``(angles, elements)``."""
    blocks = tension[..., None, None] * system.beams.stretching.bow
    return replace(system, terms=replace(system.terms, tension=tension, element_stiffness=blocks))
