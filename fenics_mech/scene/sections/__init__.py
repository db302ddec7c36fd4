"""Cross-sections, by `shape`: each gives the `Rigidity` of a member, which may change along it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, get_args

from pydantic import Discriminator, Tag

from fenics_mech.errors import SceneError
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


def _shape(value: Any) -> Any:
    return value.get("shape", "custom") if isinstance(value, dict) else getattr(value, "shape", None)


Kinds = (
    Annotated[CustomSection, Tag("custom")]
    | Annotated[RectangleSection, Tag("rectangle")]
    | Annotated[RoundSection, Tag("round")]
    | Annotated[TubeSection, Tag("tube")]
    | Annotated[ISection, Tag("I")]
    | Annotated[LaminateSection, Tag("laminate")]
    | Annotated[PolygonSection, Tag("polygon")]
    | Annotated[VariableSection, Tag("variable")]
    | Annotated[TaperSection, Tag("taper")]
)
KNOWN = ", ".join(get_args(kind)[1].tag for kind in get_args(Kinds))
AnySection = Annotated[
    Kinds,
    Discriminator(
        _shape,
        custom_error_type="unknown_shape",
        custom_error_message=f"there is no such shape of section; known are {KNOWN}",
    ),
]


def check_sections(scene: Scene) -> None:
    """Raise `SceneError` where a section names what the scene does not have, or a member has no material.

    Parameters
    ----------
    scene
        The scene.
    """
    stock = Stock(None, scene.materials, scene.sections)
    for name, section in scene.sections.items():
        section.check(f"sections.{name}", stock)
    for link, body in scene.links.items():
        for name, member in body.members.items():
            unnamed = member.material is None and member.section in scene.sections
            if unnamed and not scene.sections[member.section].complete:
                raise SceneError(
                    f"a member of section {member.section!r} needs a material",
                    place=f"links.{link}.members.{name}.material",
                    hint="Only sections that name the materials of their parts do without",
                )


__all__ = [
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
    "check_sections",
]
