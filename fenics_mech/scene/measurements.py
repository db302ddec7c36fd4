"""Measured strains."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from fenics_mech.scene.base import Part


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
