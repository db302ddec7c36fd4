"""How a scene states damping: of the modes, of the material, and by the surroundings."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, Discriminator, Field, Tag

from fenics_mech.scene.base import Part
from fenics_mech.scene.units import Density, Length, Rate, Share, Time


def _below_critical(ratio: float) -> float:
    if ratio >= 1:
        raise ValueError(
            f'must be less than 1, which is critical damping, found {ratio:g}: write "{ratio:g} %" for percent'
        )
    return ratio


Ratio = Annotated[Share, Field(ge=0), AfterValidator(_below_critical)]
Ratios = Annotated[
    Annotated[Ratio, Tag("one")] | Annotated[tuple[Ratio, ...], Field(min_length=1), Tag("many")],
    Discriminator(lambda value: "many" if isinstance(value, list | tuple) else "one"),
]


class AirDrag(Part):
    """Drag of air, or another fluid, on the members of the links, by the square of their velocity.

    Parameters
    ----------
    density
        Density of the fluid (kg/m^3).
    coefficient
        Drag coefficient of the members in cross flow.
    width
        Width of the members across the plane (m); without it that of their sections, a round's being its diameter.

    Examples
    --------
    >>> fm.Damping(air=fm.AirDrag(density=1.2, coefficient=2.0)).air.density
    1.2
    """

    density: Annotated[Density, Field(gt=0)]
    coefficient: Annotated[float, Field(gt=0)]
    width: Annotated[Length, Field(gt=0)] | None = None


class Damping(Part):
    """Damping of the elastic motion; what is stated adds up.

    Parameters
    ----------
    ratio
        Modal damping (E.12): one ratio for all modes, or one per mode (the last holds for the rest). Its forces are a
        viscous stress in the links.
    material
        Retardation time of the material (s): its stress is E times the strain plus this times the strain's rate.
    external
        Drag of the surroundings on the absolute velocity, the rigid motion's too, in proportion to the mass (1/s).
    relative
        The same on the velocity relative to the links' own axes: the surroundings turn with each link (1/s).
    air
        Drag by the square of the absolute velocity across the members.

    Examples
    --------
    >>> fm.Damping(ratio="2 %").ratio
    0.02
    """

    ratio: Ratios = 0.0
    material: Annotated[Time, Field(ge=0)] = 0.0
    external: Annotated[Rate, Field(ge=0)] = 0.0
    relative: Annotated[Rate, Field(ge=0)] = 0.0
    air: AirDrag | None = None
