"""Pulses: factors of loads that act in a part of the cycle."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.scene.base import Part
from fenics_mech.scene.units import Angle, OfTurning


def in_rad(*angles: float) -> str:
    """Recall the unit of numbers, where some angle other than 0 is one."""
    return "; without a unit they are rad" * any(a and not isinstance(a, OfTurning) for a in angles)


class Pulse(Part):
    """Acts in a part of the cycle: 1 from one angle to another in the sense of theta, 0 in the rest.

    Parameters
    ----------
    start, end
        Angles (rad) at which the factor is 1/2, on its way up and down.
    ramp
        Width (rad) of each flank, a polynomial with two continuous derivatives; 0 is a jump.

    Examples
    --------
    >>> fm.Pulse(start="30 deg", end="60 deg", ramp="5 deg").kind
    'pulse'
    """

    kind: Literal["pulse"] = "pulse"
    start: Angle
    end: Angle
    ramp: Annotated[Angle, Field(ge=0)] = 0.0

    @model_validator(mode="after")
    def _has_room(self) -> Self:
        if self.start == self.end:
            raise ValueError("the pulse starts and ends at the same angle")
        if self.ramp > min(self.width, TURN - self.width) * (1 + 1e-9):
            found = ", ".join(f"{key} {math.degrees(getattr(self, key)):.6g} deg" for key in ("start", "end", "ramp"))
            raise ValueError(
                f"the ramp is wider than the pulse, or than the pause between two of them, found {found}"
                + in_rad(self.start, self.end, self.ramp)
            )
        return self

    @property
    def width(self) -> float:
        """Part of the cycle in which the pulse acts (rad)."""
        return (self.end - self.start) % TURN or TURN

    @property
    def jumps(self) -> tuple[float, ...]:
        """Drive angles (rad) at which the value jumps."""
        return () if self.ramp else (self.start, self.end)

    @property
    def corners(self) -> tuple[float, ...]:
        """Drive angles (rad) between which the value is a polynomial."""
        return tuple(angle + side * self.ramp / 2 for angle in (self.start, self.end) for side in (-1, 1))

    def at(self, theta: Array) -> Array:
        """Values at drive angles (rad), of their shape."""
        from_middle = np.mod(theta - self.start - self.width / 2 + math.pi, TURN) - math.pi
        inside = self.width / 2 - np.abs(from_middle)
        if self.ramp == 0:
            return np.where(inside >= 0, 1.0, 0.0)
        x = np.clip(inside / self.ramp + 0.5, 0, 1)
        return x**3 * (10 - 15 * x + 6 * x**2)
