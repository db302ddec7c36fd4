"""Fields of a scene that a sweep varies, and the scene's data with other values in them."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np

from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene
from fenics_mech.scene.base import Part
from fenics_mech.scene.units import COMMA, unit_written

MOST_POINTS = 1_000_000  # of a grid
FORM = "Write PATH=START:STOP:COUNT, such as drive.speed=10:60:200 or drive.speed='100 rpm:600 rpm:51'"
RANGE_FORM = "Write PATH=START:STOP, such as drive.speed=10:60 or drive.speed='100 rpm:600 rpm'"


@dataclass(frozen=True)
class Axis:
    """A number of the scene, and the values that it takes."""

    path: str  # its dotted path in the scene ("drive.speed")
    values: tuple[float, ...]  # SI, increasing
    unit: str  # SI unit, "1" where it has none
    written: tuple[str, float] = ("1", 1.0)  # the unit in which the range was written ("rpm"), and how much of SI it is

    def told(self, value: float) -> str:
        """Write a value of the field in the unit in which its range was written."""
        unit, factor = self.written
        return f"{value / factor:.5g}{'' if unit == '1' else ' ' + unit}"

    @property
    def whole(self) -> bool:
        """Whether the field is a whole number."""
        return isinstance(self.values[0], int)


def parse_axes(scene: Scene, texts: Sequence[str]) -> tuple[Axis, ...]:
    """Read `PATH=START:STOP:COUNT` for each swept field."""
    return _checked([_parse(scene, text) for text in texts])


def axes_of(scene: Scene, values: Mapping[str, Sequence[float | str]]) -> tuple[Axis, ...]:
    """Give the swept fields with their values in SI, increasing and each once."""
    axes = []
    for path, along in values.items():
        if isinstance(along, str):
            raise SceneError(
                f"found the text {along!r}, and not several values", place=path, hint="Write [...] about it"
            )
        found = [_in_si(scene, path, value) for value in along]
        if not found:
            raise SceneError("no value is given", place=path, hint="Give one or more")
        unit = unit_of(scene, path)
        written = unit_written([str(value) for value in along], found) or (unit, 1.0)
        axes.append(Axis(path, tuple(sorted(set(found))), unit, written))
    return _checked(axes)


def _checked(axes: Sequence[Axis]) -> tuple[Axis, ...]:
    """Raise `SceneError` where a grid has no field, one twice, or too many points."""
    paths = [axis.path for axis in axes]
    if not paths or len(set(paths)) < len(paths):
        raise SceneError("a sweep needs one number of the scene or more, each of them once", place=", ".join(paths))
    count = math.prod(len(axis.values) for axis in axes)
    if count > MOST_POINTS:
        raise SceneError(f"{count} points, and a sweep has at most {MOST_POINTS}", place=", ".join(paths))
    return tuple(axes)


def parse_range(scene: Scene, text: str) -> tuple[str, tuple[float, float]]:
    """Read `PATH=START:STOP`: a path, and both ends in SI, in the order in which they stand."""
    path, parts = _split(text, 2, RANGE_FORM)
    found = _ends(scene, path, (parts[0], parts[1]), f"{parts[0]}:{parts[1]}", RANGE_FORM)
    return path, _continuous(path, found)


def range_in_si(scene: Scene, path: str, ends: tuple[float | str, float | str]) -> tuple[float, float]:
    """Give both ends of a range in SI, in the order in which they stand."""
    if isinstance(ends, str) or len(ends) != 2:
        raise SceneError(f"a range has two ends, found {ends!r}", place=path, hint="Write (start, stop)")
    first, last = map(str, ends)
    return _continuous(path, _ends(scene, path, (first, last), f"[{first}, {last}]", "Write [smallest, largest]"))


def _continuous(path: str, ends: tuple[float, float]) -> tuple[float, float]:
    """Refuse whole numbers."""
    if isinstance(ends[0], int):
        raise SceneError("this is a whole number, and a number that changes continuously is needed", place=path)
    return ends


def scene_data(scene: Scene) -> dict[str, Any]:
    """Give a scene as plain data, without its measurements and its study: they change no result."""
    return json.loads(scene.model_copy(update={"measurements": (), "study": None}).model_dump_json())


def stated_data(scene: Scene) -> dict[str, Any]:
    """Give a scene as `scene_data` does, without the numbers of mesh and analysis that are the program's to choose."""
    return scene.model_copy(update={"measurements": (), "study": None}).stated_data(mode="json")


def value_in_si(scene: Scene, path: str, value: float | str | None = None) -> float:
    """Give a number of a scene in SI: the one that it states, or `value` as the scene would read it."""
    if value is None:
        for key, part in _walk(scene_data(scene), path):
            value = part[key]
        if value is None:
            raise SceneError("the scene states no number here", place=path, hint="State it, or give `start`")
    return float(_in_si(scene, path, value))


def placed(data: dict[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Give a scene's plain data with other values, by dotted path."""
    data = copy(data)
    for path, value in values.items():
        *parents, last = _keys(path)
        part: Any = data
        for key in parents:
            part[key] = copy(part[key])
            part = part[key]
        part[last] = value
    return data


def _parse(scene: Scene, text: str) -> Axis:
    path, (first, last, count) = _split(text, 3, FORM)
    if not count.isdecimal() or not 2 <= int(count) <= MOST_POINTS:
        expected = f"expected a whole number from 2 to {MOST_POINTS}"
        raise SceneError(f"cannot take {count!r} as number of values; {expected}", place=path, hint=FORM)
    ends = _ends(scene, path, (first, last), f"{first}:{last}", FORM)
    values = np.linspace(min(ends), max(ends), int(count)).tolist()
    if all(isinstance(end, int) for end in ends):
        if any(abs(value - round(value)) > 1e-9 for value in values):
            message = f"this is a whole number, and {count} equal steps from {first} to {last} are not"
            raise SceneError(message, place=path)
        values = [round(value) for value in values]
    unit = unit_of(scene, path)
    return Axis(path, tuple(values), unit, unit_written((first, last), ends) or (unit, 1.0))


def _split(text: str, count: int, form: str) -> tuple[str, list[str]]:
    """Split `PATH=A:B...` into the path and so many parts."""
    path, equals, rest = (part.strip() for part in text.partition("="))
    parts = [part.strip() for part in rest.split(":")]
    if not equals or not path or len(parts) != count:
        raise SceneError(f"cannot read {text!r}", place=path, hint=form)
    return path, parts


def _ends(scene: Scene, path: str, both: tuple[str, str], written: str, form: str) -> tuple[float, float]:
    """Give the ends of a range in SI, whole numbers as such; `written` is how they stand, `form` how they should."""
    first, last = both
    if COMMA.search(written):
        raise SceneError(f"{written!r} has a comma", place=path, hint="Write a decimal point")
    if (_number(first) is None) != (_number(last) is None):
        raise SceneError(
            f"one end of {written!r} has a unit and the other has none", place=path, hint="Write both alike"
        )
    ends = _in_si(scene, path, first), _in_si(scene, path, last)
    if ends[0] == ends[1]:
        raise SceneError(f"the range {written!r} begins where it ends", place=path, hint=form)
    return ends


def _in_si(scene: Scene, path: str, value: float | str) -> float | int:
    """Give the value that a scene has once `value`, SI or with a unit, is written at `path`."""
    data, number = scene_data(scene), _number(str(value))
    for key, part in _walk(data, path):
        keys = list(part) if isinstance(part, dict) else range(len(part)) if isinstance(part, list) else ()
        if key not in keys:
            known = ", ".join(map(str, keys))
            hint = f"There are {known}" if known else "There is nothing below the key before it"
            raise SceneError(f"there is no {key!r} in this scene", place=path, hint=hint)
    changed = scene_data(Scene.read(placed(data, {path: value if number is None else number})))
    for key, part in _walk(changed, path):
        found = part[key]
    if isinstance(found, bool) or not isinstance(found, int | float):
        raise SceneError("only a number can vary, and this is not a number", place=path)
    return found


def unit_of(scene: Scene, path: str) -> str:
    """Give the SI unit of a number of a scene, as the schema of its part tells it; "1" where it has none."""
    part: Any = scene
    holder: type[Part] = Scene
    field = ""
    for key in _keys(path):
        if isinstance(part, Part):
            holder, field, part = type(part), str(key), getattr(part, str(key))
        else:
            part = part[key]
    found = [text for text in _descriptions(holder.model_json_schema()["properties"][field]) if ", or a string" in text]
    return found[0].partition(", or a string")[0].replace("**", "^") if found else "1"


def _descriptions(schema: Any) -> Iterator[str]:
    """Give the descriptions in a schema, outermost first."""
    if isinstance(schema, dict):
        if isinstance(schema.get("description"), str):
            yield schema["description"]
        schema = list(schema.values())
    if isinstance(schema, list):
        for part in schema:
            yield from _descriptions(part)


def _walk(data: Any, path: str) -> Iterator[tuple[str | int, Any]]:
    """Give each key of a path with the part of the data that it is to be found in."""
    for key in _keys(path):
        yield key, data
        data = data[key]


def _keys(path: str) -> list[str | int]:
    return [int(key) if key.isdecimal() else key for key in path.split(".")]


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
