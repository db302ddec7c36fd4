"""The base of everything in a scene: frozen, and unknown keys are refused."""

from __future__ import annotations

import unicodedata
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from fenics_mech.errors import SceneError, shortened

CONTROL = "Cc", "Cf", "Cs", "Zl", "Zp"  # Unicode's control characters, marks of direction, halves and ends of lines

Name = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_\-]*$", max_length=100)]
PointName = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_\-]*\.[A-Za-z_][A-Za-z0-9_\-]*$")]


class Part(BaseModel):
    """A frozen piece of a scene."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def check_texts(part: Any, place: tuple[str, ...] = ()) -> None:
    """Raise `SceneError` where a text or key of nested data has a control character, which a terminal would obey."""
    if isinstance(part, str) and not part.isprintable():
        found = next((c for c in part if unicodedata.category(c) in CONTROL), None)
        if found is not None:
            raise SceneError(
                f"the text {shortened(part)} has the control character {found!a}",
                place=".".join(place),
                hint="Texts have letters, digits, signs and spaces",
            )
    elif isinstance(part, dict):
        for key, value in part.items():
            check_texts(key, place)
            check_texts(value, (*place, str(key)))
    elif isinstance(part, list | tuple):
        for i, value in enumerate(part):
            check_texts(value, (*place, str(i)))
