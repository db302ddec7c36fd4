"""Points of a sweep: what is kept of one analysis, and the files that hold it."""

from __future__ import annotations

import json
import logging
import math
import re
import time
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.analysis import analyse
from fenics_mech.answers.solved_by_poses import Run
from fenics_mech.errors import MechanismError, SolverError, UnstableError
from fenics_mech.estimate.remarks import NO_ESTIMATE
from fenics_mech.recovery import Result
from fenics_mech.recovery.peaks import angles_at, doubts, estimated_doubts, peak_of
from fenics_mech.recovery.result import at_place
from fenics_mech.recovery.signal import harmonics, last_cycle
from fenics_mech.safety.verdict import without_cure
from fenics_mech.scene import Scene
from fenics_mech.scene.joints import effort_units, joint_names
from fenics_mech.solve.last_motions import LastMotions
from fenics_mech.studies.gauge import Gauge
from fenics_mech.studies.kept_motions import read_steps, write_motion
from fenics_mech.studies.kept_points import CURVES_TEXT, KEPT, TEXTS, Record, Variables, read_point, unlike, write_point
from fenics_mech.studies.point_curves import packed_curves
from fenics_mech.studies.running_ranges import running_ranges

logger = logging.getLogger(__name__)

READ = (  # variables of a result, from which they are made
    *("strain", "largest_strain", "stress", "deflection", "joint_force", "input_torque", "frequency"),
    *("multiplier", "growth_rate", "euler_ratio", "bow", "rotation"),
)


def _kept_unit(name: str, scene: Scene) -> str:
    """Give the unit of a variable of `KEPT`; that of a drive's effort depends on whether the first drive slides."""
    return effort_units(scene.moved_joints, scene.joints)[0] if name == "peak_input_torque" else KEPT[name][1]


class Task(NamedTuple):
    """A point to be computed.

    Parameters
    ----------
    path
        The point's file.
    data
        Its scene, as plain data.
    gauge
        Where the strain is split into harmonics.
    place
        Its place in a run, whose motions begin from those before them; None where it begins from nothing.
    motion
        File of its motion: without estimates the point makes it, and with them it begins there. None for no file.
    curves
        Whether its curves over the cycle are kept.
    """

    path: Path
    data: Record
    gauge: Gauge
    place: float | None
    motion: Path | None
    curves: bool = False


def compute_point(task: Task, before: Run) -> None:
    """Analyse a scene and write what is kept of it, or the error that it ended with.

    An error that the program does not know is written too, but the point is tried again by the next sweep.

    Parameters
    ----------
    task
        The point.
    before
        Motions of the points before it, from which its own is sought.

    Raises
    ------
    ResultError
        When the file cannot be written.
    MechanismError
        When the computer has too little of something, such as memory.
    """
    start = time.perf_counter()
    record: Record = dict.fromkeys(TEXTS, "") | {"again": False}
    try:
        record |= _analysed(task, before)
    except (OSError, MemoryError) as error:  # of the computer, not of the point
        raise MechanismError(f"the computer could not go on: {type(error).__name__}: {error}") from error
    except Exception as error:  # what a single point may end with is not known, and must not end the sweep
        logger.info("the point %s failed: %s", task.path.stem, error)
        record |= {"error": type(error).__name__, "message": str(error), "again": not isinstance(error, MechanismError)}
    seconds = record.get("seconds", 0.0) + time.perf_counter() - start
    write_point(task.path, record | {"seconds": seconds})


def _analysed(task: Task, before: Run) -> Record:
    """Analyse a point and give what is kept of it."""
    _, data, gauge, place, motion, curves = task
    before.go_to(place)
    scene = Scene.read(data)
    estimated = scene.analysis.error_estimates
    if motion is not None and estimated and (known := read_steps(motion)) is not None:
        before.go_to(None)
        before.keep(known)
    multipliers = _examined(motion, scene) if estimated else {}
    unstable = _unstable_before(motion, scene) if multipliers else ""
    try:
        result = analyse(scene.changed(analysis__stability=False) if multipliers else scene, run=before, names=READ)
    except UnstableError as error:  # a motion that a machine leaves: its numbers show where a branch goes on
        unstable = re.split(r"\. (?:Change|Take|The)\b", str(error))[0]  # without what to do about it
        result = analyse(scene.changed(analysis__allow_unstable=True), run=before, names=READ)
    if motion is not None and not estimated and before.found is not None:
        write_motion(motion, before.found)
    record = reduced(result, gauge) | {"unstable": unstable}
    record |= {CURVES_TEXT: packed_curves(result)} if curves else {}
    record["values"] |= multipliers | {name: value.tolist() for name, value in running_ranges(result.scene).items()}
    if wrong := unlike(record["values"], scene):
        raise SolverError(f"this point has no answer that can be kept: {wrong}")
    return record


def _unstable_before(motion: Path | None, scene: Scene) -> str:
    """What was said of the stability of a point that was analysed without estimates."""
    record = None if motion is None else read_point(motion.with_suffix(".json"), scene)
    return "" if record is None else str(record["unstable"])


def _examined(motion: Path | None, scene: Scene) -> Record:
    """Multipliers that a point has found without estimates, beside which its motion is; nothing where it has none."""
    record = None if motion is None else read_point(motion.with_suffix(".json"), scene)
    values = {} if record is None else record.get("values", {})
    return {name: values[name] for name in ("multiplier", "growth_rate") if name in values}


@cache
def _before_here() -> Run:
    return LastMotions()


def compute_here(task: Task) -> None:
    """Compute one of the points of a worker process, which begins from those before it.

    Parameters
    ----------
    task
        The point.
    """
    compute_point(task, _before_here())


def reduced(result: Result, gauge: Gauge) -> Record:
    """Keep of a result what `KEPT` lists, as far as it is there.

    Parameters
    ----------
    result
        The result of a point.
    gauge
        Where the strain is split into harmonics.
    """
    data, variables = result.data, result.data.variables  # without labels, which take longer
    acting = [effect["name"] for effect in json.loads(data.attrs.get("effects", "[]")) if effect["acts"]]
    values = _strains(result, gauge)
    values["peak_doubt"] = np.array(max(doubts(result).values()))
    for name in ("stress", "deflection", "joint_force"):
        values[f"peak_{name}"] = np.abs(peak_of(result, name)[2])
    if "input_torque" in data:
        values["peak_input_torque"] = np.abs(peak_of(result, "input_torque")[2]).max()
        values["drive_rate"] = np.array(result.scene.cycle_rate)
    if "frequency" in data:
        frequency = variables["frequency"].transpose("theta", "mode").to_numpy()
        values["frequency_lowest"], values["frequency_highest"] = frequency.min(axis=0), frequency.max(axis=0)
        values["frequency_start"] = frequency[0]
    if "multiplier" in data:
        values["multiplier"] = np.linalg.norm(variables["multiplier"].transpose(..., "part").to_numpy(), axis=-1)
        values["growth_rate"] = variables["growth_rate"].to_numpy()
    values |= {name: variables[name].to_numpy() for name in ("euler_ratio", "bow", "rotation")}
    values |= _of_errors(data)
    verdict = without_cure(result)
    least = {member: check.share for member in verdict.checks if (check := verdict.least(member)) is not None}
    values["safety"] = np.array([least.get(str(member), math.nan) for member in variables["member"].to_numpy()])
    member, mode = "", ""
    if verdict.governing is not None:
        member, mode = verdict.governing[0], verdict.governing[1].mode
        values["safety_min"] = np.array(verdict.governing[1].share)
    return {
        "safety_member": member,
        "safety_mode": mode,
        "effects": ", ".join(acting),
        "not_estimated": _not_estimated(data),
        "warnings": "\n".join(text for text in result.warnings if not text.startswith("too coarse: ")),
        "too_coarse": data.attrs.get("coarse_because", ""),
        "numbers": data.attrs.get("refined", ""),
        "values": {name: np.asarray(value).tolist() for name, value in values.items()},
    }


def _of_errors(data: xr.Dataset) -> dict[str, Array]:
    """Give what a dataset tells of errors."""
    values = {name: np.array(data.attrs[name]) for name in KEPT if name in data.attrs}
    if told := estimated_doubts(data):
        values["peak_doubt"] = np.array(max(told.values()))
    if "source" in data and "theory" in data["source"]:
        for prefix in ("", "deflection_"):
            left_out = float(data[f"{prefix}relative_error"].sel(source="theory"))
            values[f"{prefix}theory_share"] = np.array(np.nan_to_num(left_out, nan=np.inf))
    return values


def _not_estimated(data: xr.Dataset) -> str:
    return data.attrs.get("not_estimated", "") if "error_estimate" in data.attrs else NO_ESTIMATE


def _strains(result: Result, gauge: Gauge) -> dict[str, Array]:
    """Give the peak of every member's strain, where it is, and the harmonics of the strain at the gauge."""
    variables = result.data.variables
    strain, stations, sides = variables["strain"], *(variables[name].to_numpy() for name in ("s", "fibre"))
    highest, places, values = peak_of(result, "strain")
    s, fibre = np.unravel_index(highest, (len(stations), len(sides)))
    found = {
        "peak_strain": np.maximum(variables["largest_strain"].to_numpy(), np.abs(values)),
        "peak_strain_theta": angles_at(result, places),
        "peak_strain_s": stations[s],
        "peak_strain_side": np.where(sides[fibre] == "+", 1.0, -1.0),
    }
    if (cycle := last_cycle(result.scene.analysis, result.scene.drives, result.data)) is not None:
        wave = strain.isel(theta=cycle, fibre=int(np.argmax(sides == gauge.fibre))).transpose("theta", "member", "s")
        along = harmonics(at_place(wave.to_numpy(), stations, gauge.s))
        found["strain_harmonic"] = np.abs(along).T[:, : 1 + gauge.harmonics]
    return found


def stacked(numbers: Sequence[Any]) -> Array:
    """Stack arrays (None: there is none) that may differ in size, with NaN where one has nothing.

    Parameters
    ----------
    numbers
        The arrays, or numbers, of each point.

    Returns
    -------
    numpy.ndarray
        ``(points, ...)``, the rest as large as the largest of each axis.
    """
    arrays = [np.array(math.nan) if found is None else np.asarray(found, dtype=float) for found in numbers]
    rank = max(array.ndim for array in arrays)
    arrays = [array.reshape((1,) * (rank - array.ndim) + array.shape) for array in arrays]
    full = np.full((len(arrays), *np.max([array.shape for array in arrays], axis=0).astype(int)), math.nan)
    for point, array in enumerate(arrays):
        place: tuple[int | slice, ...] = (point, *(slice(length) for length in array.shape))
        full[place] = array
    return full


def tabulated(
    data: xr.Dataset, records: Sequence[Record], variables: Variables, scene: Scene, shape: Mapping[str, int]
) -> xr.Dataset:
    """Add the numbers of the points of a grid, in its order, and the labels of their members, joints and modes.

    Parameters
    ----------
    data
        The dataset with the coordinates of the grid.
    records
        What is kept of each point, in the order of the grid.
    variables
        Dimensions, unit and meaning of each variable to add.
    scene
        The scene of one point, for labels and the unit of the drive's effort.
    shape
        Number of values along each dimension of the grid.
    """
    for name, (dims, unit, meaning) in variables.items():
        numbers = stacked([record.get("values", {}).get(name) for record in records])
        if not np.isnan(numbers).all():  # nor are there none at all
            attributes = {"units": _kept_unit(name, scene) if name in KEPT else unit, "long_name": meaning}
            data[name] = ((*shape, *dims), numbers.reshape(*shape.values(), *numbers.shape[1:]), attributes)
    labels = {"member": list(scene.members()), "joint": joint_names(scene.joints)}
    for name in sorted({str(name) for name in data.dims} - set(shape)):
        data = data.assign_coords({name: labels.get(name, np.arange(data.sizes[name]) + (name != "harmonic"))})
    return data
