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
        states = [(freedom.start or 0.0, freedom.rate_at_start) for freedom in scene.freedoms.values()]
        return cls(0.0, *np.array(states).reshape(-1, 2).T)
