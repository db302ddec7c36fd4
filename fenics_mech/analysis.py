"""The analysis of a scene: plan, build, solve, estimate the errors, collect the result."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection
from typing import overload

from fenics_mech._guard import guarded
from fenics_mech.answers.by_poses import RefinedByPoses, by_poses
from fenics_mech.answers.by_sub_intervals import by_sub_intervals
from fenics_mech.answers.in_space import in_space
from fenics_mech.answers.in_time_by_poses import in_time_by_poses
from fenics_mech.answers.out_of_plane import across_the_plane
from fenics_mech.answers.repeated_by_poses import repeated_by_poses
from fenics_mech.answers.rigid_at_rest import rigid_at_rest
from fenics_mech.answers.rigid_by_poses import rigid_by_poses
from fenics_mech.answers.rigid_in_time import rigid_in_time
from fenics_mech.answers.solved_by_poses import Run
from fenics_mech.classical.known import has_modes
from fenics_mech.errors import SceneError
from fenics_mech.joints.dry_friction import creeping
from fenics_mech.joints.torsional_springs import wound_at_start
from fenics_mech.kinematics import assembly_notices, reachable_range
from fenics_mech.kinematics.free_linkage import with_freedoms
from fenics_mech.planning.answer_remarks import answer_remarks
from fenics_mech.planning.fine_enough import fine_enough
from fenics_mech.planning.law_choice import choose_laws
from fenics_mech.planning.meet_tolerance import within
from fenics_mech.planning.start_state import state_to_go_on_from
from fenics_mech.recovery import Result
from fenics_mech.recovery.spatial_result import SpatialResult
from fenics_mech.safety.load_cases import of_cases
from fenics_mech.scene import Scene
from fenics_mech.scene.in_space import SpatialScene
from fenics_mech.scene.load_cases import scenes_of, told_of_case

logger = logging.getLogger(__name__)
STEPS = ("effects", "kinematics", "beams", "modes", "response", "recovery", "errors")
Progress = Callable[[str], None]


@overload
def analyse(scene: SpatialScene) -> SpatialResult: ...


@overload
def analyse(
    scene: Scene,
    progress: Progress = ...,
    run: Run | None = ...,
    names: Collection[str] | None = ...,
) -> Result: ...


@guarded()
def analyse(
    scene: Scene | SpatialScene,
    progress: Progress = lambda step: None,
    run: Run | None = None,
    names: Collection[str] | None = None,
) -> Result | SpatialResult:
    """Analyse a scene as its `analysis` states.

    Parameters
    ----------
    scene
        The scene. The others are of scenes in the plane.
    progress
        Called with the name of each of `STEPS` as it begins.
    run
        Motions before it, such as those at other speeds, from which its own is sought; that is added to them.
    names
        Variables that the result is to hold, with those that come with them; None for all. A scene with a tolerance
        has all of them.

    Returns
    -------
    Result or SpatialResult
        Strains, stresses, forces, deflections, their errors, and every decision that was taken. Mesh and steps that
        the scene does not state are as fine as the answer needs; those that it states are kept, and the errors told.

    Raises
    ------
    AssemblyError
        When the links cannot be assembled at some drive angle.
    SolverError
        When a solver does not converge, or an error is too large.
    SceneError
        When a periodic response is asked for and nothing is driven.

    Examples
    --------
    >>> result = fm.analyse(fm.load("demos/four_bar.toml").changed({"analysis.sub_intervals": 90}))
    >>> print(f"{abs(result.data['strain'].sel(member='coupler')).max().item():.4f}")
    0.0003
    """
    if isinstance(scene, SpatialScene):
        return in_space(scene)
    if scene.cases:
        return _of_cases(scene, progress, run, names)
    _refuse_undriven(scene)
    progress("effects")
    of_start = assembly_notices(scene)
    scene, _ = choose_laws(stated := scene)
    may_rest = scene.analysis.method == "static" and (scene.freedoms or not scene.members())
    if scene.analysis.method == "transient" or may_rest:
        scene = with_freedoms(scene)
    if not scene.members():
        progress("response")
        result = fine_enough(scene, lambda finer: _of_rigid_links(finer, stated))
    elif scene.analysis.method == "transient" and scene.analysis.start == "periodic":
        result = fine_enough(scene, repeated_by_poses)
    elif scene.tolerance is None and has_modes(scene):
        result = fine_enough(scene, lambda finer: by_sub_intervals(finer, names))
    elif scene.analysis.method == "transient":
        result = fine_enough(scene, in_time_by_poses)
    elif scene.tolerance is None:
        result = fine_enough(scene, lambda finer: by_poses(finer, run, names))
    else:
        result = within(scene, RefinedByPoses())
    if scene.analysis.out_of_plane:
        result.data.update(across_the_plane(stated))
    said = [*of_start, *wound_at_start(stated, scene), *creeping(scene)]
    result.data.attrs.update(answer_remarks(scene, result, said))
    return result


def _of_rigid_links(scene: Scene, stated: Scene) -> Result:
    """Analyse a scene of which no link bends; `stated` may leave open where its freedoms are."""
    start = state_to_go_on_from(scene, 0)
    if not scene.freedoms:
        return rigid_by_poses(scene)
    if scene.analysis.method == "static":
        return rigid_at_rest(scene, any(part.start is not None for part in stated.freedoms.values()))
    return rigid_in_time(scene, start)


def _of_cases(scene: Scene, progress: Progress, run: Run | None, names: Collection[str] | None) -> Result:
    """Analyse a scene in each of its load cases, and give the result of the governing one with all of them."""
    found = {}
    for name, case in scenes_of(scene).items():
        with told_of_case(name):
            found[name] = analyse(case, progress, run, names)
    return of_cases(scene, found)


def _refuse_undriven(scene: Scene) -> None:
    """Raise `SceneError` where a periodic response is asked for and nothing is driven."""
    if scene.analysis.method == "periodic" and not scene.drives:
        free = "".join(f"; {freedom}" for freedom in reachable_range(scene).free)
        raise SceneError(
            f"a periodic response needs a drive, and the scene has none: there is no period{free}",
            place="analysis.method",
            hint="Add a [drive], or write method = 'quasi-static'",
        )
