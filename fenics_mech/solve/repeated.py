"""Motions in time that repeat: the state that comes back to itself after a cycle, by Newton's method.

The motion first goes on by itself for some cycles. Newton's method then looks for the state beside it that the cycle
brings back, with the transition of small disturbances through the cycle, whose eigenvalues are the Floquet
multipliers. Where nothing depends on time the period is unknown too, and the state moves across the motion only.
Angles may come back whole turns later. That forces come back with them is looked at. Disturbances are
those that rows of joints allow: others are none. While Newton's method goes on, steps end at the same shares of the
cycle, so that the end is a smooth function of the start. Then they are chosen anew.

Source: Parker and Chua, Practical Numerical Algorithms for Chaotic Systems (1989), chapters 3 and 5.
"""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass
from itertools import product
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index
from fenics_mech._constants import TINY
from fenics_mech.errors import AssemblyError, SceneError, SolverError

logger = logging.getLogger(__name__)
ANGLE, STROKE = range(2)  # kinds of coordinates: angles (rad), and ways (m)
History = tuple[Array, Array, Array]  # times (s), coordinates and rates there, ``(times, coordinates)`` each


@dataclass(frozen=True)
class ShootingLimits:
    """Limits of the search for a motion that repeats."""

    samples: int = 48  # of a cycle at which its size is seen
    in_recurrence: int = 192  # of the period that is stated: states among which the last is looked for
    most_iterations: int = 12  # of Newton's method
    halvings: int = 4  # of its steps
    closed: float = 10.0  # times the tolerance of a time step, down to which a cycle has to close
    rounding: float = 1e-9  # of a cycle that needs no further step of Newton's method
    later: float = 1e-6  # of a cycle, by which its end is differentiated: stiff links follow it slowly
    nearly: float = 1e-6  # the same, below which a step of Newton's method is not worth a second try
    most_choices: int = 3  # of the steps in time
    by_chance: float = 10.0  # times what a cycle may miss by: other steps over kinks of friction differ by as much
    forces: float = 1e-3  # of the largest force, by which it may have changed after a cycle
    beside: float = 0.2  # of the largest distance of two states, below which one comes near to the other again
    away: float = 0.3  # of it, that the motion has to go away before
    shortest: float = 0.2  # of the period, that Newton's method may make it shorter
    open_ends: tuple[float, ...] = (1e-9, 1e-2)  # of the largest singular value: families leave their member open
    farthest: float = 1.0  # of the largest way or rate, by which a step may move the state
    least: float = 1e-6  # of the largest way or rate of all, that of a kind of coordinates counts as at least
    stable: float = 1e-3  # beyond 1, up to which a multiplier's magnitude shows no growth


SHOOTING = ShootingLimits()


@dataclass(frozen=True)
class State:
    """A state of a motion."""

    time: float  # time (s)
    displacement: Array  # coordinates and their rates, (coordinates,) each
    velocity: Array
    known: Any = None  # what tells whole turns there to who integrates the motion


@dataclass(frozen=True)
class Lap:
    """A motion from a state to the end of a cycle."""

    start: State  # the states
    end: State
    forces: Array  # forces or accelerations at both, which are the same where the motion repeats (2, forces)
    sizes: Array  # what coordinates and rates are relative to, (2 coordinates,): see `sizes_of`
    # small disturbances of the coordinates and rates at the start that the rows allow, one a column, (2 coordinates,
    # disturbances)
    disturbed: Array
    transition: Array  # what becomes of them, as large: by what the end then misses the start more
    # whether bodies touched, or dry friction turned round: disturbances of such a motion are known roughly only
    rough: bool
    shares: Array  # where its steps end, of its duration, with 0 (steps + 1,)

    @property
    def duration(self) -> float:
        """Time that it takes (s)."""
        return self.end.time - self.start.time

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Eigenvalues of the transition, largest magnitude first; none where they are known roughly."""
        if self.rough:
            return np.zeros(0, dtype=complex)
        start, end = (x / self.sizes[:, None] for x in (self.disturbed, self.transition))
        values = np.linalg.eigvals(np.linalg.lstsq(start, end, rcond=None)[0]).astype(complex)
        return np.asarray(values[np.argsort(-np.abs(values), kind="stable")])


class Runner(Protocol):
    """Integrates a motion."""

    @property
    def kinds(self) -> Index:
        """Kind of each coordinate, ``(coordinates,)``: `ANGLE` or `STROKE`."""

    def lap(self, start: State, duration: float, shares: Array | None = None) -> Lap:
        """Give the motion from a state on for so long (s), by steps that end at shares of it, or are chosen."""

    def begin(self) -> State:
        """Give the state that the motion goes on from at first."""

    def run(self, start: State, duration: float, samples: int) -> tuple[State, History]:
        """Let the motion go on from a state for so long (s); give its end, and what it was at equal steps of time."""

    def moved(self, start: State, change: Array) -> State:
        """Give a state beside another one, by the change of coordinates and rates ``(2 coordinates,)``."""

    def missed(self, start: State, end: State) -> Array:
        """Give the change of coordinates and rates from a state to another one, but for whole turns."""

    def depends_on_time(self, start: State) -> bool:
        """Whether the equation at a state is another one at other times."""


@dataclass(frozen=True)
class Search:
    """What is looked for."""

    period: float  # a cycle of drives and forces; of a motion with a period of its own, about that (s)
    driven: bool  # whether drives lead parts of the machine
    cycles: int  # cycles that the motion goes on for at first
    repeats: int  # cycles after which it comes back
    settled: float  # change from cycle to cycle, relative to its size, at which it goes on no further
    tolerance: float  # by which a closed cycle may miss its start


@dataclass(frozen=True)
class RepeatedMotion:
    """A motion that repeats."""

    start: State  # the state that comes back
    # floquet multipliers, largest magnitude first; none where bodies touch, or dry friction turns round
    multipliers: NDArray[np.complex128]
    period: float  # time after which it repeats (s)
    # by how much it misses that: of coordinates over the largest way of their kind, of rates over the largest rate
    change: float
    own: bool  # whether its period is its own, and none of forces or drives

    @property
    def growing(self) -> NDArray[np.complex128]:
        """Multipliers of disturbances that may grow: along a motion of its own period one neither grows nor decays."""
        along = int(np.abs(self.multipliers - 1).argmin()) if self.own and len(self.multipliers) else None
        return self.multipliers if along is None else np.delete(self.multipliers, along)

    @property
    def stable(self) -> bool:
        """Whether no disturbance grows."""
        return bool((np.abs(self.growing) <= 1 + SHOOTING.stable).all())

    def refuse_unstable(self, repeats: int) -> None:
        """Raise `SolverError` where a disturbance grows, with what else comes back after so many cycles."""
        if self.stable:
            return
        worst = complex(self.growing[0])
        more = f"Other cycles of the forces may bring a stable one back: try analysis.repeats = {2 * repeats}"
        other = "Take another start" if self.own else f"{more}, or another start"
        factor = f"{worst.real:.5g}" if worst.imag == 0 else f"{abs(worst):.5g} (multiplier {worst:.4g})"
        raise SolverError(
            f"the motion that repeats after {self.period:.6g} s is unstable: a small disturbance is multiplied by "
            f"{factor} in each. {other}. analysis.allow_unstable lets it pass"
        )


def repeated_motion(search: Search, runner: Runner) -> RepeatedMotion:
    """Find the motion that repeats."""
    start = runner.begin()
    own = not search.driven and not runner.depends_on_time(start)
    if own:
        if search.repeats > 1:
            raise SceneError(
                "nothing depends on time, and the motion's own period is found whatever it is",
                place="analysis.repeats",
                hint="Leave it out",
            )
        start, history = runner.run(start, search.period * search.cycles, search.cycles * SHOOTING.in_recurrence)
        period = _recurrence(history, runner.kinds)
    else:
        period = search.period * search.repeats
        start = _run_in(runner, start, period, search)
    lap = _closed(runner, start, period, own, search)
    missed = np.abs(lap.forces[1] - lap.forces[0]).max() / max(np.abs(lap.forces).max(), TINY)
    if missed > SHOOTING.forces:
        raise SolverError(
            f"the state comes back after {lap.duration:.6g} s, but not its forces: they differ by {missed:.1%}. "
            "Forces depend on how often a joint has turned, or have another period. "
            "Give analysis.duration the period of the forces, or leave out what counts turns"
        )
    return RepeatedMotion(lap.start, lap.multipliers, lap.duration, _change(runner, lap), own)


def _run_in(runner: Runner, start: State, period: float, search: Search) -> State:
    """Let the motion go on for some cycles, fewer where two of them differ little."""
    for _ in range(math.ceil(search.cycles / search.repeats)):
        end, (_, place, rate) = runner.run(start, period, SHOOTING.samples)
        missed = runner.missed(start, end)
        change = float(np.abs(missed / sizes_of(place, rate, runner.kinds)).max())
        logger.info("after %.6g s the motion differs by %.3g from a cycle before", end.time, change)
        if change <= search.settled:
            return end
        start = end
    return start


def _recurrence(history: History, kinds: Index) -> float:
    """Time (s) since which the last of some states has been met before, but for whole turns of pins."""
    time, place, rate = history
    half = slice(len(time) // 2, None)
    time, place, rate = time[half], place[half], rate[half]
    away = place - place[-1]
    away = np.where(kinds == ANGLE, np.angle(np.exp(1j * away)), away)
    parts = [part / max(float(np.ptp(part)), TINY) for part in (away, rate - rate[-1])]
    distance = np.linalg.norm(np.hstack(parts), axis=1)
    largest = float(distance.max())
    left = np.flatnonzero(distance > SHOOTING.away * largest)
    inside = np.arange(1, len(time) - 1)
    lowest = inside[(distance[1:-1] <= distance[:-2]) & (distance[1:-1] <= distance[2:])]
    near = lowest[(lowest < left[-1]) & (distance[lowest] < SHOOTING.beside * largest)] if len(left) else lowest[:0]
    if not len(near):
        raise SolverError(
            f"the motion does not come back within {time[-1] - time[0]:.6g} s to the state that it has at the end. "
            "Let it go on for longer by analysis.cycles and duration"
        )
    least = distance[near].min()
    close = near[distance[near] <= 3 * least + 1e-3 * largest]  # the latest of those that are as near as any
    return float(time[-1] - time[close[-1]])


def sizes_of(place: Array, rate: Array, kinds: Index) -> Array:
    """Give what coordinates and their rates are relative to: the largest way and rate of their kind."""
    # place, rate (times, coordinates) each; kinds (coordinates,)
    found = np.stack([np.ptp(place, axis=0), np.abs(rate).max(axis=0)])
    least = SHOOTING.least * found.max(axis=1, keepdims=True)
    for kind in np.unique(kinds):
        found[:, kinds == kind] = found[:, kinds == kind].max(axis=1, keepdims=True)
    return np.maximum(np.maximum(found, least), TINY).ravel()


def _change(runner: Runner, lap: Lap) -> float:
    """By how much a cycle misses its start, over the largest way and rate of each kind of coordinates."""
    return float(np.abs(runner.missed(lap.start, lap.end) / lap.sizes).max())


def _closed(runner: Runner, start: State, period: float, own: bool, search: Search) -> Lap:
    """Close a cycle beside a start by Newton's method."""
    lap = runner.lap(start, period)
    first = change = _change(runner, lap)
    for _ in range(SHOOTING.most_choices):
        better = _by_newton(runner, lap, own)
        if better is None:
            break
        lap = runner.lap(better.start, better.duration)
        change = _change(runner, lap)
        logger.info("by other steps it misses its start by %.3g", change)
        if change <= search.tolerance:
            return lap
    if better is not None and change <= SHOOTING.by_chance * search.tolerance:
        return better
    if lap.rough and change <= max(search.settled, search.tolerance):  # disturbances are known roughly there
        return lap
    raise SolverError(
        f"the motion does not repeat: it misses its state by {first:.2%} after {period:.6g} s, and Newton's method "
        f"leaves {change:.2g} of that size. Let it go on for more analysis.cycles before, or try another "
        "analysis.repeats. Where no cycle repeats, take another start, with analysis.lyapunov and analysis.poincare"
    )


def _by_newton(runner: Runner, lap: Lap, own: bool) -> Lap | None:
    """Close a cycle as well as steps at the same shares of it do; None where that brings it no nearer."""
    first = change = _change(runner, lap)
    for _ in range(SHOOTING.most_iterations):
        logger.info("a cycle of %.9g s misses its start by %.3g", lap.duration, change)
        if change <= SHOOTING.rounding:
            return lap
        found = _nearer(runner, lap, change, own, tries=1 if change < SHOOTING.nearly else SHOOTING.halvings)
        if found is None:
            break
        lap, change = found
    return lap if change < first else None


def _nearer(runner: Runner, lap: Lap, change: float, own: bool, tries: int) -> tuple[Lap, float] | None:
    """Give a cycle that misses its start by less, or None; `tries` are of steps, each half as long."""
    # Unknown are sizes of orthogonal disturbances, over what coordinates and rates are relative to.
    scale = lap.sizes[:, None]
    orthogonal, triangle = np.linalg.qr(lap.disturbed / scale)
    matrix = np.linalg.solve(triangle.T, (lap.transition / scale).T).T - orthogonal
    missed = -runner.missed(lap.start, lap.end) / lap.sizes
    if own:
        later = runner.lap(lap.start, lap.duration * (1 + SHOOTING.later), lap.shares)
        along = (runner.missed(lap.start, later.end) / lap.sizes + missed) / SHOOTING.later
        across = along @ orthogonal / max(float(np.linalg.norm(along)), TINY)
        matrix = np.block([[matrix, along[:, None]], [across[None], np.zeros((1, 1))]])
        missed = np.append(missed, 0.0)
    for least, halving in product(SHOOTING.open_ends, range(tries)):
        solved = np.linalg.lstsq(matrix, missed, rcond=least)[0] / 2**halving
        step = orthogonal @ solved[: orthogonal.shape[1]]
        longer = float(solved[-1]) if own else 0.0
        if max(np.abs(step).max(), abs(longer)) > SHOOTING.farthest or 1 + longer < SHOOTING.shortest:
            continue
        try:
            trial = runner.lap(runner.moved(lap.start, step * lap.sizes), lap.duration * (1 + longer), lap.shares)
        except (SolverError, AssemblyError) as error:
            logger.info("a trial of a cycle failed: %s", error)
            continue
        if (left := _change(runner, trial)) < change:
            return trial, left
    return None
