"""A periodic motion by steps: where each begins, and the accelerations at its stages."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.machine import Machine
from fenics_mech.solve.stages import Tableau, radau

SAME = 1e-9  # of a period between instants that are one


@dataclass
class Path:
    """A periodic motion by steps: where each begins, and the accelerations at its stages.

    Parameters
    ----------
    tableau
        Of a step.
    starts
        Instants at which the steps begin, ascending ``(steps,)`` (s).
    period
        s.
    n
        Coordinates; what follows them are multipliers.
    q0, v0
        Coordinates and rates at the start of every step ``(steps, size)``.
    a
        Accelerations with multipliers ``(steps, stages, size)``.
    """

    tableau: Tableau
    starts: Array
    period: float
    n: int
    q0: Array
    v0: Array
    a: Array

    @classmethod
    def of_rest(cls, machine: Machine, period: float, steps: int | Array, stages: int) -> Path:
        """Give the path of the chart, by so many even steps or by the instants at which they begin (s)."""
        starts = period / steps * np.arange(steps) if isinstance(steps, int) else np.asarray(steps, dtype=float)
        zero, a = np.zeros((len(starts), machine.size)), np.zeros((len(starts), stages, machine.size))
        return cls(radau(stages), starts, period, machine.n, zero, zero.copy(), a)

    @property
    def h(self) -> Array:
        """Length of every step ``(steps,)`` (s)."""
        return np.diff(self.starts, append=self.starts[0] + self.period)

    def when(self, t: Array) -> tuple[Array, Array, Array]:
        """Give coordinates, rates and accelerations at instants of the cycle ``(instants, size)`` each."""
        # Where two steps meet it is the end of the first, in which accelerations are of the order of the steps.
        since = np.mod(t - self.starts[0] - MEETING * self.period, self.period) + MEETING * self.period
        step = np.searchsorted(self.starts - self.starts[0], since - MEETING * self.period, side="right") - 1
        h = self.h[step]
        values, integrals = self.tableau.at((since - (self.starts - self.starts[0])[step]) / h)
        a = self.a[step]
        at_stages = self.v0[step, None] + h[:, None, None] * np.einsum("ij,kjn->kin", self.tableau.A, a)
        q = self.q0[step] + h[:, None] * np.einsum("kj,kjn->kn", integrals, at_stages)
        v = self.v0[step] + h[:, None] * np.einsum("kj,kjn->kn", integrals, a)
        q[:, self.n :] = v[:, self.n :] = 0.0
        return q, v, np.einsum("kj,kjn->kn", values, a)

    def at(self, s: Array) -> tuple[Array, Array, Array, Array]:
        """Give instants ``(steps, shares)`` (s), coordinates, rates and accelerations at shares of every step."""
        values, integrals = self.tableau.at(s)
        h = self.h[:, None, None]
        t = self.starts[:, None] + h[:, 0] * s
        at_stages = self.v0[:, None] + h * np.einsum("ij,kjn->kin", self.tableau.A, self.a)
        q = self.q0[:, None] + h * np.einsum("ij,kjn->kin", integrals, at_stages)
        v = self.v0[:, None] + h * np.einsum("ij,kjn->kin", integrals, self.a)
        q[..., self.n :] = v[..., self.n :] = 0.0
        return t, q, v, np.einsum("ij,kjn->kin", values, self.a)

    @property
    def resting(self) -> Path:
        """The path of the chart by the same steps."""
        return replace(self, q0=0 * self.q0, v0=0 * self.v0, a=0 * self.a)

    def moved(self, change: Path, share: float = 1.0) -> Path:
        """Give the path with a share of a change."""
        q0, v0, a = self.q0 + share * change.q0, self.v0 + share * change.v0, self.a + share * change.a
        return replace(self, q0=q0, v0=v0, a=a)

    def paced(self, period: float) -> Path:
        """Give the path through the same coordinates in another period (s), with the same multipliers."""
        pace, a = self.period / period, self.a.copy()
        a[..., : self.n] *= pace**2
        return replace(self, starts=self.starts / pace, period=period, v0=pace * self.v0, a=a)

    def alike(self, other: Path) -> bool:
        """Whether another path has as many coordinates, and the same steps of a cycle."""
        same = self.n == other.n and self.a.shape == other.a.shape
        return same and bool(np.abs(self.starts / self.period - other.starts / other.period).max() < SAME)

    def beyond(self, before: Path, share: float) -> Path:
        """Go on as from another path to this one, by a share of the difference, where that is small."""
        other = before.paced(self.period)
        apart = float(np.linalg.norm(self.q0 - other.q0))
        if apart > STRAIGHT * float(np.linalg.norm(self.q0)):
            return self
        q0, v0, a = (x + share * (x - y) for x, y in zip((self.q0, self.v0, self.a), (other.q0, other.v0, other.a)))
        return replace(self, q0=q0, v0=v0, a=a)

    def with_stages(self, stages: int) -> Path:
        """Give the same path by other stages of the same steps."""
        tableau = radau(stages)
        return Path(tableau, self.starts, self.period, self.n, self.q0.copy(), self.v0.copy(), self.at(tableau.c)[3])


STRAIGHT = 0.15  # of a motion, by which another differs, up to which a straight line through both goes on
MEETING = 1e-12  # of a period: instants of steps that meet are one within it
