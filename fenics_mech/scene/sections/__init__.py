"""Cross-sections, by `shape`: each gives the `Rigidity` of a member, which may change along it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Union

from pydantic import Discriminator, Tag

from fenics_mech.errors import SceneError
from fenics_mech.scene.first_error import BRANCH
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

if TYPE_CHECKING:
    from fenics_mech.scene.models import Scene


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


def _shape_of(kind: type[Section]) -> str:
    return str(kind.model_fields["shape"].default)


SHAPES = tuple(map(_shape_of, OWN))


def _tag(value: Any) -> Any:
    """Give the branch of the union that reads a value: its shape with the mark of a branch."""
    shape = value.get("shape", "custom") if isinstance(value, dict) else getattr(value, "shape", None)
    return f"{BRANCH}{shape}" if isinstance(shape, str) else None


def any_section(*more: type[Section]) -> Any:
    """Give the type of all sections, by their `shape`."""
    kinds: tuple[type[Section], ...] = (*OWN, *more)
    tagged = tuple(Annotated[kind, Tag(f"{BRANCH}{_shape_of(kind)}")] for kind in kinds)  # type: ignore[valid-type]
    union = Union[tagged]  # type: ignore[valid-type]  # noqa: UP007
    known = ", ".join(map(_shape_of, kinds))
    message = f"there is no such shape of section; known are {known}"
    return Annotated[union, Discriminator(_tag, custom_error_type="unknown_shape", custom_error_message=message)]


if TYPE_CHECKING:
    AnySection = Section
else:
    AnySection = any_section()


def check_sections(scene: Scene) -> None:
    """Raise `SceneError` where a section names what the scene does not have, or a member has no material."""
    stock = Stock(None, scene.materials, scene.sections)
    for name, section in scene.sections.items():
        section.check(f"sections.{name}", stock)
    for link, body in scene.links.items():
        for name, member in body.members.items():
            unnamed = member.material is None and member.section in scene.sections
            if unnamed and not scene.sections[member.section].complete:
                what = f"a member of section {member.section!r} needs a material"
                hint = "Only sections that name the materials of their parts do without"
                raise SceneError(what, place=f"links.{link}.members.{name}.material", hint=hint)


__all__ = [
    "SHAPES",
    "AnySection",
    "CustomSection",
    "ISection",
    "LaminateSection",
    "PlainSection",
    "Ply",
    "PolygonPart",
    "PolygonSection",
    "RectangleSection",
    "Rigidity",
    "RoundSection",
    "Section",
    "Stock",
    "TaperSection",
    "TubeSection",
    "VariableSection",
    "any_section",
    "check_sections",
]
