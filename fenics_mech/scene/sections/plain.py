"""Sections of one material that are symmetric about the neutral line: area A (m^2), inertia I (m^4), fibre (m).

Their formulas hold for numbers and, in a taper, for arrays of dimensions.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field

from fenics_mech._arrays import Array
from fenics_mech.scene.sections.rigidity import Positive, Rigidity, Section, Stock, stated_factor
from fenics_mech.scene.units import Area, Length, SecondMoment

if TYPE_CHECKING:
    from fenics_mech.scene.bodies import Material


def of_one_material(
    s: Array, material: Material, area: Array | float, inertia: Array | float, fibre: Array | float
) -> Rigidity:
    """Give the rigidity of one material by A (m^2), I (m^4) and fibre (m) at places s, one number or ``(places,)``."""
    e = material.modulus
    rho = material.density
    return Rigidity.at(s, e * area, e * inertia, rho * area, rho * inertia, (e, e), (fibre, -fibre))


ShearFactor = Annotated[float, Field(gt=0, le=1)]


class PlainSection(Section):
    """A section that has its area, inertia and fibre.

    Parameters
    ----------
    shear_factor
        Share of the area that carries shear; by default that of the shape after Cowper, J. Appl. Mech. 33 (1966) 335,
        with the material's Poisson ratio, or 0 where it states a shear modulus alone. A custom section has no shape and
        no default.
    """

    shear_factor: ShearFactor | None = None

    if TYPE_CHECKING:  # fields of a custom section, properties of all others

        @property
        def area(self) -> float:
            """A (m^2)."""

        @property
        def inertia(self) -> float:
            """I about the neutral line (m^4)."""

        @property
        def fibre(self) -> float:
            """Distance from the neutral line to the outer fibres (m)."""

    def rigidity(self, s: Array, stock: Stock) -> Rigidity:
        """EA, EI, rho A, rho I and fibres of the one material, as `Section.rigidity` says."""
        return of_one_material(s, stock.only, self.area, self.inertia, self.fibre)

    def shear_stiffness(self, s: Array, stock: Stock, place: str) -> Array:
        """G times the shear factor times A, as `Section.shear_stiffness` says."""
        material, factor = stock.only, self.shear_factor
        if factor is None:
            factor = stated_factor(self.cowper(material.shear_poisson), place)
        return np.broadcast_to(material.rigidity * factor * self.area, s.shape)

    def bending_across(self, s: Array, stock: Stock) -> Array | None:
        """E times the inertia across the plane, as `Section.bending_across` says."""
        if self.inertia_across is None or stock.material is None:
            return None
        return np.broadcast_to(stock.material.modulus * self.inertia_across, s.shape)

    @property
    def inertia_across(self) -> float | None:
        """Second moment of area about the line in the plane of motion (m^4); None where no shape is known."""
        return None

    def cowper(self, poisson: float) -> float | None:
        """Give Cowper's shear factor of the shape by Poisson's ratio; None where it has none."""
        return None

    def moment_over_breadth(self, y: Array) -> Array | None:
        """Give S/b (m^2) at y (m): shear stress is ``Q S/(I b)`` (Zhuravskii); None where no shape is known."""
        return None


class CustomSection(PlainSection):
    """A section given by its numbers, as in table 7.1.

    Parameters
    ----------
    area
        A (m^2).
    inertia
        Second moment of area I about the neutral line (m^4).
    fibre
        Distance n from the neutral line to the outer fibres (m), the same on both sides.

    Examples
    --------
    >>> fm.CustomSection(area="1.07 cm^2", inertia="1.62e-2 cm^4", fibre="2 mm").fibre
    0.002
    """

    shape: Literal["custom"] = "custom"
    area: Annotated[Area, Positive]
    inertia: Annotated[SecondMoment, Positive]
    fibre: Annotated[Length, Positive]


class RectangleSection(PlainSection):
    """A rectangle that bends about the axis parallel to its width.

    Parameters
    ----------
    width
        Size normal to the plane of motion (m).
    height
        Size in the plane of motion (m).

    Examples
    --------
    >>> fm.RectangleSection(width="25 mm", height="2 mm").area
    5e-05
    """

    shape: Literal["rectangle"] = "rectangle"
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
    def inertia_across(self) -> float:
        """Height width^3/12 (m^4)."""
        return self.height * self.width**3 / 12

    @property
    def fibre(self) -> float:
        """Half the height (m)."""
        return self.height / 2

    def cowper(self, poisson: float) -> float:
        """Of a rectangle: 5/6 for a Poisson ratio of 0."""
        return 10 * (1 + poisson) / (12 + 11 * poisson)

    def moment_over_breadth(self, y: Array) -> Array:
        """Of a rectangle: parabolic, with the largest shear stress 3/2 of the mean."""
        return ((self.height / 2) ** 2 - y**2) / 2


class RoundSection(PlainSection):
    """A solid round.

    Parameters
    ----------
    diameter
        Diameter (m).

    Examples
    --------
    >>> fm.RoundSection(diameter="8 mm").fibre
    0.004
    """

    shape: Literal["round"] = "round"
    diameter: Annotated[Length, Positive]

    @property
    def area(self) -> float:
        """A = pi d^2/4 (m^2)."""
        return math.pi * self.diameter**2 / 4

    @property
    def inertia(self) -> float:
        """I = pi d^4/64 (m^4)."""
        return math.pi * self.diameter**4 / 64

    @property
    def inertia_across(self) -> float:
        """The same as in the plane (m^4)."""
        return self.inertia

    @property
    def fibre(self) -> float:
        """Half the diameter (m)."""
        return self.diameter / 2

    def cowper(self, poisson: float) -> float:
        """Of a round: 6/7 for a Poisson ratio of 0."""
        return 6 * (1 + poisson) / (7 + 6 * poisson)

    def moment_over_breadth(self, y: Array) -> Array:
        """Of a round: the largest shear stress is 4/3 of the mean."""
        return ((self.diameter / 2) ** 2 - y**2) / 3


class TubeSection(PlainSection):
    """A round tube.

    Parameters
    ----------
    diameter
        Outer diameter (m).
    thickness
        Thickness of the wall (m), at most half the diameter.

    Examples
    --------
    >>> round(fm.TubeSection(diameter="10 mm", thickness="1 mm").area, 9)
    2.8274e-05
    """

    shape: Literal["tube"] = "tube"
    diameter: Annotated[Length, Positive]
    thickness: Annotated[Length, Positive]

    def _check_keys(self) -> None:
        if self.thickness > self.diameter / 2:
            raise ValueError(
                f"the wall of a tube is at most half its diameter: expected thickness <= {self.diameter / 2:g} m, "
                f"found {self.thickness:g} m"
            )

    @property
    def area(self) -> float:
        """A = pi t (d - t) (m^2)."""
        return math.pi * self.thickness * (self.diameter - self.thickness)

    @property
    def inertia(self) -> float:
        """I = A (d^2 + (d - 2t)^2)/16, which loses no digits for a thin wall (m^4)."""
        return self.area * (self.diameter**2 + (self.diameter - 2 * self.thickness) ** 2) / 16

    @property
    def inertia_across(self) -> float:
        """The same as in the plane (m^4)."""
        return self.inertia

    @property
    def fibre(self) -> float:
        """Half the outer diameter (m)."""
        return self.diameter / 2

    def cowper(self, poisson: float) -> float:
        """Of a round tube: 1/2 for a thin wall and a Poisson ratio of 0."""
        hollow = (1 - 2 * self.thickness / self.diameter) ** 2  # inner over outer diameter, squared
        thick = (1 + hollow) ** 2
        return 6 * (1 + poisson) * thick / ((7 + 6 * poisson) * thick + (20 + 12 * poisson) * hollow)

    def moment_over_breadth(self, y: Array) -> Array:
        """Of two rounds: ``(a^3 - c^3)/(3 (a - c))`` with their half chords a and c."""
        outer = np.sqrt(np.maximum((self.diameter / 2) ** 2 - y**2, 0.0))
        inner = np.sqrt(np.maximum((self.diameter / 2 - self.thickness) ** 2 - y**2, 0.0))
        return np.asarray(outer**2 + outer * inner + inner**2) / 3


class ISection(PlainSection):
    """An I whose web lies in the plane of motion, with equal flanges.

    Parameters
    ----------
    height
        Whole height (m), in the plane of motion.
    width
        Width of the flanges (m).
    flange, web
        Thickness of each flange and of the web (m).

    Examples
    --------
    >>> round(fm.ISection(height="20 mm", width="10 mm", flange="2 mm", web="1 mm").area, 9)
    5.6e-05
    """

    shape: Literal["I"] = "I"
    height: Annotated[Length, Positive]
    width: Annotated[Length, Positive]
    flange: Annotated[Length, Positive]
    web: Annotated[Length, Positive]

    def _check_keys(self) -> None:
        if 2 * self.flange > self.height:
            raise ValueError(
                f"two flanges are at most as high as the I: expected flange <= {self.height / 2:g} m, "
                f"found {self.flange:g} m"
            )
        if self.web > self.width:
            raise ValueError(f"the web is at most as wide as the I: expected <= {self.width:g} m, found {self.web:g} m")

    @property
    def area(self) -> float:
        """Two flanges and the web (m^2)."""
        return 2 * self.width * self.flange + self.web * (self.height - 2 * self.flange)

    @property
    def inertia(self) -> float:
        """The whole rectangle less the two empty ones (m^4)."""
        empty = (self.width - self.web) * (self.height - 2 * self.flange) ** 3
        return (self.width * self.height**3 - empty) / 12

    @property
    def inertia_across(self) -> float:
        """Of the two flanges and the web (m^4)."""
        return (2 * self.flange * self.width**3 + (self.height - 2 * self.flange) * self.web**3) / 12

    @property
    def fibre(self) -> float:
        """Half the height (m)."""
        return self.height / 2

    def cowper(self, poisson: float) -> float:
        """Of an I with thin walls, its flanges joining the web in their middles."""
        height = self.height - self.flange
        n = self.width / height
        m = 2 * n * self.flange / self.web
        by_poisson = 11 + 66 * m + 135 * m**2 + 90 * m**3 + 5 * n**2 * (8 * m + 9 * m**2)
        rest = 12 + 72 * m + 150 * m**2 + 90 * m**3 + 30 * n**2 * (m + m**2)
        return 10 * (1 + poisson) * (1 + 3 * m) ** 2 / (rest + poisson * by_poisson)

    def moment_over_breadth(self, y: Array) -> Array:
        """Of the flanges, and in the web of both: the shear stress jumps where they join."""
        top, joint = self.height / 2, self.height / 2 - self.flange
        of_flange = self.width * (top**2 - np.maximum(np.abs(y), joint) ** 2) / 2
        of_web = self.web * np.maximum(joint**2 - y**2, 0.0) / 2
        return np.asarray((of_flange + of_web) / np.where(np.abs(y) < joint, self.web, self.width))
