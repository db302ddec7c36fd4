"""Steps of a cycle: equal ones, cut in two where an impulse acts inside."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_mech.scene import Scene

Array = NDArray[np.float64]
CYCLE = 2 * math.pi
SAME = 1e-9  # rad, between drive angles that count as one


@dataclass(frozen=True)
class Steps:
    """Steps of a cycle, in the order of time; arrays of shape ``(steps,)``.

    Parameters
    ----------
    start
        Drive angle (rad) at which each begins.
    duration
        How long it takes (s).
    regular
        Whether it begins where one of the equal steps does.
    struck
        The step at whose start each impulse of the scene acts, ``(impulses,)``.
    """

    start: Array
    duration: Array
    regular: NDArray[np.bool_]
    struck: NDArray[np.int64]

    @classmethod
    def of(cls, scene: Scene) -> Steps:
        """Cut the cycle of a scene."""
        rate = scene.cycle_rate
        equal = np.abs(scene.drive_angles(scene.analysis.sub_intervals))
        blows = np.mod(math.copysign(1, rate) * np.array([i.angle for i in scene.impulses.values()]), CYCLE)
        turned = np.unique(np.concatenate([equal, blows[_apart(blows, equal).min(axis=1) > SAME]]))
        return cls(
            start=math.copysign(1, rate) * turned,
            duration=np.diff(turned, append=CYCLE) / abs(rate),
            regular=np.isin(turned, equal),
            struck=_apart(blows, turned).argmin(axis=1),
        )

    def angles(self, places: Array, rate: float) -> Array:
        """Drive angles (rad) at places 0..1 in every step, ``(steps x places,)``; rate is the drive's (rad/s)."""
        return (self.start[:, None] + rate * self.duration[:, None] * places).ravel()


def _apart(turned: Array, others: Array) -> Array:
    """Differences of angles around the cycle, ``(angles, others)``."""
    return np.abs(np.mod(turned[:, None] - others + math.pi, CYCLE) - math.pi)
