"""The response of a machine in space over numbers of its scene."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any

import numpy as np
import xarray as xr

from fenics_mech._version import __version__
from fenics_mech.analysis import analyse
from fenics_mech.errors import MechanismError, SceneError
from fenics_mech.scene.in_space import SpatialScene

FORM = "Write PATH=START:STOP:COUNT, such as drive.speed='100 rpm:600 rpm:51'"
MOST_POINTS = 100_000
LARGEST = {  # by variable of a result what is kept of it: the dimension that stays, unit and meaning
    "von_mises": ("member", "Pa", "largest equivalent stress of the member"),
    "deflection": ("member", "m", "largest deflection of the member along an axis"),
    "joint_force": ("joint", "N", "largest force of the joint along an axis"),
    "input_torque": ("drive", "N m", "largest effort of the drive; N along a stroke"),
    "multiplier": ("", "1", "largest Floquet multiplier"),
}


def sweep_in_space(
    scene: SpatialScene,
    values: Mapping[str, Sequence[float | str]],
    *,
    jobs: int = 1,
    progress: Callable[[int, int], None] = lambda done, points: None,
) -> xr.Dataset:
    """Analyse a scene in space at given values of its numbers; several numbers make a grid.

    A point that fails ends nothing: its text `error` says why, and its numbers are NaN. Points with an unstable motion
    are kept, with their multiplier.

    Parameters
    ----------
    scene
        The scene.
    values
        Values by dotted path: numbers (SI), or texts with a unit.
    jobs
        Processes of this machine that share the points. The answer does not depend on it.
    progress
        Called after each point with their number so far, and the number of all.

    Returns
    -------
    xarray.Dataset
        One dimension per number, named by its path, in SI; then members, joints, drives. The largest sizes over the
        cycle, and the lowest and highest of every natural frequency (Hz).

    Raises
    ------
    SceneError
        When a path is not that of a number of the scene, or a value is not valid there.

    Examples
    --------
    >>> scene = fm.load("demos/space/drive_line.toml").changed({"analysis.positions": 12, "mesh.elements": 1})
    >>> found = fm.sweep_in_space(scene, {"drive.speed": ["300 rpm", "600 rpm"]})
    >>> found["von_mises"].dims
    ('drive.speed', 'member')
    """
    paths = list(values)
    axes = [[number_at(scene.changed({path: value}), path) for value in values[path]] for path in paths]
    count = int(np.prod([len(axis) for axis in axes]))
    if not paths or not 1 <= count <= MOST_POINTS:
        raise SceneError(
            f"a sweep has 1 to {MOST_POINTS} points, found {count if paths else 0}", place=", ".join(paths)
        )
    points = [dict(zip(paths, point)) for point in itertools.product(*axes)]
    texts = [scene.changed({**point, "analysis.allow_unstable": True}).model_dump_json() for point in points]
    found = []
    for done, one in enumerate(_answers(texts, min(jobs, len(texts))), start=1):
        found.append(one)
        progress(done, len(points))
    data = _joined(scene, found, [len(axis) for axis in axes], paths)
    labels = {path: axis for path, axis in zip(paths, axes)}
    names = {"member": list(scene.members()), "joint": list(scene.joints)}
    names["drive"] = [drive.joint for drive in scene.drives]
    attributes = {"fenics_mech": __version__, "scene": scene.model_dump_json(), "paths": json.dumps(paths)}
    return xr.Dataset(data, labels | {name: own for name, own in names.items() if own}, attributes)


def parsed_axis(scene: SpatialScene, text: str) -> tuple[str, list[float]]:
    """Read PATH=START:STOP:COUNT: a path, and even values in SI.

    Parameters
    ----------
    scene
        The scene.
    text
        The text, with ends in SI or with a unit.

    Raises
    ------
    SceneError
        When it cannot be read, or an end is not valid there.
    """
    path, equals, rest = (part.strip() for part in text.partition("="))
    parts = [part.strip() for part in rest.split(":")]
    if not equals or len(parts) != 3 or not parts[2].isdecimal() or not 2 <= int(parts[2]) <= MOST_POINTS:
        raise SceneError(f"cannot read {text!r}", place=path, hint=FORM)
    ends = [number_at(scene.changed({path: _plain(end)}), path) for end in parts[:2]]
    return path, np.linspace(ends[0], ends[1], int(parts[2])).tolist()


def _plain(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def number_at(scene: SpatialScene, path: str) -> float:
    """Give a number of a scene (SI).

    Parameters
    ----------
    scene
        The scene.
    path
        Its dotted path.

    Raises
    ------
    SceneError
        When there is no number.
    """
    part: Any = scene.model_dump(by_alias=True)
    for key in path.split("."):
        part = part[int(key)] if isinstance(part, list | tuple) else part[key]
    if isinstance(part, bool) or not isinstance(part, int | float):
        raise SceneError("only a number can vary, and this is none", place=path)
    return part


def _answers(texts: Sequence[str], jobs: int) -> Any:
    """Answer all scenes, here or in several processes, in their order."""
    if jobs <= 1:
        yield from map(_point, texts)
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("forkserver")) as pool:
        yield from pool.map(_point, texts)


def _point(text: str) -> dict[str, Any]:
    """Give what is kept of an analysis."""
    try:
        data = analyse(SpatialScene.model_validate_json(text)).data
    except MechanismError as error:
        return {"error": str(error)}
    kept: dict[str, Any] = {"error": ""}
    for name, (dimension, *_) in LARGEST.items():
        if name in data:
            over = tuple(k for k, dim in enumerate(data[name].dims) if dim != dimension)
            kept[name] = np.abs(data[name].to_numpy()).max(axis=over)
    if "frequency" in data:
        kept["lowest_frequency"] = data["frequency"].min("theta").to_numpy()
        kept["highest_frequency"] = data["frequency"].max("theta").to_numpy()
    kept["error_estimate"] = max((data.attrs[k] for k in data.attrs if k.endswith("error_estimate")), default=np.nan)
    return kept


def _joined(scene: SpatialScene, found: list[dict[str, Any]], shape: list[int], paths: list[str]) -> dict[str, Any]:
    """Put the points together, with NaN where one has failed."""
    meant = LARGEST | {
        "lowest_frequency": ("mode", "Hz", "lowest natural frequency of each mode over the cycle"),
        "highest_frequency": ("mode", "Hz", "highest natural frequency of each mode over the cycle"),
        "error_estimate": ("", "1", "largest estimated error of any quantity"),
    }
    data: dict[str, Any] = {"error": (paths, np.array([one["error"] for one in found]).reshape(shape))}
    for name, (dimension, unit, meaning) in meant.items():
        sizes = [np.shape(one[name]) for one in found if name in one]
        if not sizes:
            continue
        size = max(sizes)
        values = np.full((len(found), *size), np.nan)
        for k, one in enumerate(found):
            if name in one:
                values[(k, *(slice(n) for n in np.shape(one[name])))] = one[name]
        dims = [*paths, dimension] if dimension else paths
        data[name] = (dims, values.reshape(*shape, *size), {"units": unit, "long_name": meaning})
    return data
