"""A cycle that closes: ``z_{k+1} = T_k z_k + r_k`` with ``z_n = z_0``, (5.16), by marches through its steps.

A march from a guess of z_0 comes to another state at the end. The difference depends on z_0 by ``1 - T``, with T the
product of all T_k, whose eigenvalues are the Floquet multipliers: what dies out in a cycle costs GMRES no iteration.
Where motions grow within a cycle, the march is cut, and the states at all cuts are unknowns (multiple shooting).

Source: Ascher, Mattheij and Russell, Numerical Solution of Boundary Value Problems (1995), ch. 4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech._sparse import LANES
from fenics_mech.errors import SolverError
from fenics_mech.response.periodic.cyclic import CYCLIC, not_closed
from fenics_mech.response.periodic.krylov import krylov

if TYPE_CHECKING:
    from fenics_mech.response.periodic.flow import Flow

MANY = 6  # iterations of GMRES for a load: a few less than measured, 7 to 20
KRYLOV = {"ksp_gmres_restart": 300, "ksp_max_it": 600}


@dataclass(frozen=True)
class Passage:
    """How states grow as they pass through a cycle.

    Parameters
    ----------
    cuts
        Parts of the cycle in which no state grows much.
    growth
        Power of 10 by which a disturbance grows in a cycle; below 0 where it dies out.
    """

    cuts: list[slice]
    growth: float

    @classmethod
    def through(cls, steps: Flow) -> Passage:
        """Follow a random state through its second cycle.

        Parameters
        ----------
        steps
            The steps of the cycle.
        """
        unit = np.tile(steps.unit, 2)
        state = np.random.default_rng(0).standard_normal(len(unit)) / unit
        for _ in range(2):
            begins, count, growth = [0], len(steps.duration), 0.0
            while begins[-1] < count:
                passed = steps.march(state, steps=slice(begins[-1], count)) * unit
                sizes = np.linalg.norm(passed, axis=1)
                grown = np.flatnonzero(sizes > CYCLIC.growth * np.minimum.accumulate(sizes))
                begins.append(begins[-1] + int(grown[0]) if len(grown) else count)
                at = begins[-1] - begins[-2]
                state = passed[at] / (max(sizes[at], TINY) * unit)
                growth += math.log10(max(sizes[at], TINY)) - math.log10(max(sizes[0], TINY))
        return cls([slice(first, last) for first, last in pairwise(begins)], growth)


@dataclass(frozen=True, eq=False)
class Closing:
    """The system of a cycle.

    Parameters
    ----------
    steps
        The steps.
    """

    steps: Flow

    @cached_property
    def unit(self) -> Array:
        """What states are multiplied by for their numbers to be alike, ``(2n,)``."""
        return np.tile(self.steps.unit, 2)

    @property
    def cuts(self) -> list[slice]:
        """Parts of the cycle in which no state grows much."""
        return self.steps.passage.cuts

    @property
    def growth(self) -> float:
        """Power of 10 by which a disturbance grows in a cycle; below 0 where it dies out."""
        return self.steps.passage.growth

    def solve(self, right: Array, guess: Array | None = None, tolerance: float = CYCLIC.tolerance) -> Array:
        """Solve for the states at the starts of all steps, ``(steps, state)``, or of several cycles.

        Parameters
        ----------
        right
            What is added to the state in each step, ``(steps, state)``, or of several loads ``(steps, state, loads)``.
        guess
            A state at the start of the cycle to begin from, ``(state,)``.
        tolerance
            Residual at which iterations end, relative to what is added in the steps.

        Raises
        ------
        SolverError
            When the KSP does not converge or its answer is not accurate, as at an undamped resonance.
        """
        if right.ndim == 3:
            parts = np.moveaxis(right, -1, 0)
            known = self._by_monodromy(parts) if len(self.unit) < MANY * LANES * len(parts) else None
            if known is None:
                known = np.stack([self.solve(part, None, tolerance) for part in parts], axis=-1)
            return known
        if "by_matrices" in vars(self.steps):  # marches failed before
            return self.steps.by_matrices.solve(right)
        try:
            return self._marched(right, guess, tolerance)
        except SolverError:
            if self._large or any(name.startswith("periodic_") for name in self.steps.options):
                raise
            return self.steps.by_matrices.solve(right)

    @property
    def _large(self) -> bool:
        """Whether the matrices of all steps are too many numbers to be made."""
        return len(self.steps.duration) * len(self.unit) ** 2 > CYCLIC.most_direct

    def roughly(self, right: Array) -> Array:
        """Solve to the few digits that an estimate needs.

        Parameters
        ----------
        right
            As of `solve`.
        """
        return self.solve(right, tolerance=CYCLIC.tolerance_of_estimate)

    def terms(self, states: Array) -> Array:
        """Give the size of what adds up to the states at the ends of the steps: a few terms of their own size.

        Parameters
        ----------
        states
            States at the starts of the steps, ``(steps, 2n)``.

        Returns
        -------
        numpy.ndarray
            Of the same shape.
        """
        return np.broadcast_to(CYCLIC.terms * np.abs(states).max(axis=0), states.shape)

    def _marched(self, right: Array, guess: Array | None, tolerance: float) -> Array:
        """Solve by marches."""
        cuts, size = self.cuts, len(self.unit)

        def misfit(starts: Array, gain: Array | None) -> Array:
            """By how much parts that begin with these states miss the start of the next one, scaled."""
            ends = [
                self.steps.march(start, None if gain is None else gain[part], part)[-1]
                for start, part in zip(starts.reshape(-1, size) / self.unit, cuts)
            ]
            return starts - (np.roll(ends, 1, axis=0) * self.unit).ravel()

        start = np.zeros(len(cuts) * size)
        if guess is not None and len(cuts) == 1:
            start = guess * self.unit
        load, whole = -misfit(start, right), float(np.linalg.norm(right * self.unit))
        reduction = min(tolerance * whole / max(float(np.linalg.norm(load)), TINY), CYCLIC.least_reduction)
        change, reason = krylov(
            lambda starts: misfit(starts, None), load, KRYLOV | {"ksp_rtol": reduction}, self.steps.options
        )
        starts = (start + change).reshape(-1, size) / self.unit
        parts = [self.steps.march(state, right[part], part) for state, part in zip(starts, cuts)]
        states = np.concatenate([part[:-1] for part in parts])
        residual, grows = self._residual(states, [part[-1] for part in parts], right), len(self.cuts) > 1
        if not np.isfinite(states).all() or not residual < max(CYCLIC.largest_residual, CYCLIC.above * tolerance):
            raise not_closed(reason, residual, grows)
        return states

    def _by_monodromy(self, parts: Array) -> Array | None:
        """Solve for several loads by the whole matrix of the cycle; None where a state grows, or it is not accurate.

        Every march carries several of its columns.
        """
        if len(self.cuts) > 1:
            return None
        whole = self.steps.after_cycle(np.diag(1 / self.unit)) * self.unit[:, None]
        gained = np.array([self.steps.march(np.zeros(len(self.unit)), part) for part in parts])
        try:
            starts = np.linalg.solve(np.eye(len(whole)) - whole, (gained[:, -1] * self.unit).T) / self.unit[:, None]
        except np.linalg.LinAlgError:
            return None
        states = gained.transpose(1, 2, 0) + self.steps.march_several(starts)
        ends = states[-1].T[:, None]
        missed = [self._residual(states[:-1, :, i], list(ends[i]), part) for i, part in enumerate(parts)]
        return states[:-1] if np.isfinite(states).all() and max(missed) < CYCLIC.largest_residual else None

    def _residual(self, states: Array, ends: list[Array], right: Array) -> float:
        """By how much an answer misses to close the cycle, relative to what is added in the steps."""
        begins = np.array([part.start for part in self.cuts])
        gap = np.roll(np.array(ends), 1, axis=0) - states[begins]
        size = max(float(np.linalg.norm(right * self.unit)), TINY)
        if self._large:  # rounding of marches is in proportion to the states, and there is no other way
            size = max(size, CYCLIC.rounding * float(np.linalg.norm(states[begins] * self.unit)))
        return float(np.linalg.norm(gap * self.unit)) / size
