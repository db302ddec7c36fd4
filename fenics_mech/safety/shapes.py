"""Shapes of sections: what they are where numbers alone are stated, their torsion, and how dimensions enlarge them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from fenics_mech.scene import ISection, RectangleSection, RoundSection, TubeSection
from fenics_mech.scene.sections import CustomSection

SAME_SHAPE = 0.03  # of the inertia, within which the numbers of a section are those of a rectangle: they are rounded


@dataclass(frozen=True)
class Enlarged:
    """By how much a change of its dimensions enlarges what a section has: factors."""

    area: float = 1.0
    inertia: float = 1.0
    fibre: float = 1.0
    across: float = 1.0
    torsion: float = 1.0
    warping: float = 1.0


def shape_of(section: Any) -> Any:
    """Give the rectangle whose numbers a section states; every other section as it is."""
    if not isinstance(section, CustomSection):
        return section
    height = 2 * section.fibre
    if abs(section.area * height**2 / (12 * section.inertia) - 1) > SAME_SHAPE:
        return section
    return RectangleSection(width=section.area / height, height=height)


def torsion_of(section: Any) -> float | None:
    """Give the torsion constant J of a shape (m^4); None where no formula is known."""
    if isinstance(section, RectangleSection):
        long, thin = max(section.width, section.height), min(section.width, section.height)
        # Roark's Formulas for Stress and Strain, 7th ed., table 10.1, case 4 (whole sides here); 4e-3 off at most
        return long * thin**3 * (1 / 3 - 0.21 * thin / long * (1 - (thin / long) ** 4 / 12))
    if isinstance(section, RoundSection | TubeSection):
        return 2 * section.inertia  # polar inertia of a round
    if isinstance(section, ISection):  # sum of b t^3/3 of thin walls (Timoshenko and Gere, chapter 5)
        return (2 * section.width * section.flange**3 + (section.height - 2 * section.flange) * section.web**3) / 3
    return None


def warping_of(section: Any) -> float:
    """Give the warping constant of a shape over its inertia across the plane (m^2): h0^2/4 of an I; 0 of solid ones."""
    # h0 is the distance between the middles of the flanges (Timoshenko and Gere, section 5.3).
    return (section.height - section.flange) ** 2 / 4 if isinstance(section, ISection) else 0.0


def enlarged(section: Any, key: str, factor: float) -> Enlarged:
    """Give by how much a section grows with one of its dimensions, or with all of them."""
    if not key:
        return Enlarged(factor**2, factor**4, factor, factor**4, factor**4, factor**2)
    other = section.model_copy(update={key: getattr(section, key) * factor})
    torsion, before = torsion_of(other), torsion_of(section)
    return Enlarged(
        other.area / section.area,
        other.inertia / section.inertia,
        other.fibre / section.fibre,
        other.inertia_across / section.inertia_across,
        torsion / before if torsion and before else 1.0,
        warping_of(other) / (warping_of(section) or 1.0),
    )


def dimension(section: Any, across: bool) -> str:
    """Name the dimension of a section that is to be changed; "" for all."""
    if isinstance(section, RoundSection | TubeSection):
        return "diameter"
    if isinstance(section, RectangleSection | ISection):
        return "width" if across else "height"
    return ""
