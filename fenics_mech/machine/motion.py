"""A motion of a machine at some instants, and what is read off it there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.geometry import End
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.machine import Machine


@dataclass(frozen=True)
class Motion:
    """Coordinates of a machine at some instants, as its residual takes them.

    Parameters
    ----------
    machine
        The machine.
    t
        Instants ``(instants,)`` (s).
    q, v, a
        Coordinates, rates and accelerations ``(instants, size)``; multipliers stand in the last of `a`.
    angles
        Angles near to those of every term, as the residual takes them; None where the terms know.
    """

    machine: Machine
    t: Array
    q: Array
    v: Array
    a: Array
    angles: Sequence[Array] | None = None

    @cached_property
    def found(self) -> Evaluation:
        """The residual, with tangents."""
        return self.machine.residual(self.t, self.q, self.v, self.a, angles=self.angles)

    @cached_property
    def chart(self) -> Motion:
        """The motion of the chart."""
        return Motion(self.machine, self.t, 0 * self.q, 0 * self.v, 0 * self.a, self.angles)

    def of_end(self, end: End) -> tuple[Array, ...]:
        """Give place (m), velocity and acceleration of an end, ``(instants, d)`` each."""
        at, d = self.found.at, self.machine.geometry.d
        columns = np.einsum("tjik,tk->tji", at.J[:, end.pose], at.ways[:, end.pose, d:])  # their rates
        place, rate, second = at.r[:, end.pose], at.ways[:, end.pose, :d], at.acc[:, end.pose]
        moved = place + at.R[:, end.pose] @ end.offset
        acceleration = second[:, 0] + self.machine.gravity + end.offset @ second[:, 1:]
        return tuple(map(np.asarray, (moved, rate + end.offset @ columns, acceleration)))

    def axes(self, end: End) -> Array:
        """Give the axes of an end ``(instants, d, d)``."""
        return np.asarray(self.found.at.R[:, end.pose] @ end.turn)
