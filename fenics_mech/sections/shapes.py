"""Area, two second moments, torsion constant and corners of a section, by its shape."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.scene.in_space import SpatialCustomSection
from fenics_mech.scene.sections.plain import ISection, RectangleSection, RoundSection, TubeSection
from fenics_mech.sections.torsion import polygon_numbers

if TYPE_CHECKING:
    from fenics_mech.scene.in_space import SpatialSection

OPEN = 0.02  # torsion constant over the polar second moment: a closed thin wall has 0.1 at least
ROUND = 24  # corners by which a round outline is known: stresses 0.9 % low at most between two of them
ODD = np.arange(1, 60, 2)  # terms of the torsion series: rounding is left after 20


@dataclass(frozen=True)
class SectionNumbers:
    """What a beam in space needs of its section.

    Parameters
    ----------
    area
        A (m^2).
    inertia
        Second moments of area (m^4): of bending along the first, and along the second principal axis.
    torsion
        Torsion constant J (m^4): torque over the shear modulus and the twist per length.
    corners
        Places along both principal axes at which the normal stress is told ``(corners, 2)`` (m).
    torsion_modulus
        Torque over the largest shear stress (m^3); None where none is known.
    turn
        Angle from the member's `up` to the first principal axis (rad).
    shear_centre
        Where a force across bends without twist, from the centroid along both principal axes ``(2,)`` (m).
    """

    area: float
    inertia: tuple[float, float]
    torsion: float
    corners: Array
    torsion_modulus: float | None = None
    turn: float = 0.0
    shear_centre: tuple[float, float] = (0.0, 0.0)

    @property
    def reach(self) -> float:
        """Largest distance of a corner from the centroid (m)."""
        return float(np.linalg.norm(self.corners, axis=1).max())


def numbers_of(section: SpatialSection) -> SectionNumbers:
    """Give the numbers of a section of a scene in space.

    Parameters
    ----------
    section
        The section.

    Raises
    ------
    SceneError
        When the corners of a polygon make none.

    Examples
    --------
    >>> from fenics_mech.sections import numbers_of
    >>> square = numbers_of(fm.RectangleSection(width=1.0, height=1.0))
    >>> round(square.torsion, 6), round(square.torsion_modulus, 4)
    (0.140577, 0.2082)
    """
    if isinstance(section, RectangleSection):
        return _rectangle(section.height, section.width)
    if isinstance(section, RoundSection | TubeSection):
        return _round(section)
    if isinstance(section, ISection):
        return _thin_walls(section)
    if section.shape == "polygon":
        return SectionNumbers(*polygon_numbers(section.outline, section.holes))
    corners = np.array(_signs()) * section.fibre
    return SectionNumbers(section.area, section.inertia, section.torsion, corners, section.torsion_modulus)


def _signs() -> list[tuple[int, int]]:
    return [(1, 1), (1, -1), (-1, -1), (-1, 1)]


def _rectangle(height: float, width: float) -> SectionNumbers:
    """Saint-Venant's series: Timoshenko and Goodier, Theory of Elasticity, section 109."""
    long, short = max(height, width), min(height, width)
    way = ODD * np.pi * long / (2 * short)
    torsion = long * short**3 * (1 / 3 - 64 / np.pi**5 * short / long * np.sum(np.tanh(way) / ODD**5))
    steepest = short * (1 - 8 / np.pi**2 * np.sum(1 / (ODD**2 * np.cosh(np.minimum(way, 700.0)))))
    return SectionNumbers(
        area=height * width,
        inertia=(width * height**3 / 12, height * width**3 / 12),
        torsion=float(torsion),
        corners=np.array(_signs()) * [height / 2, width / 2],
        torsion_modulus=float(torsion / steepest),
    )


def _round(section: RoundSection | TubeSection) -> SectionNumbers:
    """Of a circle or a ring the torsion constant is the polar second moment."""
    radius, angle = section.diameter / 2, 2 * np.pi * np.arange(ROUND) / ROUND
    return SectionNumbers(
        area=section.area,
        inertia=(section.inertia, section.inertia),
        torsion=2 * section.inertia,
        corners=radius * np.stack([np.cos(angle), np.sin(angle)], axis=1),
        torsion_modulus=2 * section.inertia / radius,
    )


def _thin_walls(section: ISection) -> SectionNumbers:
    """Give those of an open section: J is the sum of b t^3/3 over its walls."""
    web = section.height - section.flange
    torsion = (2 * section.width * section.flange**3 + web * section.web**3) / 3
    return SectionNumbers(
        area=section.area,
        inertia=(section.inertia, section.inertia_across),
        torsion=torsion,
        corners=np.array(_signs()) * [section.height / 2, section.width / 2],
        torsion_modulus=torsion / max(section.flange, section.web),
    )


def open_and_thin(section: SpatialSection) -> bool:
    """Say whether a section is open and has thin walls: its ends hold torsion by warping, which is not computed.

    Parameters
    ----------
    section
        The section.
    """
    if isinstance(section, ISection):
        return True
    return section.shape == "custom" and section.torsion < OPEN * sum(section.inertia)


def from_sectionproperties(analysed: Any) -> SpatialCustomSection:
    """Take the numbers of a section that the package sectionproperties has analysed; its y is along `up`.

    Parameters
    ----------
    analysed
        A `sectionproperties.analysis.Section` of one material, with geometric and warping properties, in m.

    Raises
    ------
    SceneError
        When its axes are no principal ones: turn it first.

    Examples
    --------
    >>> from sectionproperties.analysis import Section
    >>> from sectionproperties.pre.library import rectangular_section
    >>> made = Section(rectangular_section(d=0.02, b=0.01).create_mesh([2e-7]))
    >>> made.calculate_geometric_properties()
    >>> made.calculate_warping_properties()
    >>> round(1e9 * fm.from_sectionproperties(made).torsion, 1)
    4.6
    """
    (along, across, both), centre = analysed.get_ic(), analysed.get_c()
    if abs(both) > 1e-6 * (along + across):
        raise SceneError(
            f"the axes of the section are no principal ones, its product of inertia is {both:.4g} m^4",
            place="sections",
            hint="Turn the geometry by get_phi() first",
        )
    points = np.asarray(analysed.mesh["vertices"]) - centre
    return SpatialCustomSection(
        area=analysed.get_area(),
        inertia=(along, across),
        torsion=analysed.get_j(),
        fibre=(float(np.abs(points[:, 1]).max()), float(np.abs(points[:, 0]).max())),
    )
