"""The text of a scene file with other values, which keeps the units in which it is written.

Comments stay where the file states all these values; one that it does not state is added, and they are lost.
"""

from __future__ import annotations

import json
import os
import re
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from copy import deepcopy
from pathlib import Path
from typing import Any

from fenics_mech._files import write_whole
from fenics_mech.errors import SceneError
from fenics_mech.scene.base import place_in
from fenics_mech.scene.files import parse
from fenics_mech.scene.files import text_of as text_in
from fenics_mech.scene.models import Scene
from fenics_mech.scene.units import unit_written
from fenics_mech.scene.writing import literal, text_of, write_scene

VALUE = re.compile(r""""(?:[^"\\\n]|\\.)*"|'[^'\n]*'|[-+]?\d[\w.+-]*""")  # a text or a number in a TOML file
DIGITS = 10  # of numbers that are written


def write_like(file: str | Path, values: Mapping[str, Any], scene: Scene, path: str | Path) -> Path:
    """Write a scene as the text of the file that it comes from, with other values in it."""
    path, text = Path(path), text_in(Path(file))
    with suppress(SceneError, tomllib.TOMLDecodeError):  # of a path that the text does not have, or of a changed text
        data = tomllib.loads(text)
        if "drawing" not in data and _alike(parse(text).changed(dict(values)), scene):
            moved = {
                f"measurements.{k}.file": os.path.relpath(one.file, path.parent)
                for k, one in enumerate(scene.measurements)
            }
            text = text if "name" in data else f"name = {literal(scene.name)}\n{text}"
            text = rewritten(text, {**values, **moved})
            parse(text)
            write_whole(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))
            return path
    return write_scene(scene, path)


def _alike(one: Scene, other: Scene) -> bool:
    """Whether scenes are the same but for what does not come from values: names, units of answers, files, effects."""
    apart = {"name", "units", "measurements", "effects"}
    return one.model_dump_json(exclude=apart) == other.model_dump_json(exclude=apart)


def rewritten(text: str, values: Mapping[str, Any]) -> str:
    """Give the text of a scene file with other values, each in the unit in which the text states it."""
    before = json.loads(parse(text).model_dump_json())
    for path, value in values.items():
        data = tomllib.loads(text)
        old = _stated(data, path)
        new = in_unit_of(str(old), _stated(before, path), value) if isinstance(value, float) else value
        wanted = deepcopy(data)
        place_in(wanted, path, new)
        text = text if data == wanted else _exchanged(text, old, new, wanted) or text_of(wanted)
    return text


def in_unit_of(written: str, old: float, value: float) -> float | str:
    """Write a number in the unit of another; as a number in SI where that has none."""
    if (known := unit_written([written], [old])) is None:
        return float(f"{value:.{DIGITS}g}")
    unit, size = known
    return f"{value / size:.{DIGITS}g} {unit}"


def _stated(data: Any, path: str) -> Any:
    """Give what plain data state at a dotted path; None where they do not state it."""
    for key in path.split("."):
        try:
            data = data[int(key) if isinstance(data, list) else key]
        except (KeyError, IndexError, TypeError, ValueError):
            return None
    return data


def _exchanged(text: str, old: Any, new: Any, wanted: Mapping[str, Any]) -> str | None:
    """Exchange the one value in a text that makes it state what is wanted; None where there is none."""
    for match in VALUE.finditer(text):
        with suppress(ValueError):
            if tomllib.loads(f"v = {match[0]}")["v"] == old:
                found = f"{text[: match.start()]}{literal(new)}{text[match.end() :]}"
                if tomllib.loads(found) == wanted:
                    return found
    return None
