"""Scene files: TOML in, a frozen `Scene` out, errors with their place in the file."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from fenics_mech._files import read_bounded, reason_of
from fenics_mech.errors import SceneError, shortened
from fenics_mech.scene.base import SCENE
from fenics_mech.scene.in_space import SpatialScene, is_spatial
from fenics_mech.scene.models import Scene


@dataclass(frozen=True)
class FileLimits:
    """Limits of a scene file."""

    largest: int = 5_000_000  # bytes; a scene file is a few kB
    deepest: int = 30  # parts of a dotted key: the time that tomllib takes grows with their square


FILE = FileLimits()
Read = TypeVar("Read")
DEEP_KEY = re.compile(rf"(?<![\w\-\"'])(?:[\w\-\"']+[ \t]*\.[ \t]*){{{FILE.deepest}}}")

TOML_ADVICE = {  # by how tomllib's message starts
    "Invalid value": "Write texts, names and numbers with a unit in quotes",
    "Cannot overwrite a value": "The same key stands twice, or as a value and as a table",
    "Cannot declare": "The same table stands twice: write its keys under one heading",
    "Expected '=' after a key": "Write a key as name = value, and a heading as [table]",
}


def load(path: str | Path) -> Scene | SpatialScene:
    """Read a scene file, in the plane or in space.

    Parameters
    ----------
    path
        A TOML file. Paths in it are relative to its folder.

    Returns
    -------
    Scene or SpatialScene
        The scene, in space where its points have three coordinates; paths of measurements count from the working
        folder.

    Raises
    ------
    SceneError
        When the file cannot be read or does not describe a scene.

    Examples
    --------
    >>> fm.load("demos/four_bar.toml").name
    'seed four-bar'
    """
    found = load_in_space(path)
    return load_planar(path) if found is None else found


def load_in_space(path: str | Path) -> SpatialScene | None:
    """Read a scene file in space; None where it is of the plane. What it takes and raises is as of `load`.

    Parameters
    ----------
    path
        A TOML file.
    """
    path = Path(path)
    return _spatial(text_of(path), path.name)


def load_planar(path: str | Path) -> Scene:
    """Read a scene file in the plane; what it takes and raises is as of `load`.

    Parameters
    ----------
    path
        A TOML file.
    """
    path = Path(path)
    text = text_of(path)
    if _spatial(text, path.name) is not None:
        raise SceneError(
            "points have three coordinates, so that it is a scene in space, which this does not take",
            place=path.name,
            hint="Scenes in space have run, check, report, plot and animate",
        )
    scene = parse(text, file=path.name, folder=path.parent)
    measurements = tuple(m.model_copy(update={"file": path.parent / m.file}) for m in scene.measurements)
    return scene.model_copy(update={"measurements": measurements})


def _spatial(text: str, file: str) -> SpatialScene | None:
    """Make a scene in space from a text; None where it is of the plane, or no TOML."""
    try:
        if not is_spatial(tomllib.loads(text)):
            return None
    except (ValueError, RecursionError):
        return None
    name = {"name": Path(file).stem[: SCENE.longest_name]}
    return read_toml(text, file, lambda data: SpatialScene.read(name | data))


def text_of(path: Path, what: str = "scene file") -> str:
    """Read the text of a file that a user wrote.

    Parameters
    ----------
    path
        The file.
    what
        What it is, in words, for the error.

    Raises
    ------
    SceneError
        When it cannot be read, or is no text.
    """
    try:
        return read_bounded(path, FILE.largest).decode("utf-8-sig")
    except (OSError, ValueError) as error:
        reason = "it is not a UTF-8 text" if isinstance(error, UnicodeDecodeError) else reason_of(error)
        raise SceneError(f"cannot read the {what}: {reason}", place=str(path)) from error


def parse(text: str, *, file: str = "scene", folder: Path = Path()) -> Scene:
    """Make a scene from the text of a scene file.

    Parameters
    ----------
    text
        The text, in TOML.
    file
        Name of the file in errors; it names a scene that has no name.
    folder
        Where a drawing is looked for.

    Raises
    ------
    SceneError
        When the text is not TOML, or not a valid scene.
    """

    def read(data: dict[str, Any]) -> Scene:
        if "drawing" in data:
            from fenics_mech.scene.drawing import completed  # noqa: PLC0415  (most scenes have none)

            data = completed(data, folder)
        return Scene.read({"name": Path(file).stem[: SCENE.longest_name]} | data)

    return read_toml(text, file, read)


def read_toml(text: str, file: str, read: Callable[[dict[str, Any]], Read]) -> Read:
    """Make something from a text in TOML. Errors name the file and the line.

    Parameters
    ----------
    text
        The text.
    file
        Name of the file in errors.
    read
        Makes it from the tables of the text.

    Raises
    ------
    SceneError
        When the text is not TOML, or what `read` raises.
    """
    try:
        if deep := DEEP_KEY.search(text):
            raise ValueError(f"the key {shortened(deep[0])} has more than {FILE.deepest} parts")
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also of numbers with too many digits
        advice = next((advice for start, advice in TOML_ADVICE.items() if str(error).startswith(start)), "")
        raise SceneError(f"not valid TOML: {error}", place=file, hint=advice) from error
    try:
        return read(data)
    except SceneError as error:
        raise _with_line(error, text, file) from None


def located(error: SceneError, path: Path) -> SceneError:
    """Give an error about a place in a scene with the file and the line that state it.

    Parameters
    ----------
    error
        The error.
    path
        The file of the scene.
    """
    return _with_line(error, text_of(path), path.name)


def _with_line(error: SceneError, text: str, file: str) -> SceneError:
    line = _line_of(text, error.place.partition(":")[0].split("."))
    place = f"{file}: {error.place}" if error.place else file
    return SceneError(error.message, place=place, line=line, hint=error.hint)


def schema() -> dict[str, Any]:
    """Give the JSON Schema of scene files, with what each key means: editors complete and explain keys by it.

    Examples
    --------
    >>> fenics_mech.scene.schema()["properties"]["gravity"]["description"]
    'Acceleration along X and Y (m/s^2).'
    """
    from fenics_mech.scene.descriptions import described  # noqa: PLC0415  (only for those who ask)

    return described(bare_schema())


def bare_schema() -> dict[str, Any]:
    """Give the JSON Schema of scene files, in which a drawing may stand for the links, joints and ground."""
    full = Scene.model_json_schema()
    drawn = ["ground", "links", "joints"]
    table = {
        "type": "object",
        "properties": {key: {"type": "string"} for key in ("file", "unit", "section", "material")},
    }
    full["properties"]["drawing"] = {"anyOf": [{"type": "string"}, table | {"required": ["file"]}]}
    full["required"] = [key for key in full["required"] if key not in drawn]
    full["anyOf"] = [{"required": drawn}, {"required": ["drawing"]}]
    for part in ("Link", "Ground", "Member"):
        full["$defs"][part].pop("required", None)
    names = {key: {"type": "string"} for key in ("section", "material")}  # of all members of a drawn link
    full["$defs"]["Link"]["properties"] |= names | {"mesh": {"$ref": "#/$defs/Mesh"}}
    for part in (full, *full["$defs"].values()):
        part["description"] = part["description"].partition("\n\nExamples\n")[0]
        for tag in ("kind", "shape"):  # a file states them, but for those that are the rule
            if part["properties"].get(tag, {}).get("const", "custom") not in ("custom", "revolute"):
                part["required"] = [tag, *part.get("required", [])]
    return full


def _line_of(text: str, place: Sequence[str]) -> int | None:
    """Line of a TOML text, from 1 on, with the deepest known part of a dotted place; None where there is none."""
    best, depth_of_best, table = None, 0, []
    counted: dict[str, int] = {}  # entries of lists of tables
    for number, line in enumerate(text.splitlines(), 1):
        header = re.match(r"\s*\[\[?\s*([^\[\]]+?)\s*\]\]?\s*(#.*)?$", line)
        if header:
            table = [part.strip().strip("\"'") for part in header[1].split(".")]
            if line.lstrip().startswith("[["):
                counted[header[1]] = counted.get(header[1], -1) + 1
            if header[1].split(".")[0] in counted and place[1:2] and place[1].isdecimal():  # which entry is meant
                table.insert(1, str(counted[header[1].split(".")[0]]))
            path = table
        else:
            key = re.match(r"\s*([A-Za-z0-9_\-.\"']+)\s*=", line)
            if not key:
                continue
            path = table + [part.strip("\"'") for part in key[1].split(".")]
        depth = len(path) if list(place[: len(path)]) == path else 0
        if depth > depth_of_best:
            best, depth_of_best = number, depth
    return best
