"""Cross-sections: each gives its area A (m^2), second moment I (m^4) and fibre distances (m)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from fenics_mech.scene.base import Part
from fenics_mech.units import Area, Length, SecondMoment

Positive = Field(gt=0)


class CustomSection(Part):
    """A section given by its numbers, as in table 7.1.

    Parameters
    ----------
    area
        A (m^2).
    inertia
        Second moment of area I about the neutral line (m^4).
    fibre
        Distance n from the neutral line to the outer fibres (m), the same on both sides.
    """

    shape: Literal["custom"] = "custom"
    area: Annotated[Area, Positive]
    inertia: Annotated[SecondMoment, Positive]
    fibre: Annotated[Length, Positive]


class RectangleSection(Part):
    """A rectangle that bends about the axis parallel to its width.

    Parameters
    ----------
    width
        Size normal to the plane of motion (m).
    height
        Size in the plane of motion (m).
    """

    shape: Literal["rectangle"]
    width: Annotated[Length, Positive]
    height: Annotated[Length, Positive]

    @property
    def area(self) -> float:
        """A = width height (m^2)."""
        return self.width * self.height

    @property
    def inertia(self) -> float:
        """I = width height^3/12 (m^4)."""
        return self.width * self.height**3 / 12

    @property
    def fibre(self) -> float:
        """Half the height (m)."""
        return self.height / 2


Section = CustomSection | RectangleSection
