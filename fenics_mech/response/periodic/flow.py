"""How a linear equation of motion carries the state through the steps of a cycle, by collocation in each step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from fenics_mech._arrays import Array, times
from fenics_mech._ranks import over_positions
from fenics_mech.mechanism.equation import Matrices, refuse_rigid_damping
from fenics_mech.response.periodic.cyclic import BlockCyclic
from fenics_mech.response.periodic.tableau import Tableau


@dataclass(frozen=True)
class Flow:
    """The steps of a cycle. The state at a start is ``(q, pace q')``.

    Parameters
    ----------
    matrices
        ``M q'' + C q' + K q = f`` at the collocation points of all steps; several loads are ``(points, n, loads)``.
    tableau
        The points.
    step
        Duration of all steps, or of each of them (s).
    options
        PETSc options with the prefix "periodic_".
    """

    matrices: Matrices
    tableau: Tableau
    step: float | Array
    options: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def cycle(self) -> BlockCyclic:
        """The system that closes the cycle."""
        return BlockCyclic(self.transitions, self.options)

    @property
    def pace(self) -> float:
        """Mean duration of the steps (s)."""
        return float(np.mean(self.step))

    @property
    def duration(self) -> Array:
        """Duration of each step (s), ``(steps,)``."""
        return np.broadcast_to(self.step, len(self.matrices.load) // len(self.tableau.points))

    @property
    def size(self) -> int:
        """Number n of coordinates."""
        return self.matrices.mass.shape[1]

    @cached_property
    def unit(self) -> Array:
        """Root of a coordinate's stiffness and inertia in a step, ``(n,)``: times it, m and rad are alike."""
        parts = self.matrices.stiffness, self.matrices.mass / self.pace**2
        size = sum(np.abs(np.einsum("tii->ti", part)).mean(axis=0) for part in parts)
        return np.sqrt(np.where(size, size, 1.0))

    def states(self, q: Array, rate: Array) -> Array:
        """Put q and q', ``(steps, coordinates)`` each, into states, ``(steps, 2n)``."""
        return np.concatenate([q, self.pace * rate], axis=1)

    def parts(self, states: Array) -> tuple[Array, Array]:
        """Take q and q' out of states, ``(steps, coordinates)`` each."""
        return states[:, : self.size], states[:, self.size :] / self.pace

    @property
    def transitions(self) -> Array:
        """From the state at the start of each step to that at its end, ``(steps, 2n, 2n)``."""
        return self._ends[..., : 2 * self.size]

    @property
    def added(self) -> Array:
        """What the load adds to the state in each step, ``(steps, 2n)``, or with several ``(steps, 2n, loads)``."""
        added = self._ends[..., 2 * self.size :]
        return added[..., 0] if self.matrices.load.ndim == 2 else added

    def ends(self, starts: Array) -> Array:
        """Give the states at the ends of the steps from those at their starts, ``(steps, 2n)`` each."""
        return times(self.transitions, starts) + self.added

    def accelerations(self, starts: Array, loads: Sequence[float] = (1.0,)) -> Array:
        """Give q'' at the points, ``(steps, s, n)``, from the states at the starts and so much of each load."""
        by_state, by_load = np.split(self._response, [2 * self.size], axis=-1)
        return times(by_state, starts[:, None]) + by_load @ np.asarray(loads)

    def added_by(self, load: Array) -> Array:
        """What another load adds to the state in each step, ``(steps, 2n)``; it is ``(steps, s, n)`` at the points."""
        parts = self.matrices.mass, self.matrices.damping, self.matrices.stiffness
        blocks = (part.reshape(*load.shape, self.size) for part in parts)
        matrix = self.tableau.stage_matrix(self.duration, *blocks)
        found = np.linalg.solve(matrix, load.reshape(len(load), -1, 1)).reshape(load.shape)
        return (self._to_ends @ found).reshape(len(load), -1)

    @property
    def _to_ends(self) -> Array:
        """From accelerations at the points to displacement and ``pace q'`` at the ends, ``(steps, 2, s)``."""
        h, weights = self.duration[:, None, None], self.tableau.weights
        return h * np.concatenate([h * (weights @ self.tableau.inner), np.full_like(h, self.pace) * weights], axis=1)

    @cached_property
    def _response(self) -> Array:
        """Accelerations at the points by a state at the start, and in the last columns by the loads.

        They are ``(steps, s, n, 2n + loads)``.
        """
        refuse_rigid_damping(self.matrices, self.pace)
        return over_positions(len(self.duration), lambda steps: (self._response_of(steps),))[0]

    def _response_of(self, steps: slice) -> Array:
        """Give the response in some of the steps."""
        tableau, s, n = self.tableau, len(self.tableau.points), self.size
        unit = self.unit
        pairs, parts = np.outer(unit, unit), (self.matrices.mass, self.matrices.damping, self.matrices.stiffness)
        mass, damping, stiffness = (m.reshape(-1, s, n, n)[steps] / pairs for m in parts)
        load = self.matrices.load.reshape(len(self.duration), s, n, -1)[steps] / unit[:, None]
        h = self.duration[steps, None, None]
        by_velocity = -(damping + (h * tableau.points[:, None])[..., None] * stiffness) / self.pace
        right = np.concatenate([-stiffness * unit, by_velocity * unit, load], axis=-1)
        matrix = tableau.stage_matrix(self.duration[steps], mass, damping, stiffness)
        found = np.linalg.solve(matrix, right.reshape(-1, s * n, right.shape[-1])).reshape(right.shape)
        found /= unit[:, None]
        return np.asarray(found)

    @cached_property
    def _ends(self) -> Array:
        """State at the ends by that at the start, and by the loads, ``(steps, 2n, 2n + loads)``."""
        n, h, s = self.size, self.duration[:, None, None], len(self.tableau.points)
        found = (self._to_ends @ self._response.reshape(len(h), s, -1)).reshape(len(h), 2 * n, -1)
        found[..., : 2 * n] += np.eye(2 * n)
        found[:, :n, n : 2 * n] += h / self.pace * np.eye(n)
        return found
