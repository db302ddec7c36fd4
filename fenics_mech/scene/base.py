"""The base of everything in a scene: frozen, and unknown keys are refused."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from fenics_mech.errors import SceneError, shortened
from fenics_mech.scene.first_error import first_error


@dataclass(frozen=True)
class SceneLimits:
    """Limits of what a scene may state."""

    longest_name: int = 200  # characters
    most_links: int = 500  # the loops are solved with dense matrices
    neglected: float = 0.01  # of the strains, by effects that are left out where no tolerance is stated
    most_stations: int = 10_001  # along a member
    most_sub_intervals: int = 1_000_000  # of a cycle
    finest_steps: float = 1e-12  # time_tolerance: matrices are interpolated to that; measured, strains follow to 3e-13
    smallest_tolerance: float = 1e-8  # of any quantity
    largest_tolerance: float = 1.0  # the same
    folded: float = 1e-12  # rounding of a cosine, where the links of a four-bar lie in line


SCENE = SceneLimits()


Thing = TypeVar("Thing")
CONTROL = "Cc", "Cf", "Cs", "Zl", "Zp"  # Unicode's control characters, marks of direction, halves and ends of lines

Name = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_\-]*$", max_length=100)]
PointName = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_\-]*\.[A-Za-z_][A-Za-z0-9_\-]*$")]


class Part(BaseModel):
    """A frozen piece of a scene. Quantities are numbers in SI or texts with a unit: ``"135 mm"``.

    Raises
    ------
    SceneError
        About the first thing that is wrong, with its place.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def __init__(self, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise first_error(error, values, type(self), Part) from None

    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]  # parts of a part are validated without it

    @model_validator(mode="after")
    def _is_sound(self) -> Self:
        self._check_keys()
        return self

    def _check_keys(self) -> None:
        """Raise `ValueError` where keys, each of which is valid, contradict each other."""

    @classmethod
    def read(cls, data: Any) -> Self:
        """Make the part from plain data."""
        try:
            return cls.model_validate(data)
        except ValidationError as error:
            raise first_error(error, data, cls, Part) from None


WITH_TEXTS = str, dict, list, tuple  # what may be, or hold, a text


def check_texts(part: Any, place: tuple[str, ...] = ()) -> None:
    """Raise `SceneError` where a text or key of nested data has a control character, which a terminal would obey."""
    if isinstance(part, str):
        found = None if part.isprintable() else next((c for c in part if unicodedata.category(c) in CONTROL), None)
        if found is not None:
            what = f"the text {shortened(part)} has the control character {found!a}"
            hint = "Texts have letters, digits, signs and spaces"
            raise SceneError(what, place=".".join(place), hint=hint)
        return
    keyed = isinstance(part, dict)
    items = part.items() if keyed else enumerate(part) if isinstance(part, list | tuple) else ()
    for key, value in items:
        if keyed:
            check_texts(key, place)
        if isinstance(value, WITH_TEXTS):
            check_texts(value, (*place, str(key)))


def check_paired(**columns: Sequence[float]) -> None:
    """Raise `ValueError` unless two columns of a table, by name, have as many values."""
    (one, first), (other, second) = columns.items()
    if len(first) != len(second):
        raise ValueError(f"{len(first)} {one} and {len(second)} {other}: a table needs the same number of both")


def known(things: Mapping[str, Thing], name: str, kind: str, place: str) -> Thing:
    """Give the thing of a name; raise `SceneError` where there is none."""
    check_known(name, things, kind, place)
    return things[name]


def check_known(name: str, things: Iterable[str], kind: str, place: str, of: str = "") -> None:
    """Raise `SceneError` unless there is a thing of that name."""
    if name not in things:
        raise SceneError(f"there is no {kind} {name!r}{of}", place=place, hint=f"Known: {', '.join(things) or 'none'}")


def place_in(part: Any, path: str, value: Any) -> None:
    """Put a value into nested data, by dotted path; tables on the way are made where they are missing."""
    *parents, last = (int(key) if key.isdecimal() else key for key in path.split("."))
    if "__" in path and path.partition("__")[0] in part:
        hint = f'Write {path.replace("__", ".")!r}: "__" stands for dots in names of arguments only'
        raise SceneError("there is no such part of the scene", place=path, hint=hint)
    try:
        for parent in parents:
            if isinstance(part, dict):
                part.setdefault(parent, {})
            part[parent] = list(part[parent]) if isinstance(part[parent], tuple) else part[parent]
            part = part[parent]
        part[last] = value
    except (KeyError, IndexError, TypeError) as error:
        raise SceneError("there is no such part of the scene", place=path) from error
