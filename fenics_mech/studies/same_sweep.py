"""Whether the folder of a sweep holds the same sweep."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, JsonValue, TypeAdapter
from typing_extensions import TypedDict

from fenics_mech._read_back import STRICT, Text, read_json
from fenics_mech.errors import SceneError


class _GaugeBefore(TypedDict):
    __pydantic_config__ = STRICT  # type: ignore[misc]
    s: float
    fibre: Literal["+", "-"]
    harmonics: int


class _Plan(TypedDict):
    __pydantic_config__ = STRICT  # type: ignore[misc]
    scene: dict[Text, JsonValue]
    gauge: _GaugeBefore
    values: dict[Text, Annotated[list[Annotated[float, Field(allow_inf_nan=False)]], Field(min_length=1)]]


PLAN = TypeAdapter(_Plan)


def plan_before(path: Path) -> dict[str, Any]:
    """Read what is swept in a folder."""
    plan = read_json(path, PLAN)
    return {**plan}


def refuse_other(before: dict[str, Any], plan: dict[str, Any], folder: Path) -> None:
    """Raise an error unless a folder's plan is of the same scene and fields."""
    # No value of it may be left out now, so that no point computed before is left out of the result.
    hint = "Give another folder with -o"
    if before["values"].keys() != plan["values"].keys():
        swept = ", ".join(before["values"])
        raise SceneError(f"the folder {folder} holds a sweep over {swept}", place="sweep", hint=hint)
    for part in ("scene", "gauge"):
        if where := first_difference(before[part], plan[part]):
            raise SceneError(f"the folder {folder} holds a sweep of another {part}", place=where, hint=hint)
    for path, values in before["values"].items():
        if not set(values) <= set(plan["values"][path]):
            range_before = (
                f"from {min(values):g} to {max(values):g} at {len(values)} values, not all of them in this one"
            )
            raise SceneError(f"the folder {folder} holds a sweep {range_before}", place=path, hint=hint)


def first_difference(one: Any, other: Any, place: str = "") -> str:
    """Give the dotted place of the first difference of two trees of plain data, or an empty text."""
    if isinstance(one, dict) and isinstance(other, dict):
        pairs = {key: (one.get(key), other.get(key)) for key in sorted(one.keys() | other.keys())}
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        pairs = {str(index): pair for index, pair in enumerate(zip(one, other))}
    else:
        return "" if one == other else place or "scene"
    found = (first_difference(*pair, f"{place}.{key}".lstrip(".")) for key, pair in pairs.items())
    return next((where for where in found if where), "")
