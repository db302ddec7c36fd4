"""Cross-sections, by `shape`: each gives the `Rigidity` of a member, which may change along it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Union

from pydantic import Discriminator, Tag

from fenics_mech.scene.first_error import BRANCH, tag_of
from fenics_mech.scene.sections.laminate import LaminateSection, Ply
from fenics_mech.scene.sections.plain import (
    CustomSection,
    ISection,
    PlainSection,
    RectangleSection,
    RoundSection,
    TubeSection,
)
from fenics_mech.scene.sections.polygon import PolygonPart, PolygonSection
from fenics_mech.scene.sections.rigidity import Rigidity, Section, Stock
from fenics_mech.scene.sections.variable import TaperSection, VariableSection

OWN: tuple[type[Section], ...] = (
    CustomSection,
    RectangleSection,
    RoundSection,
    TubeSection,
    ISection,
    LaminateSection,
    PolygonSection,
    VariableSection,
    TaperSection,
)


def _tag(value: Any) -> Any:
    """Give the branch of the union that reads a value: its shape with the mark of a branch."""
    shape = value.get("shape", "custom") if isinstance(value, dict) else getattr(value, "shape", None)
    return f"{BRANCH}{shape}" if isinstance(shape, str) else None


def any_section(*more: type[Section]) -> Any:
    """Give the type of all sections, by their `shape`."""
    kinds = {tag_of(kind, "shape"): kind for kind in (*OWN, *more)}
    tagged = tuple(Annotated[kind, Tag(f"{BRANCH}{shape}")] for shape, kind in kinds.items())  # type: ignore[valid-type]
    union = Union[tagged]  # type: ignore[valid-type]  # noqa: UP007
    message = f"there is no such shape of section; known are {', '.join(kinds)}"
    return Annotated[union, Discriminator(_tag, custom_error_type="unknown_shape", custom_error_message=message)]


if TYPE_CHECKING:
    AnySection = Section
else:
    AnySection = any_section()


__all__ = [
    "AnySection", "CustomSection", "ISection", "LaminateSection", "PlainSection", "Ply", "PolygonPart",
    "PolygonSection", "RectangleSection", "Rigidity", "RoundSection", "Section", "Stock", "TaperSection",
    "TubeSection", "VariableSection", "any_section",
]  # fmt: skip
