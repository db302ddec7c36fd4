"""What a process needs for one trial of a study, and what it keeps of it: a file, which is not run again."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, TypeAdapter

from fenics_mech._files import write_whole
from fenics_mech._read_back import LARGEST_STRAIN, Ended, Text, read_kept
from fenics_mech.analysis import analyse
from fenics_mech.errors import MechanismError, SceneError
from fenics_mech.recovery import Result
from fenics_mech.scene import Scene
from fenics_mech.scene.study import Target
from fenics_mech.studies.design.result_curves import ResultNumbers
from fenics_mech.studies.design.result_numbers import total_mass
from fenics_mech.studies.sweep_axes import placed

LOST = "LostProcess"  # error of a trial whose process was ended from outside
Record = dict[str, Any]
Number = Annotated[float, Field(allow_inf_nan=False)]


class _Kept(Ended):
    """What is kept of a trial."""

    numbers: dict[Text, Number | None]
    values: tuple[Number, ...]


KEPT = TypeAdapter(_Kept)
Analysed = Callable[[Scene, tuple[float, ...]], Result]  # of a scene, and the values of its variables


@dataclass(frozen=True)
class Task:
    """What a process needs for one trial."""

    path: Path | None
    values: tuple[float, ...]
    scene: Record
    changes: Record
    quantities: tuple[ResultNumbers, ...]
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


def run_task(task: Task, analysed: Analysed) -> Record:
    """Run one trial and keep it."""
    start = time.perf_counter()
    record: Record = {"numbers": dict.fromkeys(names_of(task.quantities)), "error": "", "message": ""}
    record["again"] = False
    try:
        record["numbers"] = numbers_of(task, analysed)
    except SceneError as error:
        if error.place.startswith("study"):  # a name that no trial can give
            raise
        record |= {"error": type(error).__name__, "message": str(error)}
    except (OSError, MemoryError) as error:  # of the computer, not of the trial
        raise MechanismError(f"the computer could not go on: {type(error).__name__}: {error}") from error
    except Exception as error:  # what a trial may end with is not known, and must not end the study
        record |= {"error": type(error).__name__, "message": str(error), "again": not isinstance(error, MechanismError)}
    record |= {"values": task.values, "seconds": time.perf_counter() - start}
    write(task.path, record)
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


def wrong_numbers(quantities: Sequence[ResultNumbers], numbers: Mapping[str, float | None]) -> str:
    """Say which numbers are not those of the quantities, or not possible; an empty text where none are."""
    if numbers.keys() != {*names_of(quantities)}:
        return "these are other numbers"
    strains = [name for quantity in quantities if quantity.name == "strain" for name in quantity.names]
    large = [name for name in strains if abs(numbers[name] or 0.0) > LARGEST_STRAIN]
    return f"{large[0]} is {numbers[large[0]]:.6g}, which no member reaches" if large else ""


def read_numbers(
    quantities: Sequence[ResultNumbers], result: Result, targets: Mapping[str, Target]
) -> dict[str, float]:
    """Give the numbers of all quantities of a result, by name."""
    found: dict[str, float] = {}
    for quantity in quantities:
        found |= quantity.numbers(result, targets)
    return found


def names_of(quantities: Sequence[ResultNumbers]) -> list[str]:
    """Give the names of all numbers of quantities."""
    return [name for quantity in quantities for name in quantity.names]


def write(path: Path | None, record: Record) -> None:
    """Keep what a trial found, where it is to be kept."""
    if path is not None:
        text = json.dumps(record | {"message": str(MechanismError(record["message"]))})
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, lambda temporary: temporary.write_text(text))


def run_here(task: Task) -> None:
    """Run one of the trials of a worker process."""
    run_task(task, lambda scene, _: analyse(scene))


def run_there(task: Task) -> Record:
    """Run one of the trials of a process that another one leads, which keeps it."""
    return run_task(replace(task, path=None), lambda scene, _: analyse(scene))


def give_up(task: Task) -> None:
    """Write that the process of a trial was lost; the trial is run again by the next study."""
    said = "the process of this trial was ended from outside: there may be too little memory"
    numbers = dict.fromkeys(names_of(task.quantities))
    record = {"numbers": numbers, "error": LOST, "message": said, "seconds": 0.0, "again": True, "values": task.values}
    write(task.path, record)
