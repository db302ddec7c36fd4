"""One trial of a study: the scene at values of its variables, analysed, and the numbers that the study looks at.

A trial that fails has its error as a value, and NaN for its numbers. Finished trials are files, and not run again.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from fenics_mech._guard import guarded
from fenics_mech._version import __version__
from fenics_mech.analysis import analyse
from fenics_mech.answers.by_poses import answered
from fenics_mech.answers.solved_by_poses import AtRest as AnswersAtRest
from fenics_mech.answers.solved_by_poses import Solved
from fenics_mech.recovery import Result
from fenics_mech.scene import Scene
from fenics_mech.studies.design.derivative_kinds import why_differences
from fenics_mech.studies.design.design_variables import Design
from fenics_mech.studies.design.result_curves import ResultNumbers
from fenics_mech.studies.design.result_numbers import read_all
from fenics_mech.studies.design.trial_tasks import (
    Record,
    Task,
    give_up,
    known,
    names_of,
    read,
    run_here,
    run_task,
    run_there,
    write,
)
from fenics_mech.studies.lead_process import leads, over_machines
from fenics_mech.studies.sweep_axes import placed, stated_data
from fenics_mech.studies.worker_processes import Workers

Answer = Solved | AnswersAtRest  # by the equation of poses


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


@dataclass(frozen=True)
class Trials:
    """The trials of a design."""

    design: Design  # the scene and its variables
    quantities: tuple[ResultNumbers, ...]  # the numbers that are looked at
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

    def quantity(self, name: str) -> ResultNumbers:
        """Give the number with a name, as the study states it."""
        return next(one for one in self.quantities if one.text == name)

    def with_fixed_effects(self) -> Trials:
        """Give the trials with the effects that the scene calls for at the start of the variables."""
        # Numbers would jump where other effects are chosen.
        design = self.design
        if design.scene.effects != "auto" or not design.scene.members() or self._of_masses:
            return self
        result = analyse(self.cheapest.changed(design.changes(design.start)))
        decided = [json.loads(one.data.attrs["effects"]) for one in (result.cases or {"": result}).values()]
        acting = dict.fromkeys(effect["name"] for one in decided for effect in one if effect["acts"])
        return replace(self, design=replace(design, scene=design.scene.changed(effects=tuple(acting))))

    @property
    def _of_masses(self) -> bool:
        """Whether masses are all that is looked at, which need no analysis."""
        return bool(self.quantities) and all(quantity.name == "mass" for quantity in self.quantities)

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
            write(task.path, record)
            counted()

        if leads():
            over_machines(missing, run_there, kept)
        elif self.workers is not None and self.workers.count > 1:
            self.workers.share([[task] for task in missing], run_here, give_up, lambda task: counted())
        else:
            return set()
        return {task.path for task in missing}

    @cached_property
    def linearised(self) -> bool:
        """Whether the equation about a trial's motion gives derivatives; see `why_differences`."""
        return not why_differences(self.design, self.quantities)

    def solution(self, values: Sequence[float]) -> Answer:
        """Give the solution of a trial that `linearised` holds for; that of the last trial is known."""
        point = tuple(float(value) for value in values)
        if point not in self._last:
            self._analysed(Scene.read(self.data_at(point)), point)
        return self._last[point]

    def _analysed(self, scene: Scene, point: tuple[float, ...]) -> Result:
        """Analyse the scene of a trial, and keep its solution where derivatives may be asked for."""
        if not self.linearised:
            return analyse(scene)
        self._last.clear()  # its memory is needed
        with guarded():
            self._last[point], result = answered(scene, self.variables)
        return result

    def _task(self, point: Sequence[float]) -> Task:
        values = tuple(float(value) for value in point)
        data = self._data | {"units": []}  # which change no number
        text = json.dumps(
            [
                __version__,
                data,
                self.design.changes(values),
                names_of(self.quantities),
                {name: target.model_dump() for name, target in self.design.study.targets.items()},
            ],
            sort_keys=True,
        )
        name = f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.json"
        path = None if self.folder is None else self.folder / name
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
