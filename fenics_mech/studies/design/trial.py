"""One trial of a study: the scene at values of its variables, analysed, and the numbers that the study looks at.

A trial that fails has its error as a value, and NaN for its numbers. Finished trials are files, and not run again.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

from pydantic import Field, TypeAdapter

from fenics_mech._files import reason_of
from fenics_mech._guard import guarded
from fenics_mech._read_back import LARGEST_STRAIN, Ended, Text, read_kept
from fenics_mech._system import alone_in
from fenics_mech._version import __version__
from fenics_mech.analysis import analyse
from fenics_mech.answers.by_poses import answered, has_poses
from fenics_mech.answers.solved_by_poses import AtRest as AnswersAtRest
from fenics_mech.answers.solved_by_poses import Solved
from fenics_mech.errors import MechanismError, ResultError
from fenics_mech.recovery import Result
from fenics_mech.scene import Scene
from fenics_mech.scene.study import Target
from fenics_mech.studies.design.design_variables import Design
from fenics_mech.studies.design.result_numbers import Quantity, read_all, total_mass
from fenics_mech.studies.kept_records import Record, ended, lost, record_file, write_record
from fenics_mech.studies.lead_process import leads, over_machines
from fenics_mech.studies.sweep_axes import placed, stated_data
from fenics_mech.studies.worker_processes import Workers


@contextmanager
def kept_folder(folder: str | Path | None) -> Iterator[Path]:
    """Give a folder in which no other study works meanwhile."""
    # The system lets it free with the process, however that ends.
    if folder is None:
        with TemporaryDirectory() as made:
            yield Path(made)
        return
    path = Path(folder)
    missing = [one for one in (path, *path.parents) if not one.exists()]
    try:
        path.mkdir(parents=True, exist_ok=True)
        os.scandir(path).close()  # who cannot read a folder cannot hold it against others
    except OSError as error:
        raise ResultError(f"{path}: cannot be used for trials: {reason_of(error)}") from error
    try:
        with alone_in(path) as alone:
            if not alone:
                said = f"{path}: another study works in this folder: wait for its end, or give another folder"
                raise ResultError(said)
            yield path
    finally:
        with suppress(OSError):  # one holds something
            for one in missing:
                one.rmdir()


Answer = Solved | AnswersAtRest  # by the equation of poses
Analysed = Callable[[Scene, tuple[float, ...]], Result]  # of a scene, and the values of its variables
Number = Annotated[float, Field(allow_inf_nan=False)]


@dataclass(frozen=True)
class Trial:
    """What one trial found."""

    values: tuple[float, ...]  # values of the variables, in SI
    numbers: dict[str, float]  # numbers of the result by name; NaN where the trial failed
    # error, message: kind of the error that it ended with and what that said; empty where it did not fail
    error: str
    message: str
    seconds: float  # how long it took

    @property
    def failed(self) -> bool:
        """Whether it ended with an error."""
        return bool(self.error)


class _Kept(Ended):
    """What is kept of a trial."""

    numbers: dict[Text, Number | None]
    values: tuple[Number, ...]


KEPT = TypeAdapter(_Kept)


@dataclass(frozen=True)
class Task:
    """What a process needs for one trial."""

    path: Path | None
    values: tuple[float, ...]
    scene: Record
    changes: Record
    quantities: tuple[Quantity, ...]
    targets: Mapping[str, Target]


def known(task: Task) -> Record | None:
    """Read a finished trial; None where there is none, or one that is to be tried again."""
    record = read(task)
    return None if record is None or record["again"] else record


def read(task: Task) -> Record | None:
    """Read a trial that was run; None where there is none."""
    record = read_kept(task.path, KEPT)
    if record is None or record["values"] != task.values or wrong_numbers(task.quantities, record["numbers"]):
        return None
    return dict(record)


def run_task(task: Task, analysed: Analysed = lambda scene, _: analyse(scene)) -> Record:
    """Run one trial and keep it."""
    nothing: Record = {"numbers": dict.fromkeys(names_of(task.quantities)), "values": task.values}
    record = nothing | ended(lambda: {"numbers": numbers_of(task, analysed)})
    write_record(task.path, record)
    return record


def numbers_of(task: Task, analysed: Analysed) -> dict[str, float]:
    """Analyse the scene of a trial, unless its mass is all that is asked for, and give its numbers by name."""
    scene = Scene.read(placed(task.scene, task.changes))
    if all(quantity.name == "mass" for quantity in task.quantities):
        return {quantity.text: total_mass(scene, quantity.labels) for quantity in task.quantities}
    result = analysed(scene, task.values)
    found = read_numbers(task.quantities, result, task.targets)
    if missing := [name for name, value in found.items() if not math.isfinite(value)]:
        raise MechanismError(f"{', '.join(missing)} has no value in this result")
    if wrong := wrong_numbers(task.quantities, found):
        raise MechanismError(wrong)
    return found


def wrong_numbers(quantities: Sequence[Quantity], numbers: Mapping[str, float | None]) -> str:
    """Say which numbers are not those of the quantities, or not possible; an empty text where none are."""
    if numbers.keys() != {*names_of(quantities)}:
        return "these are other numbers"
    strains = [name for quantity in quantities if quantity.name == "strain" for name in quantity.names]
    large = [name for name in strains if abs(numbers[name] or 0.0) > LARGEST_STRAIN]
    return f"{large[0]} is {numbers[large[0]]:.6g}, which no member reaches" if large else ""


def read_numbers(quantities: Sequence[Quantity], result: Result, targets: Mapping[str, Target]) -> dict[str, float]:
    """Give the numbers of all quantities of a result, by name."""
    found: dict[str, float] = {}
    for quantity in quantities:
        found |= quantity.numbers(result, targets)
    return found


def names_of(quantities: Sequence[Quantity]) -> list[str]:
    """Give the names of all numbers of quantities."""
    return [name for quantity in quantities for name in quantity.names]


def run_here(task: Task) -> None:
    """Run one of the trials of a worker process."""
    run_task(task)


def run_there(task: Task) -> Record:
    """Run one of the trials of a process that another one leads, which keeps it."""
    return run_task(replace(task, path=None))


def give_up(task: Task) -> None:
    """Write that the process of a trial was lost; the trial is run again by the next study."""
    numbers = dict.fromkeys(names_of(task.quantities))
    write_record(task.path, lost("the process of this trial") | {"numbers": numbers, "values": task.values})


@dataclass(frozen=True)
class Trials:
    """The trials of a design."""

    design: Design  # the scene and its variables
    quantities: tuple[Quantity, ...]  # the numbers that are looked at
    folder: Path | None = None  # where finished trials are kept; None for nowhere
    # processes of this machine that share trials, if any do
    workers: Workers | None = field(default=None, compare=False, repr=False)
    _last: dict[tuple[float, ...], Answer] = field(default_factory=dict, compare=False, repr=False)

    def __getstate__(self) -> dict[str, Any]:
        """Give what other processes get: nothing that a solver works with."""
        return self.__dict__ | {"workers": None, "_last": {}}

    @classmethod
    def of(
        cls,
        scene: Scene,
        names: Sequence[str] | None = None,
        *,
        folder: Path | None = None,
        workers: Workers | None = None,
    ) -> Trials:
        """Prepare the trials of a scene."""
        design = Design.of(scene)
        return cls(design, read_all(design.study.names if names is None else names), folder, workers)

    def quantity(self, name: str) -> Quantity:
        """Give the number with a name, as the study states it."""
        return next(one for one in self.quantities if one.text == name)

    def with_fixed_effects(self) -> Trials:
        """Give the trials with the effects that the scene calls for at the start of the variables."""
        # Numbers would jump where other effects are chosen.
        design = self.design
        of_masses = self.quantities and all(quantity.name == "mass" for quantity in self.quantities)
        if design.scene.effects != "auto" or not design.scene.members() or of_masses:  # masses need no analysis
            return self
        result = analyse(self.cheapest.changed(design.changes(design.start)))
        decided = [json.loads(one.data.attrs["effects"]) for one in (result.cases or {"": result}).values()]
        acting = dict.fromkeys(effect["name"] for one in decided for effect in one if effect["acts"])
        return replace(self, design=replace(design, scene=design.scene.changed(effects=tuple(acting))))

    def run(
        self,
        points: Sequence[Sequence[float]],
        progress: Callable[[Trial], None] = lambda trial: None,
        counted: Callable[[], None] = lambda: None,
    ) -> list[Trial]:
        """Run trials, or read those that are finished."""
        tasks = [self._task(point) for point in points]
        shared = self._share([task for task in tasks if known(task) is None], counted)
        found = []
        for task in tasks:
            record = (read(task) if task.path in shared else known(task)) or run_task(task, self._analysed)
            numbers = {name: math.nan if value is None else value for name, value in record["numbers"].items()}
            found.append(Trial(task.values, numbers, record["error"], record["message"], record["seconds"]))
            progress(found[-1])
            if task.path not in shared:
                counted()
        return found

    def _share(self, missing: Sequence[Task], counted: Callable[[], None]) -> set[Path | None]:
        """Let other processes run trials, where there are any, and give the files of those that they ran."""
        if len(missing) <= 1 or self.folder is None:
            return set()

        def kept(task: Task, record: Record) -> None:
            write_record(task.path, record)
            counted()

        if leads():
            over_machines(missing, run_there, kept)
        elif self.workers is not None and self.workers.count > 1:
            self.workers.share([[task] for task in missing], run_here, give_up, lambda task: counted())
        else:
            return set()
        return {task.path for task in missing}

    @cached_property
    def why_differences(self) -> str:
        """Why derivatives are differences of trials; nothing where the equation about a trial's motion gives them."""
        scene = self.design.scene
        reasons = {
            f"the method is {scene.analysis.method!r}": scene.analysis.method == "transient",
            "a tolerance chooses the mesh of each trial": scene.tolerance is not None,
            "joints move freely": scene.freedoms,
            "the worst of several load cases counts": scene.cases,
            "a variable is a choice": any(variable.choices for variable in self.design.variables),
            "no link bends": not scene.members(),
            "the scene does not go by the equation of poses": not has_poses(scene),
        }
        return next((said for said, holds in reasons.items() if holds), "")

    def solution(self, values: Sequence[float]) -> Answer:
        """Give the solution of a trial without `why_differences`; that of the last trial is known."""
        point = tuple(float(value) for value in values)
        if point not in self._last:
            self._analysed(Scene.read(self.data_at(point)), point)
        return self._last[point]

    def _analysed(self, scene: Scene, point: tuple[float, ...]) -> Result:
        """Analyse the scene of a trial, and keep its solution where derivatives may be asked for."""
        if self.why_differences:
            return analyse(scene)
        self._last.clear()  # its memory is needed
        with guarded():
            self._last[point], result = answered(scene, self.variables)
        return result

    def _task(self, point: Sequence[float]) -> Task:
        values = tuple(float(value) for value in point)
        data = self._data | {"units": []}  # which change no number
        targets = {name: target.model_dump() for name, target in self.design.study.targets.items()}
        parts = __version__, data, self.design.changes(values), names_of(self.quantities), targets
        path = None if self.folder is None else record_file(self.folder, *parts)
        return Task(path, values, data, self.design.changes(values), self.quantities, self.design.study.targets)

    @property
    def variables(self) -> set[str]:
        """Variables of results that numbers are made from."""
        return {name for quantity in self.quantities for name in quantity.variables}

    def data_at(self, values: Sequence[float]) -> Record:
        """Give the scene of a trial as plain data."""
        return placed(self._data, self.design.changes(values))

    @cached_property
    def _data(self) -> Record:
        """The cheapest scene as plain data."""
        return stated_data(self.cheapest)

    @cached_property
    def cheapest(self) -> Scene:
        """The scene with the cheapest analysis that gives the numbers: no errors, and stability where it is asked."""
        scene = self.design.scene
        judged = any(quantity.needs_stability for quantity in self.quantities)
        changes: Record = {"analysis.stability": judged}
        changes |= {"analysis.allow_unstable": True} if judged else {}
        if scene.tolerance is None:
            changes["analysis.error_estimates"] = False
        return scene.changed(changes)
