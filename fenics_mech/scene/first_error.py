"""What is wrong with a scene, or a part of it: pydantic's list of errors turned into one message."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterator, Sequence
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from fenics_mech.errors import SceneError, shortened
from fenics_mech.scene.updating import GONE

MARKS = (
    "[key]",
    "one",
    "many",
    "load",
    "line-load",
    "line",
    "hinge",
)  # of pydantic unions, which stand in its places alone
BRANCH = "shape:"  # begins the name of a branch that is a shape of section
ABOVE = "name", "units", "effects", "tolerance", "gravity"  # keys of a scene itself

SENTENCES = {  # by pydantic's type of error, where its own words speak of Python
    "union_tag_invalid": "there is no kind {tag!r} here; known are {expected_tags}",
    "union_tag_not_found": "must be a table with a `kind`",
    "tuple_type": "must be a list in square brackets",
    "dict_type": "must be a table",
    "model_type": "must be a table",
    "model_attributes_type": "must be a table",
    "string_type": "must be a string",
    "bool_type": "must be true or false",
    "bool_parsing": "must be true or false",
    "float_parsing": "must be a number without a unit",
    "too_long": "must have at most {max_length} entries and has {actual_length}",
    "too_short": "must have at least {min_length} entries and has {actual_length}",
    "string_too_long": "must have at most {max_length} characters",
}


def tables(root: type[BaseModel]) -> list[type[BaseModel]]:
    """Give a class of tables and all that derive from it."""
    found = [root]
    for table in found:
        found += table.__subclasses__()
    return found


def tag_of(table: type[BaseModel], tag: str = "kind") -> Any:
    """Give the `kind` or `shape` of a class of tables; None where it has none."""
    return table.model_fields[tag].default if tag in table.model_fields else None


def first_error(error: ValidationError, data: Any, part: type[BaseModel], root: type[BaseModel]) -> SceneError:
    """Turn pydantic's errors about data, which were to be a part, into one; all parts derive from the root."""
    branches = {*MARKS, *map(tag_of, tables(root))}
    found = error.errors(include_url=False)
    first = _misspelled(found) or found[0]
    place = _place(first["loc"], data, branches)
    message, hint = _sentence(first), ""
    if first["type"] == "extra_forbidden":
        beside = [other["loc"] for other in found if other["type"] == "missing"]
        missing = [str(loc[-1]) for loc in beside if loc[:-1] == first["loc"][:-1]]
        near = difflib.get_close_matches(place[-1], missing, n=1)
        advice = "Remove it or correct its name; `fenics-mech schema` lists all keys"
        if len(place) > 1 and place[-1] in ABOVE:
            advice = "It belongs above the first [table] of the file"
        else:
            near = near or difflib.get_close_matches(place[-1], _keys_at(part, first["loc"][:-1]), n=1, cutoff=0.8)
            known = {key for table in tables(root) for key in _keys_of(table)}
            near = near or ([] if place[-1] in known else difflib.get_close_matches(place[-1], known, n=1, cutoff=0.8))
        message, hint = f"unknown key {shortened(place[-1])}", f"Did you mean {near[0]!r}?" if near else advice
        if place[:-1] == ["analysis"] and place[-1] in GONE:
            message = f"this key has gone: {GONE[place[-1]][1]}"
            hint = "Remove it, or let `fenics-mech check --update` rewrite the file"
    elif first["type"] == "missing":
        message = "this key is missing" if isinstance(first["loc"][-1], str) else "an entry of the list is missing"
        if place[0] in ("springs", "dampers") and place[-1] == "between":
            message = "there is neither `between`, two points, nor `joint`"
    places = {tuple(_place(other["loc"], data, branches)) for other in found}
    if len(places) > 1:
        hint = f"{hint}{'' if hint.endswith('?') else '.'} {len(places) - 1} more found after it".removeprefix(". ")
    return SceneError(message, place=".".join(place), hint=hint)


def _misspelled(found: list[Any]) -> Any | None:
    """Find the error about an unknown key that is nearly the name of one that is missing in the same table."""
    missing: dict[tuple[int | str, ...], list[str]] = {}  # of each table
    for error in found:
        if error["type"] == "missing":
            missing.setdefault(error["loc"][:-1], []).append(str(error["loc"][-1]))
    for error in found[:1000]:  # a file may have 400,000 unknown keys
        names = missing.get(error["loc"][:-1], []) if error["type"] == "extra_forbidden" else []
        if names and difflib.get_close_matches(str(error["loc"][-1]), names, n=1):
            return error
    return None


def _keys_of(table: type[BaseModel]) -> list[str]:
    return [field.alias or name for name, field in table.model_fields.items()]


def _keys_at(top: type[BaseModel], location: Sequence[int | str]) -> list[str]:
    """Give the keys of all tables that may stand at a location of pydantic, which begins in the top one."""
    here = [top]
    for part in location:  # names of entries and of branches of unions lead nowhere further
        fields = [field for table in here for name, field in table.model_fields.items() if part in (name, field.alias)]
        here = [table for field in fields for table in _tables_in(field.annotation)] if fields else here
    return [key for table in here for key in _keys_of(table)]


def _tables_in(annotation: Any) -> Iterator[type[BaseModel]]:
    """Give the tables of an annotation: of a union, and what lists and dictionaries hold."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _tables_in(part)


def _sentence(error: Any) -> str:
    """Say what pydantic found in words of ours."""
    if error["type"] in SENTENCES:
        message = SENTENCES[error["type"]].format(**error.get("ctx", {}))
        return message if "{tag" in SENTENCES[error["type"]] else f"{message}, found {shortened(error['input'])}"
    message = error["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    if error["type"].startswith("value_error") or error["type"] == "unknown_shape":
        return message
    if error["loc"] == ("effects", "literal['auto']"):
        return f'must be "auto", or a list of names such as ["coupling"], found {shortened(error["input"])}'
    if error["type"] == "string_pattern_mismatch":
        message = (
            "must be a name of letters, digits, _ and -, a letter or _ first, or link.point where a point is meant"
        )
        if "@" in error["ctx"]["pattern"]:
            message = "must be link.point, a joint, or member@place with a place 0 to 1 along the member"
    if error["type"] in ("int_parsing", "int_type", "int_from_float"):
        message = "must be a whole number" + " or 'all'" * ("modes" in error["loc"])
    return f"{message}, found {shortened(error['input'])}"


def _place(location: tuple[int | str, ...], data: Any, branches: Collection[Any]) -> list[str]:
    """Keep of pydantic's location what stands in the data, and the last key where it is missing there."""
    place: list[str] = []
    tagged: Any = None  # the table whose kind has been passed: a key of it may have the name of its kind
    for part in location:
        if isinstance(data, dict) and data is not tagged and part in branches and data.get("kind") == part:
            tagged = data
            continue
        known = part in data if isinstance(data, dict) else isinstance(data, list | tuple) and part in range(len(data))
        if known:
            data = data[part]  # type: ignore[index]
        elif (
            not isinstance(data, dict)
            or str(part).startswith((BRANCH, "literal["))
            or (part in branches and data is not tagged)
        ):
            continue  # a branch of a union, or a mark that the key itself is bad
        place.append(str(part))
    return place
