"""Solid elliptic sections."""

import math
from typing import Annotated, Literal

from fenics_mech.scene.sections.plain import PlainSection
from fenics_mech.scene.sections.rigidity import Positive
from fenics_mech.scene.units import Length


class EllipseSection(PlainSection):
    """A solid ellipse.

    Parameters
    ----------
    shape
        "ellipse".
    width
        Size normal to the plane of motion (m).
    height
        Size in the plane of motion (m).
    """

    shape: Literal["ellipse"] = "ellipse"
    width: Annotated[Length, Positive]
    height: Annotated[Length, Positive]

    @property
    def area(self) -> float:
        """A = pi width height/4 (m^2)."""
        return math.pi * self.width * self.height / 4

    @property
    def inertia(self) -> float:
        """I = pi width height^3/64 (m^4)."""
        return math.pi * self.width * self.height**3 / 64

    @property
    def fibre(self) -> float:
        """Distance of the outer fibres, height/2 (m)."""
        return self.height / 2
