"""What a scene wants to be looked at: measured strains, and points whose path is followed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from fenics_mech.scene.applied_loads import Place
from fenics_mech.scene.base import Part
from fenics_mech.scene.units import Length


class Measurement(Part):
    """Measured strains to be drawn beside the computed ones.

    Parameters
    ----------
    file
        CSV with a header and two columns: drive angle in degrees, strain. Relative to the scene file.
    member
        "link", or "link.member" when the link has several members.
    s
        Place along the member, 0 to 1.
    fibre
        "+" (on the side of the normal) or "-".

    Examples
    --------
    >>> fm.Measurement(file="strain_coupler.csv", member="coupler").s
    0.5
    """

    file: Path
    member: str
    s: Annotated[float, Field(ge=0, le=1)] = 0.5
    fibre: Literal["+", "-"] = "+"


class TracedPoint(Part):
    """A point whose position, velocity and acceleration are followed, such as the point of a coupler curve.

    The points of the links themselves are followed in any case.

    Parameters
    ----------
    at
        Where it is fixed to a link: "link.point", or "member@0.3" for a place along a member.
    offset
        From there to the point, in the axes of the link (m); it turns with the section there.

    Examples
    --------
    >>> fm.TracedPoint(at="coupler@0.5", offset=(0, "60 mm")).offset
    (0.0, 0.06)
    """

    at: Place
    offset: tuple[Length, Length] = (0.0, 0.0)
