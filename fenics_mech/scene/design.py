"""What a designer wants of a machine, and what its strength depends on beside sections: notches, pins, deflections."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, WithJsonSchema

from fenics_mech.errors import shortened
from fenics_mech.scene.base import Part
from fenics_mech.scene.units import Length, Modulus, PressureTimesSpeed, Share, in_unit

Positive = Field(gt=0)
Surface = Literal["ground", "machined", "hot-rolled", "as-forged"]
Across = Literal["pinned", "clamped"]
OF_LENGTH = re.compile(r"L\s*/\s*(\d+\.?\d*)")


class Notch(Part):
    """A place of a member where its stress is raised: a hole, a fillet, a weld.

    Parameters
    ----------
    at
        Place along the member, 0 to 1.
    kf
        Fatigue notch factor: stress that counts in fatigue over that of the beam.

    Examples
    --------
    >>> fm.Notch(at=0.3, kf=1.8).kf
    1.8
    """

    at: Annotated[float, Field(ge=0, le=1)]
    kf: Annotated[float, Field(ge=1)]


class Pin(Part):
    """A pin and the round eyes that it goes through.

    Parameters
    ----------
    diameter
        Diameter of the pin (m), and of the holes.
    eye
        Outer diameter of the eyes, or width of the bars there (m).
    thickness
        Thickness of one eye along the pin (m).
    bush
        Largest mean pressure that the bush bears (Pa), if there is one.
    bush_pv
        Largest pressure times sliding speed that the bush bears, as the mean over the cycle (Pa m/s).

    Examples
    --------
    >>> fm.Pin(diameter="10 mm", eye="24 mm", thickness="8 mm", bush="25 MPa").eye
    0.024
    """

    diameter: Annotated[Length, Positive]
    eye: Annotated[Length, Positive]
    thickness: Annotated[Length, Positive]
    bush: Annotated[Modulus, Positive] | None = None
    bush_pv: Annotated[PressureTimesSpeed, Positive] | None = None

    def _check_keys(self) -> None:
        if self.eye <= self.diameter:
            raise ValueError(f"an eye is wider than its pin: expected eye > {self.diameter:g} m, found {self.eye:g} m")


def _read_deflection(value: Any) -> Any:
    """Read a length, or a share of the member's length as "L/200"; it is kept as it is stated."""
    if isinstance(value, str) and (share := OF_LENGTH.fullmatch(value.strip())):
        if not float(share[1]):
            raise ValueError(f'must be a length, or a part of the member\'s as "L/200", found {shortened(value)}')
        return f"L/{share[1]}"
    try:
        length = in_unit("m")(value)
    except ValueError as error:
        raise ValueError(f'{error}, or a part of the member\'s length as "L/200"') from None
    if not length > 0:
        raise ValueError(f"must be greater than 0, found {shortened(value)}")
    return length


Deflection = Annotated[
    float | str,
    BeforeValidator(_read_deflection),
    WithJsonSchema(
        {"anyOf": [{"type": "number"}, {"type": "string"}], "description": 'm, or a string with a unit, or "L/200"'}
    ),
]
Wanted = dict[Literal["yield", "buckling", "fatigue", "pin", "resonance"], Annotated[Share, Positive]]


class Design(Part):
    """What is wanted of the machine, by which the verdict calls it safe or not.

    Parameters
    ----------
    safety
        Wanted factors of safety. Without them yield and fatigue have 1.5, buckling (in the plane, across it and
        lateral-torsional) 3 and pins 2. `resonance` is the wanted distance of the speed from a critical speed, 10 %.
    deflection
        Largest elastic deflection of a member: a length, or a part of the member's length as "L/200". Without it that
        is taken, and does not decide.
    cycles
        Cycles of the machine that its members are to last, by default 5e8. They count where a material states a
        stress-life curve.

    Examples
    --------
    >>> fm.Design(safety={"yield": 2, "buckling": 4}, deflection="L/500").deflection
    'L/500'
    """

    safety: Wanted = Field(default_factory=dict)
    deflection: Deflection | None = None
    cycles: Annotated[float, Field(ge=1, le=1e15)] | None = None

    def allowed_deflection(self, length: float) -> float:
        """Give the largest deflection (m) of a member."""
        limit = self.deflection or "L/200"
        return limit if isinstance(limit, float) else length / float(limit[2:])
