"""The state from which a motion in time starts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.scene.models import Scene


@dataclass(frozen=True)
class StartState:
    """State from which a motion in time starts."""

    time: float  # s
    displacement: Array  # q (m, rad), ``(coordinates,)``
    velocity: Array  # q' (m/s, rad/s), ``(coordinates,)``
    links: Array | None = (
        None  # coordinates of links (m, m, rad), ``(3 links,)``; None at time 0, where the scene has them
    )

    @classmethod
    def stated(cls, scene: Scene) -> StartState:
        """Give the state at time 0: angles, strokes and rates that the freedoms of a scene state."""
        names, freedoms = ("start", "rate_at_start"), scene.freedoms.values()
        place, rate = (np.array([getattr(part, name) or 0.0 for part in freedoms]) for name in names)
        return cls(0.0, place, rate)
