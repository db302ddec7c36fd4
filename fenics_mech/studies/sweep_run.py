"""A sweep that is being made: its points, the processes that share them, and what is kept of each."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._files import reason_of, write_table, write_whole
from fenics_mech._ranks import together
from fenics_mech._version import __version__
from fenics_mech.answers.solved_by_poses import Run
from fenics_mech.effects.known import EXACT_STRAINS
from fenics_mech.errors import ResultError, UnresolvedError
from fenics_mech.scene import Scene
from fenics_mech.scene.joints import effort_units
from fenics_mech.scene.models import OF_LINKS
from fenics_mech.solve.last_motions import LastMotions
from fenics_mech.studies.gauge import Gauge
from fenics_mech.studies.kept_points import CURVES_TEXT, KEPT, TEXTS, kept_point, read_point
from fenics_mech.studies.kept_records import Record, lost, record_file, write_record
from fenics_mech.studies.point_curves import MOST_POINTS, with_curves
from fenics_mech.studies.saved_sweep import plan_before, refuse_other
from fenics_mech.studies.sweep_axes import Axis, placed
from fenics_mech.studies.sweep_peaks import peaks_of, unresolved
from fenics_mech.studies.sweep_points import Task, compute_here, compute_point, stacked, tabulated
from fenics_mech.studies.worker_processes import Workers

# In a run of neighbouring points, each for one process, Newton's method begins each motion from the one before it. Such
# runs are the same however many processes share the points, so that the result is the same too. A run also shows which
# points are peaks while their answers are still kept.
LONGEST = 8  # points of a run: processes share runs, and the first point of each begins from nothing


def longest_run(scene: Scene) -> int:
    """Give the most points of a run: 1 where no motion needs Newton's method."""
    exact = scene.effects == "auto" or EXACT_STRAINS in scene.named_effects
    return LONGEST if exact and scene.analysis.method == "periodic" else 1


def runs_of(points: Sequence[Sequence[float]], missing: Collection[int], longest: int) -> list[list[int]]:
    """Split those points that are missing into runs."""
    runs: list[list[int]] = []
    for number, point in enumerate(points):
        changes = sum(here != before for here, before in zip(point, points[number - 1]))
        if number and len(runs[-1]) < longest and changes == 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    left = [[number for number in run if number in missing] for run in runs]
    return [run for run in left if run]


def shrinking_runs(missing: Sequence[int], processes: int) -> list[list[int]]:
    """Split points that do not depend on others into runs, long ones first, so that processes end together."""
    runs, left = [], list(missing)
    while left:
        count = max(1, len(left) // (2 * processes)) if processes > 1 else len(left)
        runs.append(left[:count])
        left = left[count:]
    return runs


Found = TypeVar("Found")
Point = tuple[float, ...]  # the value of each field


def grid(values: Sequence[Sequence[float]]) -> list[Point]:
    """Give the points of a grid."""
    return list(itertools.product(*values))


@dataclass(frozen=True)
class SweepRun:
    """A sweep being made by the processes of a communicator, or by several of this machine."""

    scene: Record
    axes: tuple[Axis, ...]
    folder: Path
    gauge: Gauge
    comm: Any
    progress: Callable[[int, int], None]
    workers: Workers
    at_peaks_alone: bool
    before: Run = field(default_factory=LastMotions)
    paths: dict[Point, Path] = field(default_factory=dict, init=False)

    @property
    def points(self) -> Path:
        """Folder of the files of the points."""
        return self.folder / "points"

    @cached_property
    def without_estimates(self) -> SweepRun:
        """The same sweep without error estimates."""
        return replace(self, scene=placed(self.scene, {"analysis.error_estimates": False}))

    @cached_property
    def any_scene(self) -> Scene:
        """The scene without the sweep: its members and joints are those of all points."""
        return Scene.read(self.scene)

    @property
    def keeps_curves(self) -> bool:
        """Whether points keep their curves over the cycle: those of a line that is not too long."""
        return len(self.axes) == 1 and len(self.axes[0].values) <= MOST_POINTS

    def over(self, values: Sequence[Sequence[float]], refine_peaks: int) -> Sequence[Sequence[float]]:
        """Compute the points of a grid, with points added at peaks, and give the values with these."""
        at_peaks = self.at_peaks_alone
        quick = self.without_estimates if at_peaks else self
        quick.compute(grid(values))
        left = refine_peaks
        while left and (added := quick.at_peaks(values, left)):
            values = [tuple(sorted((*values[0], *added)))]
            quick.compute(grid(values))
            left -= len(added)
        if at_peaks:
            self.compute(quick.at_root(lambda: quick.ends_and_peaks(values)))
        return values

    def answer_at(self, value: float) -> Record:
        """Give what is kept of a point between those of a line; the first process calls this alone."""
        quick = self.without_estimates if self.at_peaks_alone else self
        task = quick.task((value,), None)._replace(curves=False)
        if read_point(task.path, self.any_scene) is None:
            compute_point(task, self.before)
        return quick.records([(value,)])[0]

    def with_errors(self, values: Sequence[Sequence[float]]) -> set[Point]:
        """Give the points of a grid whose errors are estimated."""
        if not self.at_peaks_alone:
            return set(grid(values))
        return self.at_root(lambda: set(self.without_estimates.ends_and_peaks(values)))

    def answers_of(self, points: Sequence[Point], estimated: Collection[Point]) -> list[Record]:
        """Compute single points, some with their errors, and give what is kept of them."""
        parts = {True: self, False: self.without_estimates}
        found: dict[Point, Record] = {}
        for whether in {point in estimated for point in points}:  # a tolerance is met by estimates: none is without
            some, part = [point for point in points if (point in estimated) == whether], parts[whether]
            part.compute(some)
            found |= zip(some, self.at_root(partial(part.records, some)))
        return [found[point] for point in points]

    def at_root(self, work: Callable[[], Found]) -> Found:
        """Let the first process work and give all of them what it found, or its error."""
        return self.comm.bcast(together(self.comm, lambda: work() if self.comm.rank == 0 else None))

    def claim_folder(self) -> None:
        """Write what is swept into the folder, unless another sweep is there."""
        plan = {
            "scene": placed(self.scene, dict.fromkeys((axis.path for axis in self.axes), None)),
            "gauge": asdict(self.gauge),
            "values": {axis.path: list(axis.values) for axis in self.axes},
        }
        path = self.folder / "sweep.json"
        try:
            self.points.mkdir(parents=True, exist_ok=True)
            before = plan_before(path) if path.exists() else plan
            if folder := next((entry for entry in self.points.iterdir() if entry.is_dir()), None):
                raise ValueError(f"{folder.name} in {self.points} is a folder, and points are files. Remove it")
        except (OSError, ValueError) as error:
            raise ResultError(f"{self.folder}: cannot be used for a sweep: {reason_of(error)}") from error
        refuse_other(before, plan, self.folder)
        write_whole(path, lambda temporary: temporary.write_text(json.dumps(plan, indent=1)))

    def compute(self, points: Sequence[Point]) -> None:
        """Compute those points that are missing."""
        # Points whose links are the same follow each other.
        links = [number for number, axis in enumerate(self.axes) if axis.path.split(".")[0] in OF_LINKS]
        points = sorted(points, key=lambda point: [point[number] for number in links])
        missing = self.at_root(
            lambda: [
                index for index, point in enumerate(points) if read_point(self.path(point), self.any_scene) is None
            ]
        )
        longest = longest_run(self.any_scene)
        shrinking = longest == 1 and self.comm.size == 1
        runs = shrinking_runs(missing, self.workers.count) if shrinking else runs_of(points, set(missing), longest)
        mine = runs[self.comm.rank :: self.comm.size]
        begun, count = itertools.count(), sum(map(len, mine))
        gone = dict.fromkeys(TEXTS, "") | lost("the process that computed this point")

        def tasks(run: Sequence[int]) -> Iterator[Task]:
            def task(index: int) -> Task:
                return self.task(points[index], points[run[0]] if longest > 1 and index != run[0] else None)

            return map(task, run)

        def started(_: Task) -> None:
            self.progress(next(begun), count)

        def work() -> None:
            if self.workers.count > 1:
                self.workers.share(map(tasks, mine), compute_here, lambda task: write_record(task.path, gone), started)
                return
            for task in itertools.chain.from_iterable(map(tasks, mine)):
                started(task)
                compute_point(task, self.before)

        together(self.comm, work)

    def task(self, point: Point, first: Point | None) -> Task:
        """Give the task of a point in a run; `first` is the first point of the run, None for that itself."""
        place = None if first is None else sum(here - there for here, there in zip(point, first))  # all but one are 0
        motion = self.without_estimates.path(point).with_suffix(".motion") if self.at_peaks_alone else None
        return Task(self.path(point), self.scene_of(point), self.gauge, place, motion, self.keeps_curves)

    def scene_of(self, point: Sequence[float]) -> Record:
        """Give the scene of a point."""
        return placed(self.scene, dict(zip((axis.path for axis in self.axes), point)))

    def path(self, point: Point) -> Path:
        """Give the file of a point."""
        if point not in self.paths:
            self.paths[point] = record_file(self.points, __version__, self.scene_of(point), asdict(self.gauge))
        return self.paths[point]

    def followed_file(self, value: float, first: float, last: float) -> Path:
        """Give the file of a point of a gap, into which motions are followed from points beside it."""
        data = {**self.scene_of((value,)), "followed_into": [first, last]}
        return record_file(self.points, __version__, data, asdict(self.gauge))

    def records(self, points: Sequence[Point]) -> list[Record]:
        """Read points, those to be tried again too."""
        found = {self.path(point): kept_point(self.path(point), self.any_scene) for point in points}
        if lost := [path for path, record in found.items() if record is None]:
            raise ResultError(f"{lost[0]}: was removed or changed while the sweep ran: start it again")
        return [record for record in found.values() if record is not None]

    def peaks(self, points: Sequence[Point]) -> Array:
        """Give the peak strains at points, ``(points, members)``; one column of NaN where all have failed."""
        strains = [record.get("values", {}).get("peak_strain") for record in self.records(points)]
        return stacked(strains).reshape(len(points), -1)

    def ends_and_peaks(self, values: Sequence[Sequence[float]]) -> list[Point]:
        """Give the points at the corners of a grid, and where a member's peak strain is no less than beside it."""
        # Points that failed are not among them: with estimates they fail as well.
        points, shape = grid(values), [len(along) for along in values]
        peaks = self.peaks(points)
        found = peaks_of(peaks.reshape(*shape, -1), len(shape)).ravel() & ~np.isnan(peaks).all(axis=1)
        return [point for point, there in zip(points, found) if there]

    def at_peaks(self, values: Sequence[Sequence[float]], most: int) -> list[float]:
        """Give the values of the field at which peaks of strain are not resolved, at most so many."""
        return self.at_root(lambda: unresolved(np.array(values[0]), self.peaks(grid(values)))[:most])

    def answers(self, values: Sequence[Sequence[float]]) -> list[Record]:
        """Give the points of a grid: those that are not estimated are of a sweep without estimates."""
        if not self.at_peaks_alone:
            return self.records(grid(values))
        quick, its_own = self.without_estimates, set(self.without_estimates.ends_and_peaks(values))
        return [self.kept(quick, point) if point in its_own else quick.records([point])[0] for point in grid(values)]

    def kept(self, quick: SweepRun, point: Point) -> Record:
        """Give what is kept of a point with estimates: of one that they refuse, the answer and the message."""
        # Else curves would have gaps at their peaks, beside points that are as coarse and have no estimates.
        (found,) = self.records([point])
        if quick is self or found["error"] != UnresolvedError.__name__:
            return found
        return quick.records([point])[0] | {"not_estimated": "", "too_coarse": found["message"]}

    def finish(self, values: Sequence[Sequence[float]], records: Sequence[Record]) -> xr.Dataset:
        """Write the time that each point took, and label the numbers of all."""
        for motion in self.points.glob("*.motion"):
            motion.unlink(missing_ok=True)
        places = itertools.product(*values)
        head = [*(f"{axis.path} ({axis.unit})" for axis in self.axes), "seconds", "error"]
        rows = [(*at, record["seconds"], record["error"]) for at, record in zip(places, records)]
        write_table(self.folder / "timings.csv", [head, *rows])
        paths, shape = [axis.path for axis in self.axes], [len(along) for along in values]
        texts = {name: np.array([record[name] for record in records], dtype=object).reshape(shape) for name in TEXTS}
        data = xr.Dataset({name: (paths, text, {"long_name": TEXTS[name]}) for name, text in texts.items()})
        for axis, along in zip(self.axes, values):
            units = {"units": axis.unit, "written_units": axis.written[0], "written_factor": axis.written[1]}
            data = data.assign_coords({axis.path: (axis.path, list(along), units)})
        first = Scene.read(placed(self.scene, {path: along[0] for path, along in zip(paths, values)}))
        data = tabulated(data, records, KEPT, first, dict(zip(paths, shape)))
        if self.keeps_curves:
            curves = [str(record.get(CURVES_TEXT, "")) for record in records]
            effort = {"curve_input_torque": effort_units(first.moved_joints, first.joints)[0]} if first.drives else {}
            data = with_curves(data, paths[0], curves, first, effort)
        data.attrs = {"fenics_mech": __version__, "title": first.name, "scene": first.model_dump_json()}
        data.attrs |= {"paths": json.dumps(paths), "gauge": json.dumps(asdict(self.gauge))}
        data.attrs["stated_rate"] = abs(self.any_scene.cycle_rate)  # of the scene as it is without the sweep
        return data
