"""Sections that vary along the member: numbers as functions of the place s (0 to 1), or a taper between two others."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, WithJsonSchema

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.scene.base import Name, check_known
from fenics_mech.scene.formulas.expression import FUNCTIONS, Formula
from fenics_mech.scene.formulas.interval import unbounded_at
from fenics_mech.scene.sections.plain import PlainSection, ShearFactor, of_one_material
from fenics_mech.scene.sections.rigidity import Rigidity, Section, Stock, stated_factor
from fenics_mech.scene.units import in_unit

CHECKED_PLACES = np.linspace(0, 1, 1001)  # places at which values must be positive


def _read(unit: str) -> Callable[[Any], Any]:
    """Give the validator of a profile: a formula of s in SI, a quantity, or equally spaced quantities."""
    convert = in_unit(unit)

    def read(value: Any) -> Any:
        if isinstance(value, list | tuple):
            if len(value) < 2:
                raise ValueError(f"a table has at least two values, at the member's ends, found {len(value)}")
            return tuple(convert(entry) for entry in value)
        if not isinstance(value, str):
            return convert(value)
        try:
            Formula(value, ("s",))
        except ValueError as no_formula:
            try:
                return convert(value)
            except ValueError as no_quantity:
                raise ValueError(f"as a formula: {no_formula}; as a quantity: {no_quantity}") from None
        return value

    return read


def _positive(profile: Any) -> Any:
    with np.errstate(all="ignore"):
        values = _values_along(profile, CHECKED_PLACES)
    bad = ~(np.isfinite(values) & (values > 0))
    if bad.any():
        i = int(np.argmax(bad))
        raise ValueError(
            f"it must be positive everywhere along the member, and is {values[i]:.6g} at s = {CHECKED_PLACES[i]:g}"
        )
    if isinstance(profile, str) and (where := unbounded_at(Formula(profile, ("s",)), 0.0, 1.0, above=0.0)) is not None:
        raise ValueError(
            f"it must be positive and finite everywhere along the member, and cannot be shown to be at s = {where:.6g}"
        )
    return profile


def _profile(unit: str) -> Any:
    kinds = [{"type": "number"}, {"type": "string"}, {"type": "array", "items": {"type": ["number", "string"]}}]
    text = f"{unit}: a number, a quantity, a formula of s (0 to 1 along the member) in SI, or equally spaced values"
    schema = WithJsonSchema({"anyOf": kinds, "description": text})
    return Annotated[float | str | tuple[float, ...], BeforeValidator(_read(unit)), AfterValidator(_positive), schema]


def _values_along(profile: float | str | tuple[float, ...], s: Array) -> Array:
    """Values of a profile at places, ``(places,)``; tables by monotone cubics (Fritsch and Butland, 1984)."""
    if isinstance(profile, tuple):
        from scipy.interpolate import PchipInterpolator  # noqa: PLC0415  (slow to import, and few sections have tables)

        return np.asarray(PchipInterpolator(np.linspace(0, 1, len(profile)), profile)(s))
    if isinstance(profile, str):
        return np.broadcast_to(Formula(profile, ("s",))(FUNCTIONS, s=s), s.shape)
    return np.full_like(s, profile)


class VariableSection(Section):
    """A section of one material whose numbers vary along the member.

    Each is one value, a formula or a list of values. A formula in SI units has the variable s, 0 at the member's first
    point and 1 at its second. Values of a list are equally spaced from end to end, and joined by monotone cubics.

    Parameters
    ----------
    area
        A (m^2).
    inertia
        I about the neutral line (m^4).
    fibre
        Distance from the neutral line to the outer fibres (m), the same on both sides.
    shear_factor
        Share of the area that carries shear; it has no default.

    Examples
    --------
    >>> waist = fm.VariableSection(area="1e-4 - 6e-5 * s * (1 - s)", inertia=["90 mm^4", "60 mm^4"], fibre="2 mm")
    >>> waist.area
    '1e-4 - 6e-5 * s * (1 - s)'
    """

    constant = False
    shape: Literal["variable"] = "variable"
    area: _profile("m**2")  # type: ignore[valid-type]
    inertia: _profile("m**4")  # type: ignore[valid-type]
    fibre: _profile("m")  # type: ignore[valid-type]
    shear_factor: ShearFactor | None = None

    def rigidity(self, s: Array, stock: Stock) -> Rigidity:
        """EA, EI, rho A, rho I and fibres at every place, as `Section.rigidity` says."""
        area, inertia, fibre = (_values_along(profile, s) for profile in (self.area, self.inertia, self.fibre))
        return of_one_material(s, stock.only, area, inertia, fibre)

    def shear_stiffness(self, s: Array, stock: Stock, place: str) -> Array:
        """Give G times the shear factor times A at every place, as `Section.shear_stiffness` says."""
        modulus, factor = stock.only.rigidity, stated_factor(self.shear_factor, place)
        return modulus * factor * _values_along(self.area, s)


class TaperSection(Section):
    """A section whose dimensions run linearly from those of one section to those of another of the same shape.

    Parameters
    ----------
    from_, to
        Names of the sections at the member's first and second point ("from" and "to" in a scene file).

    Examples
    --------
    >>> fm.TaperSection(from_="root", to="tip").to
    'tip'
    """

    model_config = ConfigDict(populate_by_name=True)
    constant = False
    shape: Literal["taper"] = "taper"
    from_: Annotated[Name, Field(alias="from")]
    to: Name

    def rigidity(self, s: Array, stock: Stock) -> Rigidity:
        """Rigidity of the shape with the dimensions at every place, as `Section.rigidity` says."""
        return self.along(s, stock.sections).rigidity(s, stock)

    def bending_across(self, s: Array, stock: Stock) -> Array | None:
        """EI across the plane of the shape with the dimensions at every place."""
        return self.along(s, stock.sections).bending_across(s, stock)

    def shear_stiffness(self, s: Array, stock: Stock, place: str) -> Array:
        """G A_s of the shape with the dimensions at every place; errors name the first of the two sections."""
        return self.along(s, stock.sections).shear_stiffness(s, stock, f"sections.{self.from_}")

    def along(self, s: Array, sections: Mapping[str, Section]) -> Section:
        """Give the section with its dimensions as arrays over places, 0..1, ``(places,)``."""
        first, second = (sections[name].model_dump(exclude={"shape"}) for name in (self.from_, self.to))
        here = {name: value + (second[name] - value) * s for name, value in first.items() if value is not None}
        return sections[self.from_].model_copy(update=here)

    def check(self, place: str, stock: Stock) -> None:
        """Raise `SceneError` unless the two sections are there and of one plain shape."""
        for key, name in (("from", self.from_), ("to", self.to)):
            check_known(name, stock.sections, "section", f"{place}.{key}")
        first, second = stock.sections[self.from_], stock.sections[self.to]
        if not isinstance(first, PlainSection) or type(first) is not type(second):
            what = f"it goes from {self.from_!r} to {self.to!r}, which are no two sections of one shape with dimensions"
            hint = "A taper joins two plain sections of one shape, such as two rectangles"
            raise SceneError(what, place=place, hint=hint)
        if (first.shear_factor is None) != (second.shear_factor is None):
            raise SceneError("only one of its two sections states a shear factor", place=place, hint="Give it to both")
