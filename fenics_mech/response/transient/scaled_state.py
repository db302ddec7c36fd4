"""The equation of a free motion in coordinates of one unit, as the steps in time take it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.response.transient.free_state import FreeState


@dataclass(frozen=True)
class ScaledState:
    """The equation of a free motion for scaled coordinates ``z = weight y``, in sqrt(J)."""

    state: FreeState
    weight: Array

    @property
    def linear(self) -> bool:
        """A free motion is never linear."""
        return False

    def residuals(self, time: Array, z: Array, rate: Array, second: Array) -> Array:
        """What is left of the equation, ``(times, coordinates)``."""
        return self.state.residual(time, (z / self.weight, rate / self.weight, second / self.weight)) / self.weight

    def tangents_at(self, time: Array, z: Array, rate: Array, second: Array) -> tuple[Array, Array, Array]:
        """Tangents by z'', z' and z, ``(times, coordinates, coordinates)`` each."""
        found = self.state.tangents(time, (z / self.weight, rate / self.weight, second / self.weight))
        square = np.outer(self.weight, self.weight)
        return found[0] / square, found[1] / square, found[2] / square

    def hold(self, time: Array, z: Array, rate: Array) -> float:
        """Hold friction, as `FreeState.hold`."""
        return self.state.hold(time, z / self.weight, rate / self.weight)

    def let_go(self) -> None:
        """Let it go again."""
        self.state.let_go()

    def accelerations(self, time: Array, z: Array, rate: Array) -> Array:
        """Give z'' that the equation demands, ``(times, coordinates)``."""
        return self.state.accelerations(time, z / self.weight, rate / self.weight) * self.weight
