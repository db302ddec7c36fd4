"""From plain data to a `Scene`, with pydantic's errors turned into one message."""

from __future__ import annotations

from typing import Any

from pydantic import ValidationError

from fenics_mech.errors import SceneError
from fenics_mech.scene.models import Scene

BRANCHES = (
    "[key]",
    "custom",
    "rectangle",
    "round",
    "tube",
    "I",
    "laminate",
    "polygon",
    "variable",
    "taper",
    "one",
    "many",
    "revolute",
    "weld",
    "slot",
    "prismatic",
    "harmonics",
    "table",
    "expression",
    "pulse",
    "load",
    "line-load",
    "line",
    "hinge",
)  # of pydantic unions


def build(data: dict[str, Any]) -> Scene:
    """Make a scene from nested dictionaries as a scene file holds them.

    Raises
    ------
    SceneError
        About the first thing that is wrong, with its place.
    """
    try:
        return Scene.model_validate(data)
    except ValidationError as error:
        raise _first_error(error, data) from None


def changed(scene: Scene, **values: Any) -> Scene:
    """Give a copy of a scene with other values, by path with "__" for the dots: ``analysis__modes="all"``.

    Raises
    ------
    SceneError
        When a path does not exist or the new scene is not valid.
    """
    data = scene.model_dump()
    for path, value in values.items():
        *parents, last = (int(key) if key.isdigit() else key for key in path.split("__"))
        part: Any = data
        try:
            for parent in parents:
                if isinstance(part, dict):
                    part.setdefault(parent, {})
                part[parent] = list(part[parent]) if isinstance(part[parent], tuple) else part[parent]
                part = part[parent]
            part[last] = value
        except (KeyError, IndexError, TypeError) as error:
            raise SceneError("there is no such part of the scene", place=path.replace("__", ".")) from error
    return build(data)


def _first_error(error: ValidationError, data: dict[str, Any]) -> SceneError:
    """Turn pydantic's list of errors into one message about the first."""
    first = error.errors()[0]
    place = _place(first["loc"], data)
    message, hint = _sentence(first), ""
    if first["type"] == "extra_forbidden":
        message, hint = (
            f"unknown key {place[-1]!r}",
            "Remove it or correct its name; `fenics-mech schema` lists all keys",
        )
    elif first["type"] == "missing":
        message = "this key is missing"
    places = {tuple(_place(other["loc"], data)) for other in error.errors()}
    if len(places) > 1:
        hint = f"{hint}. {len(places) - 1} more found after it".removeprefix(". ")
    return SceneError(message, place=".".join(place), hint=hint)


def _sentence(error: Any) -> str:
    """Say what pydantic found in words of ours."""
    message = error["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    if error["type"].startswith("value_error"):
        return message
    if error["type"] == "string_pattern_mismatch":
        solver = "periodic" in error["ctx"]["pattern"]
        message = (
            "an option starts with its solver: periodic_, modes_ or static_"
            if solver
            else "must be a name of letters, digits, _ and -, or link.point where a point is meant"
        )
        if "@" in error["ctx"]["pattern"]:
            message = "must be link.point, a joint, or member@place with a place 0 to 1 along the member"
    if error["type"] in ("int_parsing", "int_type") and "modes" in error["loc"]:
        message = "must be a whole number or 'all'"
    return f"{message}, found {error['input']!r}"


def _place(location: tuple[int | str, ...], data: Any) -> list[str]:
    """Keep of pydantic's location what stands in the data, and the last key where it is missing there."""
    place: list[str] = []
    for part in location:
        known = part in data if isinstance(data, dict) else isinstance(data, list | tuple) and part in range(len(data))
        if known:
            data = data[part]  # type: ignore[index]
        elif not isinstance(data, dict) or part in BRANCHES:
            continue  # a branch of a union, or a mark that the key itself is bad
        place.append(str(part))
    return place
