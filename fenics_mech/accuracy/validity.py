"""How far an answer may be trusted: axial forces against the Euler load, bow against length, rotations."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ValidityLimits:
    """How far the theories hold."""

    euler_ratio: float = 0.05  # beyond it the axial force changes the bending by more than about as much
    bow: float = 0.02  # of the length; beyond it bending shortens a member noticeably
    rotation: float = 1.3  # rad; there 8 elements give a cantilever's tip to 1e-4, and at 90 degrees the strain ends
    farthest: float = 1.0  # rad, or of the length; a cantilever's end at 1 rad in linear theory turns by 0.78


VALIDITY = ValidityLimits()
