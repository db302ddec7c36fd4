"""The state from which a motion in time starts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.scene.models import Scene


@dataclass(frozen=True)
class StartState:
    """State from which a motion in time starts.

    Parameters
    ----------
    time
        Time (s).
    displacement, velocity
        q (m, rad) and q' (m/s, rad/s) there, ``(coordinates,)`` each.
    links
        Coordinates of the links there (m, m, rad), ``(3 links,)``; None at time 0, where the scene states them.
    """

    time: float
    displacement: Array
    velocity: Array
    links: Array | None = None

    @classmethod
    def stated(cls, scene: Scene) -> StartState:
        """Give the state at time 0: angles, strokes and rates that the freedoms of a scene state.

        Parameters
        ----------
        scene
            The scene, with a freedom for all that can move.
        """
        names, freedoms = ("start", "rate_at_start"), scene.freedoms.values()
        place, rate = (np.array([getattr(part, name) or 0.0 for part in freedoms]) for name in names)
        return cls(0.0, place, rate)
