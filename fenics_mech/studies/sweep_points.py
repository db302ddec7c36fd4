"""Points of a sweep: what is kept of one analysis, and the files that hold it."""

from __future__ import annotations

import json
import logging
import math
import re
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._files import read_bounded, write_whole
from fenics_mech.analysis import analyse
from fenics_mech.answers.modes_by_poses import HeldMachine, over_cycle
from fenics_mech.answers.solved_by_poses import Run
from fenics_mech.errors import SceneError, SolverError, UnstableError
from fenics_mech.estimate.remarks import NO_ESTIMATE
from fenics_mech.recovery import Result
from fenics_mech.recovery.peaks import angles_at, doubts, estimated_doubts, peak_of
from fenics_mech.recovery.result import at_place
from fenics_mech.recovery.signal import harmonics, last_cycle
from fenics_mech.safety.verdict import without_cure
from fenics_mech.scene import Scene
from fenics_mech.scene.joints import effort_units, joint_names
from fenics_mech.solve import Path as Steps
from fenics_mech.solve.last_motions import LastMotions
from fenics_mech.solve.stages import radau
from fenics_mech.studies.gauge import Gauge
from fenics_mech.studies.kept_points import CURVES_TEXT, KEPT, TEXTS, Variables, read_point, unlike
from fenics_mech.studies.kept_records import Record, ended, write_record
from fenics_mech.studies.point_curves import packed_curves

MOST = 1_000_000  # numbers of a motion that is kept: a larger one is found again as fast as it is written and read
# Numbers alone: archives and headers would have to be trusted.
LEADING = 3  # numbers before the motion of poses: coordinates, stages of a step, and unknowns
MOST_STAGES = 10


def write_motion(path: Path, motion: Steps) -> None:
    """Write a motion, if it is not large."""
    paced = motion.paced(1.0)
    sizes = np.array([motion.n, *motion.a.shape[1:]], dtype=float)
    parts = [sizes, motion.starts / motion.period, *(x.ravel() for x in (paced.q0, paced.v0, paced.a))]
    if sum(part.size for part in parts) <= MOST:
        numbers = np.concatenate(parts).astype(float)
        write_whole(path, lambda temporary: temporary.write_bytes(numbers.tobytes()))


def read_steps(path: Path) -> Steps | None:
    """Read a motion of poses in a period of 1 s; None where there is none."""
    try:
        numbers = np.frombuffer(read_bounded(path, 8 * MOST))
    except (OSError, ValueError):
        return None
    if len(numbers) < LEADING or not np.isfinite(numbers).all() or (numbers[:LEADING] < 0).any():
        return None
    n, stages, size = (int(number) for number in numbers[:LEADING])
    steps, rest = divmod(len(numbers) - LEADING, 1 + (2 + stages) * size)
    if rest or not (steps and 0 < n <= size and 0 < stages <= MOST_STAGES):
        return None
    shares, *states = np.split(numbers[LEADING:], np.cumsum([steps, steps * size, steps * size]))
    shapes = (steps, size), (steps, size), (steps, stages, size)
    q0, v0, a = (part.reshape(shape) for part, shape in zip(states, shapes))
    return Steps(radau(stages), shares, 1.0, n, q0, v0, a)


logger = logging.getLogger(__name__)
POSITIONS = 24  # of the cycle, at which they are found: the range of the demos' is that of 360 to 0.5 %


def running_ranges(scene: Scene) -> dict[str, Array]:
    """Give the lowest and highest frequency of each mode about the motion (Hz), ``(modes,)``."""
    # Modes have their numbers from the mechanism without axial forces, which is the same at all speeds. By their
    # shapes a mode about the motion is the one that it is most like there, so that modes do not change places in a
    # sweep.
    if scene.analysis.method != "periodic" or not scene.drives or not scene.members():
        return {}
    try:
        found = HeldMachine.of(over_cycle(scene, POSITIONS)).running()
    except (SceneError, SolverError) as error:
        logger.info("frequencies about the motion are not known: %s", error)
        return {}
    return {} if found is None else {"running_lowest": found.min(axis=0), "running_highest": found.max(axis=0)}


logger = logging.getLogger(__name__)

READ = (  # variables of a result, from which they are made
    *("strain", "largest_strain", "stress", "deflection", "joint_force", "input_torque", "frequency"),
    *("multiplier", "growth_rate", "euler_ratio", "bow", "rotation"),
)


class Task(NamedTuple):
    """A point to be computed."""

    path: Path  # the point's file
    data: Record  # its scene, as plain data
    gauge: Gauge  # where the strain is split into harmonics
    # its place in a run, whose motions begin from those before them; None where it begins from nothing
    place: float | None
    # file of its motion: without estimates the point makes it, and with them it begins there. None for no file.
    motion: Path | None
    curves: bool = False  # whether its curves over the cycle are kept


def compute_point(task: Task, before: Run) -> None:
    """Analyse a scene and write what is kept of it, or the error that it ended with."""
    write_record(task.path, dict.fromkeys(TEXTS, "") | ended(lambda: _analysed(task, before)))


def _analysed(task: Task, before: Run) -> Record:
    """Analyse a point and give what is kept of it."""
    _, data, gauge, place, motion, curves = task
    before.go_to(place)
    scene = Scene.read(data)
    estimated = scene.analysis.error_estimates
    if motion is not None and estimated and (known := read_steps(motion)) is not None:
        before.go_to(None)
        before.keep(known)
    quick = read_point(motion.with_suffix(".json"), scene) if motion is not None and estimated else None
    known_values = {} if quick is None else quick.get("values", {})  # of the point without estimates, beside its motion
    multipliers = {name: known_values[name] for name in ("multiplier", "growth_rate") if name in known_values}
    unstable = str(quick["unstable"]) if quick is not None and multipliers else ""
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


@cache
def _before_here() -> Run:
    return LastMotions()


def compute_here(task: Task) -> None:
    """Compute one of the points of a worker process, which begins from those before it."""
    compute_point(task, _before_here())


def reduced(result: Result, gauge: Gauge) -> Record:
    """Keep of a result what `KEPT` lists, as far as it is there."""
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
        "not_estimated": data.attrs.get("not_estimated", "") if "error_estimate" in data.attrs else NO_ESTIMATE,
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
    """Stack arrays (None: there is none) that may differ in size, with NaN where one has nothing."""
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
    """Add the numbers of the points of a grid, in its order, and the labels of their members, joints and modes."""
    for name, (dims, unit, meaning) in variables.items():
        numbers = stacked([record.get("values", {}).get(name) for record in records])
        if not np.isnan(numbers).all():  # nor are there none at all
            # the effort of a first drive that slides is a force
            own = effort_units(scene.moved_joints, scene.joints)[0] if name == "peak_input_torque" else unit
            attributes = {"units": own, "long_name": meaning}
            data[name] = ((*shape, *dims), numbers.reshape(*shape.values(), *numbers.shape[1:]), attributes)
    labels = {"member": list(scene.members()), "joint": joint_names(scene.joints)}
    for name in sorted({str(name) for name in data.dims} - set(shape)):
        data = data.assign_coords({name: labels.get(name, np.arange(data.sizes[name]) + (name != "harmonic"))})
    return data
