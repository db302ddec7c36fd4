"""What the dataset of a saved sweep has to hold, so that its summary, page and plots need not ask."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
import xarray as xr
from pydantic import Field, JsonValue, TypeAdapter, ValidationError
from typing_extensions import TypedDict

from fenics_mech._read_back import STRICT, Text, read_json
from fenics_mech.errors import SceneError, shortened
from fenics_mech.scene.joints import joint_names
from fenics_mech.studies.kept_points import KEPT, TEXTS
from fenics_mech.studies.point_curves import CURVES

if TYPE_CHECKING:
    from fenics_mech.scene import Scene


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


ALWAYS = "error", "message", "effects", "not_estimated", "warnings"  # texts of all versions
TOGETHER = {  # what comes with a variable, where that is there
    "curve_stress_highest": (*TEXTS, *CURVES.keys() - {"curve_input_torque", "curve_joint_force"}),
    "safety_min": ("safety_member", "safety_mode"),
    "rotation": ("euler_ratio", "bow"),
    "theory_share": ("deflection_theory_share",),
    "peak_strain": ("peak_strain_s",),
    "curve_strain_highest": ("peak_strain", "peak_stress"),
    "curve_input_torque": ("peak_input_torque",),
    "curve_joint_force": ("peak_joint_force",),
}


class _Numbers(TypedDict, total=False):
    """Mesh and steps that the program took at a point."""

    __pydantic_config__ = STRICT  # type: ignore[misc]
    elements: float
    sub_intervals: float
    modes: float
    harmonics: float
    time_tolerance: float
    solver: str


class _Between(TypedDict):
    """The largest strain between the points."""

    __pydantic_config__ = STRICT  # type: ignore[misc]
    value: float
    member: str
    strain: float
    stress: float


NUMBERS, BETWEEN = TypeAdapter(_Numbers), TypeAdapter(_Between)


def refuse_unlike(data: xr.Dataset, paths: Sequence[str], scene: Scene) -> None:
    """Raise `ValueError` where a dataset is not as a sweep gives it."""
    if not paths or len(set(paths)) < len(paths) or "title" not in data.attrs:
        raise ValueError("it does not name its title and the fields that are swept")
    for path in paths:
        _refuse_field(data, path)
    if lacking := set(ALWAYS) - set(map(str, data.data_vars)):
        raise ValueError(f"it lacks {min(lacking)}")
    for name, others in TOGETHER.items():
        if name in data and (lacking := set(others) - set(map(str, data.data_vars))):
            raise ValueError(f"it has {name} without {min(lacking)}")
    labels: dict[str, Collection[str]] = {"member": scene.members(), "joint": joint_names(scene.joints)}
    for dim, known in labels.items():
        if dim in data.dims and (dim not in data.coords or not {*map(str, data[dim].to_numpy())} == {*known}):
            raise ValueError(f"it does not have the {dim}s of its scene")
    for variable, part in data.data_vars.items():
        _refuse_variable(str(variable), part, paths)
    for text in {*map(str, data["numbers"].to_numpy().ravel())} - {""} if "numbers" in data else ():
        _refuse_json(NUMBERS, text, "numbers")
    if between := data.attrs.get("between"):
        _refuse_json(BETWEEN, between, "between")


def _refuse_field(data: xr.Dataset, path: str) -> None:
    """Refuse the values of a swept field that are no finite numbers, or do not say how they were written."""
    if path not in data.coords or data[path].dims != (path,) or data[path].dtype.kind not in "fiu":
        raise ValueError(f"it has no values of {shortened(path)}")
    values, attributes = data[path].to_numpy(), data[path].attrs
    if not values.size or not np.isfinite(values).all():
        raise ValueError(f"the values of {shortened(path)} are not finite numbers")
    factor = attributes.get("written_factor")
    if not isinstance(factor, int | float | np.number) or not 0 < factor < np.inf:
        raise ValueError(f"it does not say in which unit {shortened(path)} was written")
    if not isinstance(attributes.get("written_units"), str):
        raise ValueError(f"it does not say in which unit {shortened(path)} was written")


def _refuse_variable(name: str, part: xr.DataArray, paths: Sequence[str]) -> None:
    """Refuse a variable of other dimensions, or of another kind, than a sweep gives it."""
    if name in TEXTS:
        dims, kinds = {*paths}, "OUS"
    elif name in KEPT:
        dims, kinds = {*paths, *KEPT[name][0]}, "fiu"
    elif name in CURVES:
        dims, kinds = {*paths, "curve_theta", CURVES[name][0]} - {""}, "fiu"
    elif name.startswith("curve_"):
        raise ValueError(f"{shortened(name)} is no curve of a sweep")
    else:
        return
    if {*part.dims} != dims or part.dtype.kind not in kinds:
        raise ValueError(
            f"{name} is not a {'text' if kinds == 'OUS' else 'number'} for each {' and '.join(sorted(dims))}"
        )
    if kinds != "OUS" and not isinstance(part.attrs.get("units"), str):
        raise ValueError(f"{name} has no unit")


def _refuse_json(kind: TypeAdapter[Any], text: str, name: str) -> None:
    try:
        kind.validate_json(text)
    except ValidationError as error:
        raise ValueError(f"its {name} are none that the program has written") from error
