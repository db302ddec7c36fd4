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
    """Stiffness, mass and outer fibres at places along a member."""

    axial: Array  # EA (N), ``(places,)``, and so are the next three
    bending: Array  # EI about the neutral line (N m^2)
    line_density: Array  # rho A (kg/m)
    rotary_inertia: Array  # rho I about the neutral line (kg m)
    modulus: Array  # Young's modulus of the outer fibres, that on the side of the normal first (Pa), ``(places, 2)``
    fibre: Array  # their places from the neutral line (m), ``(places, 2)``: the second is negative
    neutral: Array  # place of the neutral line from the member's axis (m), ``(places,)``
    mass_centre: Array  # place of the centre of mass from the member's axis (m), ``(places,)``

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
        """Make one at places `s` from values in the order of the fields, which may be the same at all places."""
        along = (np.broadcast_to(value, s.shape) for value in (ea, ei, rho_a, rho_i))
        outer = (np.stack([np.broadcast_to(v, s.shape) for v in pair], axis=-1) for pair in (modulus, fibre))
        lines = (np.full(s.shape, value) for value in (neutral, mass_centre))
        return cls(*along, *outer, *lines)

    def moved(self, offset: float) -> Rigidity:
        """Give the same section farther along the normal (m)."""
        if not offset:
            return self
        return replace(self, neutral=self.neutral + offset, mass_centre=self.mass_centre + offset)


@dataclass(frozen=True)
class Stock:
    """What a member's section draws on."""

    material: Material | None  # its own, if it names one
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
        """Give the rigidity of a member with this section at places ``(places,)``, 0..1 along it."""

    @abstractmethod
    def shear_stiffness(self, s: Array, stock: Stock, place: str) -> Array:
        """Give G A_s (N), ``(places,)``: shear force over mean shear angle; an error at `place` without it."""

    def bending_across(self, s: Array, stock: Stock) -> Array | None:
        """Give EI across the plane of motion (N m^2), ``(places,)``; None where the section does not say it."""
        return None

    def check(self, place: str, stock: Stock) -> None:
        """Raise `SceneError`, with `place`, where it names something that the scene does not have."""


def lines_from(axis: float, neutral: float, mass_centre: float, height: float) -> tuple[float, float]:
    """Give neutral line and centre of mass from the member's axis (m); distances that rounding makes are 0."""
    neutral = axis if abs(neutral - axis) < SECTION.same_line * height else neutral
    mass_centre = neutral if abs(mass_centre - neutral) < SECTION.same_line * height else mass_centre
    return neutral - axis, mass_centre - axis


def stated_factor(factor: float | None, place: str) -> float:
    """Give a section's shear factor; raise `SceneError` where it is not stated."""
    if factor is None:
        what = "shear needs this section's shear factor, which does not follow from what it states"
        hint = "Give the share of the area that carries shear, as in 5/6 for a rectangle"
        raise SceneError(what, place=f"{place}.shear_factor", hint=hint)
    return factor
