"""A scene written as a scene file, which gives the same scene when it is read."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fenics_mech._files import write_whole
from fenics_mech.scene.base import Part
from fenics_mech.scene.models import Scene

BARE = re.compile(r"[A-Za-z0-9_-]+")
TAGS = ("kind", "shape")  # say which class a table is
RULE = ("custom", "revolute")  # tags that a file need not state


def write_scene(scene: Scene, path: str | Path, comment: str = "") -> Path:
    """Write a scene as a scene file. Keys that have their default are left out, and numbers are in SI.

    Parameters
    ----------
    scene
        The scene.
    path
        The file. Paths of measurements in it count from its folder.
    comment
        Lines at its head.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    ResultError
        When it cannot be written; nothing is left behind.

    Examples
    --------
    >>> fm.write_scene(fm.load("demos/four_bar.toml"), "copy.toml").name
    'copy.toml'
    """
    path = Path(path)
    moved = tuple(
        one.model_copy(update={"file": Path(os.path.relpath(one.file, path.parent))}) for one in scene.measurements
    )
    head = "".join(f"# {line}\n" for line in comment.splitlines())
    text = head + scene_text(scene.model_copy(update={"measurements": moved}))
    write_whole(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))
    return path


def scene_text(scene: Scene) -> str:
    """Give the text of a scene file."""
    return text_of(_stated(scene))


def text_of(data: Mapping[str, Any]) -> str:
    """Give the text of a scene file that states plain data."""
    above = [f"{key} = {literal(value)}" for key, value in data.items() if not isinstance(value, dict)]
    tables = [_table(key, value) for key, value in data.items() if isinstance(value, dict)]
    return "\n\n".join(["\n".join(above), *tables]) + "\n"


def _table(key: str, table: Mapping[str, Any]) -> str:
    """Write a table; one that holds tables only has a heading for each of them."""
    if table and all(isinstance(value, dict) for value in table.values()):
        return "\n\n".join(_headed(f"{key}.{_key(name)}", value) for name, value in table.items())
    return _headed(key, table)


def _headed(heading: str, table: Mapping[str, Any]) -> str:
    return "\n".join([f"[{heading}]", *(f"{_key(key)} = {literal(value)}" for key, value in table.items())])


def _stated(value: Any) -> Any:
    """Give a part as plain data, without the keys that have their default."""
    if isinstance(value, Part):
        found = {}
        for name, field in type(value).model_fields.items():
            content = getattr(value, name)
            tag = name in TAGS and content not in RULE
            if content is not None and (tag or content != field.get_default(call_default_factory=True)):
                found[field.alias or name] = _stated(content)
        return found
    if isinstance(value, Mapping):
        return {str(key): _stated(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_stated(one) for one in value]
    return str(value) if isinstance(value, Path) else value


def _key(key: str) -> str:
    return key if BARE.fullmatch(key) else json.dumps(key, ensure_ascii=False)


def literal(value: Any) -> str:
    """Write a value in TOML, in one line."""
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{_key(key)} = {literal(one)}' for key, one in value.items())} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(literal, value))}]"
    return json.dumps(value, ensure_ascii=False)  # texts, numbers, true and false are written alike in TOML
