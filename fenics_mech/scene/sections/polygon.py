"""Sections of any shape, of one or more materials, by the package sectionproperties."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Field

from fenics_mech._arrays import Array
from fenics_mech.scene.base import Name, Part, check_known
from fenics_mech.scene.sections.plain import ShearFactor
from fenics_mech.scene.sections.rigidity import SECTION, Rigidity, Section, Stock, lines_from, stated_factor
from fenics_mech.scene.units import Length

if TYPE_CHECKING:
    from fenics_mech.scene.bodies import Material

Outline = Annotated[tuple[tuple[Length, Length], ...], Field(min_length=3)]


class PolygonPart(Part):
    """A polygon of a composite section.

    Parameters
    ----------
    outline
        Its corners (y, z) (m).
    holes
        Corners of each hole in it (m).
    material
        Name of its material.

    Examples
    --------
    >>> square = (("0 mm", "0 mm"), ("4 mm", "0 mm"), ("4 mm", "4 mm"), ("0 mm", "4 mm"))
    >>> fm.PolygonPart(outline=square, material="steel").holes
    ()
    """

    outline: Outline
    holes: tuple[Outline, ...] = ()
    material: Name


class PolygonSection(Section):
    """A section with straight sides, given by its corners (y, z) (m): y along the member's normal, z out of the plane.

    It bends in the plane of motion only, whatever its principal axes: a planar linkage holds it there. It bends about
    its neutral line, which for several materials is that of the stiffness-weighted area, beside the centre of mass.

    Parameters
    ----------
    outline
        Corners of a section of the member's material.
    holes
        Corners of each hole in it.
    parts
        Instead of the two: the polygons of a composite section, each with its material; they share sides, no area.
    shear_factor
        Share of the sum of G A over the polygons that carries shear; it has no default.
    axis
        Where the member's axis, with its pins, welds and loads, passes the section. It is the "neutral" line, the
        "middle" between the outer fibres, or the "origin", y = 0.

    Examples
    --------
    >>> triangle = (("0 mm", "-5 mm"), ("0 mm", "5 mm"), ("6 mm", "0 mm"))
    >>> fm.PolygonSection(outline=triangle).axis
    'neutral'
    """

    shape: Literal["polygon"] = "polygon"
    outline: Outline | None = None
    holes: tuple[Outline, ...] = ()
    parts: tuple[PolygonPart, ...] = ()
    shear_factor: ShearFactor | None = None
    axis: Literal["neutral", "middle", "origin"] = "neutral"

    def _check_keys(self) -> None:
        if bool(self.parts) == (self.outline is not None) or (self.parts and self.holes):
            raise ValueError("a polygon has either an outline, with holes, or parts")
        shapes = [_polygon(part.outline or (), part.holes) for part in self.parts or (self,)]
        for i, shape in enumerate(shapes):
            if any(shape.intersection(o).area > SECTION.touching * min(shape.area, o.area) for o in shapes[:i]):
                raise ValueError(f"part {i} lies over another part; parts may share sides only")

    def _polygons(self, stock: Stock) -> list[tuple[Outline, tuple[Outline, ...], Any]]:
        """Outline, holes and material of each polygon."""
        if self.outline is not None:
            return [(self.outline, self.holes, stock.material)]
        return [(part.outline, part.holes, stock.materials[part.material]) for part in self.parts]

    @property
    def complete(self) -> bool:  # type: ignore[override]
        """Whether all materials are named."""
        return bool(self.parts)

    def rigidity(self, s: Array, stock: Stock) -> Rigidity:
        """Let sectionproperties integrate over the polygons, as `Section.rigidity` says."""
        polygons = self._polygons(stock)
        corners = [(y, of.modulus) for outline, _, of in polygons for y, _ in outline]
        (top, e_top), (bottom, e_bottom) = max(corners), min(corners, key=lambda corner: (corner[0], -corner[1]))
        ea, ei, rho_a, neutral = _integrals(polygons, max(abs(top), abs(bottom)))
        first, rho_i = sum(of.density * _moments(outline, holes, neutral) for outline, holes, of in polygons)
        axis = {"neutral": neutral, "middle": (top + bottom) / 2, "origin": 0.0}[self.axis]
        lines = lines_from(axis, neutral, neutral + first / rho_a, top - bottom)
        return Rigidity.at(s, ea, ei, rho_a, rho_i, (e_top, e_bottom), (top - neutral, bottom - neutral), *lines)

    def bending_across(self, s: Array, stock: Stock) -> Array:
        """EI about the line in the plane through the stiffness-weighted middle, as `Section.bending_across` says."""
        turned = [(_across(outline), tuple(map(_across, holes)), of) for outline, holes, of in self._polygons(stock)]
        areas = [_polygon(outline, holes).area for outline, holes, _ in turned]
        first = sum(of.modulus * _moments(outline, holes, 0.0)[0] for outline, holes, of in turned)
        middle = first / sum(of.modulus * area for area, (_, _, of) in zip(areas, turned))
        ei = sum(of.modulus * _moments(outline, holes, middle)[1] for outline, holes, of in turned)
        return np.full_like(s, ei)

    def shear_stiffness(self, s: Array, stock: Stock, place: str) -> Array:
        """Give the shear factor times the sum of G A, as `Section.shear_stiffness` says."""
        factor, polygons = stated_factor(self.shear_factor, place), self._polygons(stock)
        whole = sum(of.rigidity * _polygon(outline, holes).area for outline, holes, of in polygons)
        return np.full_like(s, factor * whole)

    def check(self, place: str, stock: Stock) -> None:
        """Raise `SceneError` where a part's material is not there."""
        for i, part in enumerate(self.parts):
            check_known(part.material, stock.materials, "material", f"{place}.parts.{i}.material")


def _integrals(
    polygons: list[tuple[Outline, tuple[Outline, ...], Material]], size: float
) -> tuple[float, float, float, float]:
    """EA, EI, rho A and the neutral line's y of polygons with their materials; sizes are scaled to about 1 for it."""
    from sectionproperties.analysis import Section as Analysis  # noqa: PLC0415  (an extra; `_polygon` has found it)
    from sectionproperties.pre import CompoundGeometry, Geometry  # noqa: PLC0415
    from sectionproperties.pre import Material as Stuff  # noqa: PLC0415

    parts = []
    for outline, holes, of in polygons:
        stuff = Stuff("", of.modulus, poissons_ratio=0, yield_strength=1, density=of.density, color="w")
        parts.append(Geometry(_polygon(outline, holes, 1 / size), material=stuff))
    whole = CompoundGeometry(parts) if len(parts) > 1 else parts[0]
    analysis = Analysis(whole.create_mesh([part.calculate_area() / SECTION.elements for part in parts]))
    analysis.calculate_geometric_properties()
    ei = analysis.get_eic()[1]  # its x is our y
    return analysis.get_ea() * size**2, ei * size**4, analysis.get_mass() * size**2, analysis.get_c()[0] * size


def _across(outline: Outline) -> Outline:
    """Corners (z, y) of a section that is turned by a quarter about the member's axis, and mirrored."""
    return tuple((z, y) for y, z in outline)


def _moments(outline: Outline, holes: tuple[Outline, ...], neutral: float) -> Array:
    """First (m^3) and second (m^4) moment of area of a polygon about y = neutral, by Green's theorem, ``(2,)``."""

    def around(corners: Outline) -> Array:
        (y, z), (y2, z2) = (np.roll(corners, -k, axis=0).T for k in (0, 1))
        a, b = y - neutral, y2 - neutral
        twice_area = a * z2 - b * z
        both = np.array([np.sum((a + b) * twice_area) / 6, np.sum((a**2 + a * b + b**2) * twice_area) / 12])
        return both * np.sign(np.sum(twice_area))

    return around(outline) - sum(around(hole) for hole in holes)


def _polygon(outline: Outline, holes: tuple[Outline, ...], scale: float = 1.0) -> Any:
    """Make shapely's polygon, scaled; `ValueError` where it is none, or shapely is not installed."""
    try:
        import sectionproperties.pre  # noqa: F401, PLC0415  (an extra, and slow to import)
        from shapely import Polygon, is_valid_reason  # noqa: PLC0415
    except ImportError as error:
        raise ValueError("a polygon needs sectionproperties: pip install 'fenics_mech[sections]'") from error
    polygon = Polygon(np.multiply(outline, scale), [np.multiply(hole, scale) for hole in holes])
    if not polygon.is_valid:
        raise ValueError(f"the corners make no polygon, found: {is_valid_reason(polygon)}")
    return polygon
