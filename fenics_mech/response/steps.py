"""Steps of a cycle: equal ones, cut in two where an impulse acts or a load jumps inside."""

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
    jumps
        Whether a load jumps at the end of a step.
    """

    start: Array
    duration: Array
    regular: NDArray[np.bool_]
    struck: NDArray[np.int64]
    jumps: NDArray[np.bool_]

    @classmethod
    def of(cls, scene: Scene) -> Steps:
        """Cut the cycle of a scene."""
        rate = scene.cycle_rate
        equal = np.abs(scene.drive_angles(scene.analysis.sub_intervals))
        sense = math.copysign(1, rate)
        blows = np.mod(sense * np.array([i.angle for i in scene.impulses.values()]), CYCLE)
        jumps = np.mod(sense * np.array([angle for load in scene.loads.values() for angle in load.jumps]), CYCLE)
        turned = equal
        for angle in (*blows, *jumps):
            if _apart(np.array([angle]), turned).min() > SAME:
                turned = np.sort(np.append(turned, angle))
        jumping = _apart(turned, jumps).min(axis=1, initial=CYCLE) < SAME
        return cls(
            start=sense * turned,
            duration=np.diff(turned, append=CYCLE) / abs(rate),
            regular=np.isin(turned, equal),
            struck=_apart(blows, turned).argmin(axis=1),
            jumps=np.roll(jumping, -1),
        )

    @property
    def disturbed(self) -> bool:
        """Whether blows act or loads jump."""
        return bool(len(self.struck) or self.jumps.any())

    def angles(self, places: Array, rate: float) -> Array:
        """Drive angles (rad) at places 0..1 in every step, ``(steps x places,)``; rate is the drive's (rad/s).

        The end of a step at which a load jumps is taken just before the jump.
        """
        angles = self.start[:, None] + rate * self.duration[:, None] * places
        before = math.copysign(2 * SAME, rate) * (self.jumps[:, None] & (places > 1 - SAME))
        return (angles - before).ravel()


def _apart(turned: Array, others: Array) -> Array:
    """Differences of angles around the cycle, ``(angles, others)``."""
    return np.abs(np.mod(turned[:, None] - others + math.pi, CYCLE) - math.pi)
