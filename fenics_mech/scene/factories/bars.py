"""Links that are one straight member each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def bars(
    names: Sequence[str], ends: Sequence[str], lengths: Sequence[float], angles: Sequence[float]
) -> dict[str, Any]:
    """Give bars by name, with ends "OA", lengths (m) and rough angles (rad): each has the section of its name."""
    return {
        name: {
            "points": {points[0]: (0.0, 0.0), points[1]: (length, 0.0)},
            "members": {points: {"ends": tuple(points), "section": name, "material": "material"}},
            "angle": angle,
        }
        for name, points, length, angle in zip(names, ends, lengths, angles)
    }
