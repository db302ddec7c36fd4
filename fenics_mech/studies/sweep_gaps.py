"""Points of a sweep that found no stable motion: what continuation says from the stable motions beside them.

Under exact strains several motions may exist at a value, or none that is stable. The motion of the nearest stable point
on either side is followed towards the others, through folds. Points that it passes have an answer, stable or not. Of
the rest it is told where the stable motions end, and how.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import groupby, islice, pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from fenics_mech._guard import guarded
from fenics_mech.answers.followed_by_poses import AtValue, followed
from fenics_mech.answers.followed_by_poses import followable as may_be_followed
from fenics_mech.answers.solved_by_poses import Run
from fenics_mech.effects.known import EXACT_STRAINS
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.scene import Scene
from fenics_mech.solve import Path as Steps
from fenics_mech.solve.continuation import FOLD, Point
from fenics_mech.studies.kept_points import read_point
from fenics_mech.studies.kept_records import Record, write_record
from fenics_mech.studies.one_equation import numbers_of, scene_with, union
from fenics_mech.studies.sweep_axes import placed
from fenics_mech.studies.sweep_points import Task, compute_point

if TYPE_CHECKING:
    from fenics_mech.studies.sweep_run import SweepRun

logger = logging.getLogger(__name__)
LOST = "NoStableMotion"  # error of a point that no stable motion beside it reaches
NO_MOTION = "SolverError", "UnresolvedError", "UnstableError", LOST  # errors of points that continuation looks into
POINTS = 6  # along a gap at least
MOST = 20  # of a branch, before it is left: unstable ones may wind for ever
REAL = 1e-6  # imaginary part of a multiplier that counts as none


@dataclass(frozen=True)
class Ahead:
    """The motions from a stable point on."""

    start: float  # value of the point
    # ended, beyond: the last value at which they are known to be stable, and the first one at which they are not
    ended: float
    beyond: float
    how: str  # what ends that, in words; empty where they are stable to the end
    # by value that they pass, whether the motion is stable there, and one beside it
    reached: dict[float, tuple[bool, Steps]] = field(default_factory=dict)


def gaps_of(records: Sequence[Record]) -> list[range]:
    """Give the runs of neighbouring points of a line that have no stable motion."""
    lacking = [record["error"] in NO_MOTION or bool(record["unstable"]) for record in records]
    runs = [list(run) for without, run in groupby(range(len(records)), lacking.__getitem__) if without]
    return [range(run[0], run[-1] + 1) for run in runs]


def followable(record: Record, scene: Scene) -> bool:
    """Whether a point has a stable motion that is not the only one by its equation, and can be followed."""
    exact = EXACT_STRAINS in record["effects"].split(", ")
    if record["error"] or record["unstable"] or not exact or scene.tolerance is not None:
        return False
    try:
        may_be_followed(scene)
    except SceneError:
        return False
    return True


@guarded()
def ahead(at: AtValue, path: str, ends: tuple[float, float], values: Sequence[float]) -> Ahead | None:
    """Follow the motions from a stable point to the other end of a gap; None where there is none to begin with."""
    found: list[Point] = []
    how = f"followed through {MOST} motions"
    try:
        for one, _ in islice(followed(at, path, ends, POINTS), MOST):
            found.append(one)
            logger.info("followed to %.6g: stable %s", one.value, one.stable)
    except (SolverError, SceneError) as error:
        logger.info("the branch from %.6g ends: %s", ends[0], error)
        how = "Newton's method does not go on"
    if not found:
        return None
    stable = [one.stable for one in found]
    last = stable.index(False) if False in stable else len(stable)
    if last < len(stable):
        how = _kind(found[last].leading, [one.kind == FOLD for one in found[max(last - 1, 0) : last + 3]])
    reached: dict[float, tuple[bool, Steps]] = {}
    for before, after in pairwise(found):
        both = before.stable and after.stable
        for value in values:
            passes = (before.value - value) * (after.value - value) <= 0
            if passes and (value not in reached or (both and not reached[value][0])):
                reached[value] = both, after.cycle.path
    if last == len(stable) and found[-1].value == ends[1]:
        how = ""
    ended, beyond = (found[min(max(k, 0), len(found) - 1)].value for k in (last - 1, last))
    return Ahead(ends[0], ended, beyond, how, reached)


def _kind(leading: complex, folds: Sequence[bool]) -> str:
    """Name how a motion has become unstable: by its leading multiplier."""
    if abs(leading.imag) > REAL:
        return "a vibration of another frequency grows (Neimark-Sacker)"
    if leading.real < 0:
        return "a vibration of half the frequency grows (period doubling)"
    return "the branch turns back (a fold)" if any(folds) else "the branch divides"


def in_words(found: Sequence[Ahead], told: Callable[[float], str]) -> str:
    """Say from where motions were followed, and where they are no longer stable."""
    said = []
    for one in found:
        if one.how:
            end, beyond = told(one.ended), told(one.beyond)
            where = f"up to {end}" if beyond == end else f"at {end} and no longer at {beyond}"
            said.append(f"the motion of {told(one.start)} is stable {where}: {one.how}")
    return f"By continuation {'; '.join(said)}" if said else ""


def fill_gaps(run: SweepRun, values: Sequence[float], records: Sequence[Record]) -> list[Record]:
    """Give what is kept of the points of a line, with what continuation finds where no stable motion was found."""
    found = list(records)
    for gap in gaps_of(records):
        beside = [k for k in (gap.start - 1, gap.stop) if 0 <= k < len(values)]
        beside = [k for k in beside if followable(records[k], Scene.read(run.scene_of((values[k],))))]
        if not beside:
            continue
        paths = {k: run.followed_file(values[k], values[gap.start], values[gap.stop - 1]) for k in gap}
        if any(read_point(path, run.any_scene) is None for path in paths.values()):
            _follow_into(run, values, found, gap, beside, paths)
        for k, path in paths.items():
            found[k] = read_point(path, run.any_scene) or found[k]
    return found


def _follow_into(
    run: SweepRun,
    values: Sequence[float],
    records: Sequence[Record],
    gap: range,
    beside: Sequence[int],
    paths: Mapping[int, Path],
) -> None:
    """Follow the motions from both sides into a gap, and write what is found of its points."""
    axis, inside = run.axes[0], [values[k] for k in gap]
    branches: list[tuple[Ahead, Record]] = []  # with the scene that each was followed in
    for k in beside:
        far = gap.stop if k < gap.start else gap.start - 1
        end = values[min(max(far, 0), len(values) - 1)]
        base = scene_with(run.scene, numbers_of(records[k]), union({records[k]["effects"]}))
        quick = partial(_scene_at, placed(base, {"analysis.error_estimates": False}), axis.path)
        if (one := ahead(quick, axis.path, (values[k], end), inside)) is not None:
            branches.append((one, base))
    said = in_words([one for one, _ in branches], axis.told)
    for k in gap:
        record = _passed(run, values[k], records[k], branches, paths[k])
        if record["error"] in NO_MOTION and said:
            record |= {"error": LOST, "message": f"no stable motion is found. {said}", "again": False}
        elif record["unstable"] and said:
            record["unstable"] = f"{record['unstable']}. {said}"
        write_record(paths[k], record)


def _scene_at(scene: Record, path: str, value: float) -> Scene:
    return Scene.read(placed(scene, {path: value}))


def _passed(
    run: SweepRun, value: float, before: Record, branches: Sequence[tuple[Ahead, Record]], path: Path
) -> Record:
    """Analyse a point from a motion that passes it, a stable one if there is one; else give what was known before."""
    passing = [(one, scene) for one, scene in branches if value in one.reached]
    passing.sort(key=lambda each: not each[0].reached[value][0])
    if not passing or not (before["error"] or passing[0][0].reached[value][0]):
        return dict(before)
    (one, scene), near = passing[0], Run()
    near.keep(one.reached[value][1])
    estimates = not run.at_peaks_alone and run.any_scene.analysis.error_estimates
    data = placed(scene, {run.axes[0].path: value, "analysis.error_estimates": estimates})
    compute_point(Task(path, data, run.gauge, 0.0, None, run.keeps_curves), near)
    return dict(read_point(path, run.any_scene) or before)
