"""What the program reads back of its own files: kept points and trials, plans of sweeps, and saved results.

Whatever else stands in the place of such a file, or in it, is refused here, so that those who ask need no checks.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import numpy as np
from pydantic import ConfigDict, Field, TypeAdapter, ValidationError
from typing_extensions import TypedDict

from fenics_mech._files import read_bounded
from fenics_mech.errors import LONGEST_MESSAGE, shortened

if TYPE_CHECKING:
    import xarray as xr

LARGEST_KEPT = 100_000_000  # bytes of a JSON file: 10,000 harmonics of 400 members
LARGEST_STRAIN = 1.0  # a member as long again as it was: no theory here reaches that, nor does a metal
LONGEST_TEXT = 100_000  # characters of many messages, one a line
LONGEST_LABEL = 500  # characters
FINITE = "theta", "time", "s", "strain", "deflection", "joint_force", "input_torque"  # what a result has no gaps in

Kind = TypeVar("Kind")
Text = Annotated[str, Field(max_length=LONGEST_TEXT)]
Message = Annotated[str, Field(max_length=LONGEST_MESSAGE + 10)]
ErrorName = Annotated[str, Field(max_length=100, pattern=r"^([A-Za-z_]\w*)?$")]  # of the class; it goes into tables
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
STRICT = ConfigDict(strict=True, extra="forbid")


class Ended(TypedDict):
    """How an analysis that is kept has ended, and whether it is to be tried again."""

    __pydantic_config__ = STRICT  # type: ignore[misc]
    error: ErrorName
    message: Message
    seconds: NotNegative
    again: bool


class Decided(TypedDict):
    """What a result says of an effect."""

    __pydantic_config__ = STRICT  # type: ignore[misc]
    name: Text
    size: float | None
    acts: bool
    lacking: Text


def read_json(path: Path, kind: TypeAdapter[Kind]) -> Kind:
    """Read a JSON file of one kind: an ordinary file, bounded in size and depth, of the very types that are stated."""
    # Symbolic links are followed, as those of scenes are: of a file that is not of the kind nothing is shown.
    content = read_bounded(path, LARGEST_KEPT)
    try:
        return kind.validate_json(content)
    except ValidationError as error:
        raise ValueError(f"its {path.name} is none that the program has written") from error


def read_kept(path: Path | None, kind: TypeAdapter[Kind]) -> Kind | None:
    """Read a kept JSON file; None where there is none of that kind, so that it is made anew."""
    try:
        return None if path is None else read_json(path, kind)
    except (OSError, ValueError):
        return None


# Of results: what attributes hold, and what labels are made of, by their names.
@cache
def _attribute_kinds() -> dict[str, TypeAdapter[Any]]:
    lists = {"effects": list[Decided], "warnings": list[Text], "paths": list[Text]}
    return {name: TypeAdapter(kind) for name, kind in lists.items()}


TEXTS = (
    *("fenics_mech", "title", "scene", "solver", "not_estimated", "chosen", "refined", "refined_because"),
    *("coarse_because", "between", "effects", "warnings", "paths", "ended"),
)
NUMBERS = (
    *("mobility", "dofs", "elements", "energy_fluctuation", "speed_fluctuation", "power_residual", "power_error"),
    *("power_balance_error", "condition", "too_coarse", "stability_limit", "time_steps", "contacts_closed"),
    *("cycle_change", "interpolation_error", "error_estimate", "deflection_error_estimate", "stated_rate"),
    *("joint_force_error_estimate", "drive_effort_error_estimate", "freedom_place_error_estimate"),
    *("own_period", "repeats_after", "closing_error", "dimension"),
    *("strain_error_estimate", "torque_error_estimate"),
)
OF_SCENE = (  # labels that are made of names that the scene has
    *("member", "joint", "link", "drive", "support", "point", "pair", "slide", "freedom", "law", "contact"),
    *("spring", "damper", "motor_at", "held", "linked", "multiplier_link", "held_link"),
)
OF_PROGRAM = {  # labels that are words of the program
    "fibre": {"+", "-"},
    "gauge_fibre": {"+", "-"},
    "component": {"x", "y", "z"},
    "section_axis": {"along", "first", "second"},
    "end": {"first", "second"},
    "part": {"real", "imaginary"},
    "gauge": {"mid-span", "peak"},
    "axis": {"x", "y"},
}
SUPPORTS = frozenset({"spring", "damper", "joint", "law"})  # words before the names of supports that are no joints
NAMES = re.compile(r"[A-Za-z0-9_\-]+")
VARIABLE = re.compile(r"[A-Za-z_][\w. \-]{0,300}")
JOINED = re.compile(r"[A-Za-z_][A-Za-z0-9_ .,:()\-]*")


def refuse_strange(data: xr.Dataset, names: Callable[[], Collection[str]]) -> None:
    """Raise where a loaded dataset holds what no analysis of its scene gives."""
    for name, value in data.attrs.items():
        _refuse_attribute(str(name), value)
    for name, variable in data.variables.items():
        if not VARIABLE.fullmatch(str(name)):  # it may become the name of a file
            raise ValueError(f"{shortened(str(name))} is no name of a variable")
        if variable.dtype.kind in "OUS":
            labels = [str(label) for label in variable.to_numpy().ravel()]
            if name in data.dims and len(set(labels)) < len(labels):
                raise ValueError(f"two labels of {shortened(str(name))} are the same")
            known = frozenset(names()) if name in OF_SCENE else frozenset[str]()
            for label in labels if name in data.coords or name in OF_SCENE else ():
                if not _is_label(str(name), label, known):
                    raise ValueError(f"{shortened(label)} is no {shortened(str(name))} of its scene")
        elif name in FINITE and not np.isfinite(variable.to_numpy()).all():
            raise ValueError(f"{name} has no number everywhere")
        elif name in OF_SCENE and variable.size:
            raise ValueError(f"labels of {name} are texts")


def _is_label(name: str, label: str, known: frozenset[str]) -> bool:
    if name in OF_SCENE:
        kinds = SUPPORTS if name == "support" else frozenset()
        return JOINED.fullmatch(label) is not None and (known | kinds).issuperset(NAMES.findall(label))
    return label in OF_PROGRAM.get(name, (label,)) and label.isprintable() and len(label) <= LONGEST_LABEL


def _refuse_attribute(name: str, value: object) -> None:
    if name in TEXTS and not isinstance(value, str):
        raise ValueError(f"its attribute {name} is no text")
    if name in NUMBERS and not isinstance(value, int | float | np.number):
        raise ValueError(f"its attribute {name} is no number")
    if name in (kinds := _attribute_kinds()):
        try:
            kinds[name].validate_json(str(value), strict=True)
        except ValidationError as error:
            raise ValueError(f"its attribute {name} is none that the program has written") from error
