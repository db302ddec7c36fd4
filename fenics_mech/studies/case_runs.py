"""Load cases of a scene shared by processes of this machine."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from fenics_mech.analysis import analyse
from fenics_mech.errors import SolverError
from fenics_mech.recovery import Result
from fenics_mech.safety.load_cases import of_cases
from fenics_mech.scene import Scene
from fenics_mech.scene.load_cases import about_case, scenes_of
from fenics_mech.studies.worker_processes import Workers


class CaseTask(NamedTuple):
    """A load case to be analysed."""

    name: str
    data: str  # its scene, as JSON
    path: Path  # the file for its result


def analyse_cases(scene: Scene, jobs: int, progress: Callable[[str], None] = lambda step: None) -> Result:
    """Analyse the load cases of a scene by several processes; with one process or one case as `analyse` does."""
    if jobs <= 1 or len(scene.cases) <= 1:
        return analyse(scene, progress)
    with TemporaryDirectory() as folder, Workers(jobs) as workers:
        tasks = [
            CaseTask(name, json.dumps(case.stated_data(mode="json", by_alias=True)), Path(folder) / f"{name}.nc")
            for name, case in scenes_of(scene).items()
        ]
        workers.share([[task] for task in tasks], analyse_case, _lost, lambda task: progress("response"))
        return of_cases(scene, {task.name: Result.load(task.path) for task in tasks})


def analyse_case(task: CaseTask) -> None:
    """Analyse one load case, and save its result."""
    with about_case(task.name):
        analyse(Scene.model_validate_json(task.data)).save(task.path)


def _lost(task: CaseTask) -> Any:
    raise SolverError(
        f"load case {task.name!r}: its process was ended from outside. Where memory is short, take fewer jobs"
    )
