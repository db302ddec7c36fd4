"""Poincaré section that a scene asks for."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from fenics_mech.scene.base import Part
from fenics_mech.scene.units import AngleOrLength, Time


class PoincareSection(Part):
    """When the state of a motion with freedoms is kept for its Poincaré section.

    Parameters
    ----------
    every
        Once in each of these times (s), such as the period of a force. Without it and `joint`, once in each cycle of
        the drives.
    joint
        Or as often as the freedom at this joint passes a place.
    at
        That place: its angle (rad), at any whole turn, or its stroke (m).
    direction
        Whether it passes towards larger values, "+", or smaller ones, "-".

    Examples
    --------
    >>> fm.PoincareSection(every="2 s").joint is None
    True
    """

    every: Annotated[Time, Field(gt=0)] | None = None
    joint: str | None = None
    at: AngleOrLength = 0.0
    direction: Literal["+", "-"] = "+"

    @model_validator(mode="after")
    def _has_one_rule(self) -> PoincareSection:
        if self.every is not None and self.joint is not None:
            raise ValueError("the section is taken `every` so often, or where a `joint` passes a place: give one")
        return self
