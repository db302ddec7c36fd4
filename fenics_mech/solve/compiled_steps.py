"""Compiled steps of a linearised cycle: factors by blocks, and states that go through the steps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, Protocol

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._kernels import call
from fenics_mech.beams.made_once import LastMade
from fenics_mech.machine import Evaluation, Machine, Pattern
from fenics_mech.machine.pattern import Places
from fenics_mech.solve.sparse import Factors, blocks_of
from fenics_mech.solve.stages import Tableau, radau

LOST = 1e-7  # largest error of a solution by factors: Newton's method corrects it, and multipliers are as exact as it


class Order(NamedTuple):
    """The order in which the unknowns of a pattern are eliminated, as the kernel takes it."""

    # Multipliers follow the coordinates that they bind, so that no row has to be exchanged for another. Among those
    # that may come next, the one with the fewest neighbours does.

    order: Places  # Unknowns
    first: Places  # those that each meets later, in the order: later[first[k]:first[k + 1]]
    later: Places
    to: Places  # blocks between each two of them, one unknown after the other
    block: Places  # block of every entry of the pattern
    row: Places  # of every entry
    column: Places


ORDERS = LastMade(8)  # machines of a study, and their finer meshes, have the same patterns


def order_of(pattern: Pattern, coordinates: int) -> Order:
    """Plan the order in which the unknowns of a pattern are eliminated, of which the first are coordinates."""
    needed = pattern.indptr.tobytes(), pattern.indices.tobytes(), coordinates
    return ORDERS.once(needed, _planned, pattern, coordinates)


def _planned(pattern: Pattern, coordinates: int) -> Order:
    size, column = pattern.size, pattern.indices
    row = np.repeat(np.arange(size, dtype=np.int32), np.diff(pattern.indptr))
    near = np.zeros((size, size), dtype=bool)
    near[row, column] = near[column, row] = True
    np.fill_diagonal(near, False)
    binds, left = near.copy(), np.ones(size, dtype=bool)
    binds[:coordinates], binds[:, coordinates:] = False, False
    order, met, place = np.empty(size, dtype=np.int32), [], np.empty(size, dtype=np.int32)
    for k in range(size):
        ready = left & ~(binds & left).any(axis=1)
        next_one = np.where(ready, near.sum(axis=1), size).argmin()
        order[k], place[next_one], left[next_one] = next_one, k, False
        met.append(np.flatnonzero(near[next_one]))
        near[np.ix_(met[-1], met[-1])] = True
        near[next_one] = near[:, next_one] = False
        np.fill_diagonal(near, False)
    first, block, later, to = np.zeros(size + 1, dtype=np.int32), np.full((size, size), -1, dtype=np.int32), [], []
    above = sum(map(len, met))
    for k, own in enumerate(met):
        later.append(np.sort(place[own]))
        numbers = size + first[k] + np.arange(len(own), dtype=np.int32)
        block[k, k], block[k, later[-1]], block[later[-1], k] = k, numbers, above + numbers
        first[k + 1] = first[k] + len(own)
    for own in later:
        to.append(block[np.ix_(own, own)].ravel())
    of_entries = np.ascontiguousarray(block[place[row], place[column]])
    return Order(order, first, np.concatenate(later), np.concatenate(to), of_entries, row, column)


class Jump(Protocol):
    """A jump of rates that goes with the coordinates."""

    @property
    def by_q(self) -> Array:
        """Its derivatives by the coordinates ``(n, n)`` (1/s)."""


class CompiledSteps:
    """Linearised steps of a cycle that are factored by blocks."""

    def __init__(self, order: Order, n: int, tableau: Tableau, h: Array, M: Array, C: Array, K: Array) -> None:
        # tableau, h (steps,) (s); M, C, K (steps, stages, entries)
        self.n, self.shape = n, (*M.shape[:2], len(order.order))
        tables = map(np.ascontiguousarray, (h, tableau.A, tableau.square, tableau.c, M, C, K))
        self._given = (self.shape[1], self.shape[2], M.shape[2], *order, *tables)
        self.factors = np.empty((len(h), len(order.order) + 2 * len(order.later), self.shape[1], self.shape[1]))
        singular = call("factor_steps", *self._given, len(h), self.factors)
        lost = np.inf if singular >= 0 else call("missed_steps", *self._given, len(h), self.factors)
        self.holds = bool(lost < LOST)  # else rows have to be exchanged, as where a link has no mass

    def through(
        self,
        states: Array,
        unit: float,
        blows: Mapping[int, Jump],
        right: Array | None = None,
        gaps: Array | None = None,
        along: bool = False,
    ) -> tuple[Array, Array | None, Array | None]:
        """Take states through all steps, as `LinearSteps.through` does."""
        # Rates count in a unit. After some steps they jump.
        count, (steps, stages, size) = len(states), self.shape
        ends, a = states.copy(), np.empty((steps, stages, size)) if along else None
        after = np.empty((steps, count, 2 * self.n)) if along else None
        blow, by_q = np.full(steps, -1, dtype=np.int32), np.zeros((max(1, len(blows)), self.n, self.n))
        for number, (k, struck) in enumerate(blows.items()):
            blow[k], by_q[number] = number, struck.by_q
        right = right if right is None else np.ascontiguousarray(right)
        gaps = gaps if gaps is None else np.ascontiguousarray(gaps)
        given = self.n, unit, steps, count, right, gaps, blow, by_q
        call("march_steps", *self._given, self.factors, *given, ends, a, after)
        return ends, a, after


MASSLESS = 1e-14  # of the largest mass: coordinates without mass, on which nothing acts, keep it solvable


def mass_with_rows(machine: Machine, found: Evaluation) -> Array:
    """Give the matrix of M a + G^T L = F, G a = 0 by the tangents of a residual ``(instants, entries)``."""
    n, kept, order = machine.n, machine.n + machine.held, order_of(found.pattern, machine.n)
    of_gaps, of_modes = (order.row >= n) & (order.column < n), (order.row >= kept) != (order.column >= kept)
    values = np.where(of_modes, 0.0, np.where(of_gaps, found.K, found.M))
    if machine.rides:  # impulses are too short for members to give way
        machine.riders.stiffen(values, found.pattern)
    values[:, (order.row == order.column) & (order.row < n)] += MASSLESS * np.abs(found.M).max()
    return values


def accelerated(machine: Machine, found: Evaluation, force: Array) -> Array:
    """Give what forces accelerate within the rows, at rest: M a + G^T L = F, G a = 0.

    Parameters
    ----------
    machine
        The machine.
    found
        The residual at some instants, with tangents.
    force
        On the coordinates ``(instants, size)`` (N, N m).

    Returns
    -------
    numpy.ndarray
        Accelerations with multipliers, ``(instants, size)``.

    Raises
    ------
    SolverError
        When a coordinate without mass is not held.
    """
    n, pattern, values = machine.n, found.pattern, mass_with_rows(machine, found)
    order = order_of(pattern, n)
    none = np.zeros((len(values), 1, values.shape[1]))
    march = CompiledSteps(order, n, radau(1), np.zeros(len(values)), values[:, None], none, none)
    if march.holds:
        found_a = march.through(np.zeros((1, 2 * n)), 1.0, {}, force[:, None], along=True)[1]
        assert found_a is not None
        return found_a[:, 0]
    blocks = blocks_of(pattern, 1)
    return np.array([Factors(blocks, x[:, None, None], "accelerations").solve(y) for x, y in zip(values, force)])
