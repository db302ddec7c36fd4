"""What a section and its materials give a beam, and the base of all sections."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.scene.base import Part

if TYPE_CHECKING:
    from fenics_mech.scene.bodies import Material

Positive = Field(gt=0)


@dataclass(frozen=True)
class SectionLimits:
    """How exactly sections are looked at."""

    same_line: float = 1e-9  # of a section's height, up to which two lines in it are one
    elements: int = 20  # in a polygon, about: its properties are exact on any triangles
    touching: float = 1e-9  # share of the smaller area that two polygons may have in common
    places: int = 64  # in an element, at which its section is looked at
    gauss_points: int = 120  # of Gauss' rule along a member whose section varies
    fine: int = 4001  # places along a member, at least, at which its section is looked at for peaks


SECTION = SectionLimits()


@dataclass(frozen=True)
class Rigidity:
    """Stiffness, mass and outer fibres at places along a member.

    Parameters
    ----------
    axial, bending, line_density, rotary_inertia
        EA (N), EI about the neutral line (N m^2), rho A (kg/m) and rho I about the neutral line (kg m), ``(places,)``.
    modulus
        Young's modulus of the outer fibres, first on the side of the normal, then opposite (Pa), ``(places, 2)``.
    fibre
        Place of these fibres along the normal, from the neutral line (m), ``(places, 2)``: the second is negative.
    neutral, mass_centre
        Places of the neutral line and the centre of mass along the normal, from the member's axis (m), ``(places,)``.
    """

    axial: Array
    bending: Array
    line_density: Array
    rotary_inertia: Array
    modulus: Array
    fibre: Array
    neutral: Array
    mass_centre: Array

    @classmethod
    def at(
        cls,
        s: Array,
        ea: Array | float,
        ei: Array | float,
        rho_a: Array | float,
        rho_i: Array | float,
        modulus: tuple[float, float],
        fibre: tuple[Array | float, Array | float],
        neutral: float = 0.0,
        mass_centre: float = 0.0,
    ) -> Rigidity:
        """Make one at places `s` from values that may be the same at all of them.

        Parameters
        ----------
        s
            Places along the member, 0..1, ``(places,)``.
        ea, ei
            EA (N) and EI about the neutral line (N m^2), one number each or ``(places,)``.
        rho_a, rho_i
            rho A (kg/m) and rho I about the neutral line (kg m), one number each or ``(places,)``.
        modulus
            Young's modulus of the outer fibres, first on the side of the normal (Pa).
        fibre
            Their places along the normal, from the neutral line (m), one number each or ``(places,)``.
        neutral, mass_centre
            Places of the neutral line and the centre of mass along the normal, from the axis (m).
        """
        along = (np.broadcast_to(value, s.shape) for value in (ea, ei, rho_a, rho_i))
        outer = (np.stack([np.broadcast_to(v, s.shape) for v in pair], axis=-1) for pair in (modulus, fibre))
        lines = (np.full(s.shape, value) for value in (neutral, mass_centre))
        return cls(*along, *outer, *lines)

    def moved(self, offset: float) -> Rigidity:
        """Give the same section elsewhere along the normal.

        Parameters
        ----------
        offset
            How far it is moved, towards the side of the normal (m).
        """
        if not offset:
            return self
        return replace(self, neutral=self.neutral + offset, mass_centre=self.mass_centre + offset)


@dataclass(frozen=True)
class Stock:
    """What a member's section draws on.

    Parameters
    ----------
    material
        The member's own material, if it names one.
    materials, sections
        All of the scene's, by name.
    """

    material: Material | None
    materials: Mapping[str, Material]
    sections: Mapping[str, Section]

    @property
    def only(self) -> Material:
        """The member's own material, which a section of one material needs."""
        if self.material is None:
            raise ValueError("a section of one material needs the member's material")  # `check_sections` sees to it
        return self.material


class Section(Part, ABC):
    """A cross-section."""

    constant: ClassVar[bool] = True  # the same at all places along the member
    complete: ClassVar[bool] = False  # it names its own materials, so the member need not

    @abstractmethod
    def rigidity(self, s: Array, stock: Stock) -> Rigidity:
        """Give the rigidity of a member with this section.

        Parameters
        ----------
        s
            Places along the member, 0..1, shape ``(places,)``.
        stock
            What the section may name.
        """

    @abstractmethod
    def shear_stiffness(self, s: Array, stock: Stock, place: str) -> Array:
        """Give G A_s of a member with this section (N), ``(places,)``: shear force over mean shear angle.

        Parameters
        ----------
        s
            Places along the member, 0..1, shape ``(places,)``.
        stock
            What the section may name.
        place
            The section's place in the scene, for errors.

        Raises
        ------
        SceneError
            When the shear factor is not stated and does not follow from the shape.
        """

    def bending_across(self, s: Array, stock: Stock) -> Array | None:
        """Give EI across the plane of motion (N m^2), ``(places,)``; None where the section does not say it.

        Parameters
        ----------
        s
            Places along the member, 0..1, shape ``(places,)``.
        stock
            What the section may name.
        """
        return None

    def check(self, place: str, stock: Stock) -> None:
        """Raise `SceneError`, with `place`, where it names something that the scene does not have.

        Parameters
        ----------
        place
            The section's place in the scene, for the error.
        stock
            What the section may name.
        """


def lines_from(axis: float, neutral: float, mass_centre: float, height: float) -> tuple[float, float]:
    """Give the places of the neutral line and of the centre of mass, from the member's axis (m).

    The places given, and the height of the section, are in m. Distances that rounding makes are 0.

    Parameters
    ----------
    axis, neutral, mass_centre
        Heights of the member's axis, of the neutral line and of the centre of mass (m).
    height
        Height of the section (m).
    """
    neutral = axis if abs(neutral - axis) < SECTION.same_line * height else neutral
    mass_centre = neutral if abs(mass_centre - neutral) < SECTION.same_line * height else mass_centre
    return neutral - axis, mass_centre - axis


def stated_factor(factor: float | None, place: str) -> float:
    """Give a section's shear factor; raise `SceneError` where it is not stated.

    Parameters
    ----------
    factor
        The share of the area that carries shear, if it is stated.
    place
        The section's place in the scene, for the error.
    """
    if factor is None:
        raise SceneError(
            "shear needs this section's shear factor, which does not follow from what it states",
            place=f"{place}.shear_factor",
            hint="Give the share of the area that carries shear, as in 5/6 for a rectangle",
        )
    return factor
