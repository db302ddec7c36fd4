"""What is wrong with a result by more than its estimates of errors say."""

from __future__ import annotations

import numpy as np

from fenics_mech.accuracy.transient_errors import own_steps
from fenics_mech.effects.springs import too_stiff
from fenics_mech.response.periodic.steps import loads_act_like_impulses
from fenics_mech.response.solution import (
    CollocationSolution,
    FreeSolution,
    HarmonicSolution,
    Solution,
    StaticSolution,
    SubIntervalSolution,
    SuperposedSolution,
    TransientSolution,
)
from fenics_mech.scene.sampling import SAMPLING

NO_ESTIMATE = "all errors, as none is estimated there"  # of a point of a sweep without error estimates
UNKNOWN_AFTER_CONTACT = "the error of the time steps, which contacts may make as large as the motion itself"


def not_estimated(solution: Solution) -> list[str]:
    """Say what is wrong by more than any of the estimates says.

    Parameters
    ----------
    solution
        A solution of any method.

    Returns
    -------
    list of str
        Phrases; empty where there is nothing to say.
    """
    found = _of_loads(solution)
    if isinstance(solution, TransientSolution):
        found += _of_start(solution)
    if isinstance(solution, SuperposedSolution):
        found.append("what the mesh does to modes that are superposed in time")
    if isinstance(solution, FreeSolution):
        found.append("what the mesh does to a motion with freedoms")
        found += [UNKNOWN_AFTER_CONTACT] if solution.course.touched else []
    if isinstance(solution, SubIntervalSolution) and solution.scene.analysis.join == "modal":
        found.append("what join = 'modal' loses where the modes' shapes change, whatever the number of sub_intervals")
    springs = too_stiff(solution.scene)
    found += [f"what damping.ratio makes of the torsional spring {name!r}, by the mesh" for name in springs]
    return found + _between_positions(solution)


def _of_loads(solution: Solution) -> list[str]:
    """Vibration that loads excite beyond what mesh and modes resolve."""
    found, beyond = [], "put into vibration that mesh and modes are too coarse for"
    if solution.scene.impulses and not isinstance(solution, StaticSolution):
        found.append(f"what impulses {beyond}")
    if solution.scene.loads and isinstance(solution, CollocationSolution) and loads_act_like_impulses(solution.scene):
        found.append(f"what pulses much shorter than a step {beyond}")
    return found


def _of_start(solution: TransientSolution) -> list[str]:
    """What a motion in time has by its steps and by its start."""
    scene = solution.scene
    reduced, started = scene.analysis.reduction != "none", scene.analysis.start != "rigid"
    remarks = (
        (own_steps(scene.petsc), "the time steps, which PETSc's options state"),
        (reduced and started, "what the start puts into the modes left out of members"),
        (
            reduced and any(load.jumps for load in scene.loads.values()),
            "what loads that jump put into the modes left out of members",
        ),
        (
            started and bool(scene.damping.material),
            "strains in the first instants, where the start lets the material's viscous stress jump",
        ),
        (
            started and bool(np.any(scene.damping.ratio)),
            "joint forces in the first instants, where the start lets the forces of damping jump",
        ),
    )
    return [words for holds, words in remarks if holds]


def _between_positions(solution: Solution) -> list[str]:
    """What loads and drives do between the points of a cycle."""
    scene, count = solution.scene, _points_of(solution)
    if not count:
        return []
    cut = isinstance(solution, CollocationSolution)  # steps are cut at corners of the loads' factors
    loads = [
        f"what the factor of the load {name!r} does between positions, which do not see it"
        for name, load in scene.loads.items()
        if not (cut and load.cut_where_needed)
        if load.share_missed(count) > SAMPLING.unresolved or load.enough_angles(count) > count
    ]
    drives = [drive for drive in scene.drives if drive.enough_angles(count, scene.cycle_rate) > count]
    return loads + [f"what the law of the drive at {drive.joint!r} does between positions" for drive in drives]


def _points_of(solution: Solution) -> int:
    """Number of points of a cycle that see what a load or a drive does; 0 where steps are as short as they need be."""
    scene, analysis = solution.scene, solution.scene.analysis
    if isinstance(solution, TransientSolution):  # the viscous stress is judged by every second position
        return analysis.sub_intervals // 2 if scene.damping.material else 0
    if analysis.method == "static":
        return 0
    by_points = isinstance(solution, CollocationSolution | HarmonicSolution)
    return analysis.sub_intervals * (analysis.stages if by_points else 1)
