"""How answers change with a machine, to first order, by the tangents with which they were found.

An answer x of the residual R(x, p) = 0 changes with a number p of the machine by R_x dx = -R_p dp. The right side is
half the difference of what two machines beside the known one leave over at x, each with a chart of its own. So x is not
sought again: a number takes two residuals and one solution with the factors that are known (direct differentiation:
Haug and Arora, Applied Optimal Design (1979), ch. 4). Adjoint solutions would save one solution a number, which takes a
twentieth of the time of building two machines and reading two answers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg

from fenics_mech._arrays import Array
from fenics_mech.errors import DerivativeError
from fenics_mech.machine import Evaluation, Machine
from fenics_mech.solve.blows import blows_of
from fenics_mech.solve.path import Path
from fenics_mech.solve.periodic import Cycle
from fenics_mech.solve.sparse import blocks_of, solutions
from fenics_mech.solve.stability import RunningModes

ALIKE = 1e-8  # distance of two multipliers over their size: rounding leaves 1e-12 of multipliers that are one
CONDITION = 1e8  # of a multiplier, beyond which it meets another one, and rounding is all of its derivative


@dataclass(frozen=True)
class Beside:
    """A machine beside the known one, with as many coordinates, whose chart is its own.

    Parameters
    ----------
    machine
        The machine.
    pace
        How many times as fast its drives are.
    linear
        The residual at its rigid motion, beside which the answer is linear; None of an exact answer.
    """

    machine: Machine
    pace: float = 1.0
    linear: Evaluation | None = None

    def left_over(self, t: Array, q: Array, v: Array, a: Array, moving: bool = True) -> Array:
        """Give what a motion leaves over in the equations of forces and of rows ``(instants, n + held)``."""
        if self.linear is not None:
            return self.linear.force[:, : self.kept] + self.carried(self.linear, q, v, a)
        state = (self._fitted(x) for x in (q, v, a))
        return self.machine.residual(t, *state, moving=moving, tangents=False, known=True).force[:, : self.kept]

    def carried(self, found: Evaluation, q: Array, v: Array, a: Array) -> Array:
        """Give the linear part of the same. Sizes of modes of stress are those that the rates give."""
        # Modes of two machines have no order and no signs in common, and their stresses have.
        times = found.pattern.times
        Q, V, A = (self._fitted(x) for x in (q, v, a))
        force = times(found.K, Q) + times(found.C, V) + times(found.M, A)
        if self.machine.size > self.kept:
            force += times(found.M, np.where(np.arange(self.machine.size) < self.kept, 0.0, force))
        return force[:, : self.kept]

    @property
    def kept(self) -> int:
        """Coordinates and multipliers, which the known machine has too."""
        return self.machine.n + self.machine.held

    def _fitted(self, x: Array) -> Array:
        """Give coordinates, rates or accelerations without sizes of modes of stress ``(instants, size)``."""
        fitted = np.zeros((len(x), self.machine.size))
        fitted[:, : self.kept] = x[:, : self.kept]
        return fitted

    def path(self, known: Path) -> Path:
        """Give a path of the known machine at the pace of this one: at the same angles of the drives."""
        n, count, stages = known.n, len(known.starts), len(known.tableau.c)
        a = self._fitted(known.a.reshape(count * stages, -1)).reshape(count, stages, -1)
        a[..., :n] *= self.pace**2
        starts, period = known.starts / self.pace, known.period / self.pace
        q0, v0 = self._fitted(known.q0), self.pace * self._fitted(known.v0)
        return replace(known, starts=starts, period=period, q0=q0, v0=v0, a=a)


def cycle_change(cycle: Cycle, ahead: Beside, behind: Beside) -> Path:
    """Give half of what changes in a periodic motion from one machine beside its own to another, in its own time.

    Parameters
    ----------
    cycle
        The motion.
    ahead, behind
        Machines as far to both sides of its own.
    """
    path, steps, n = cycle.path, cycle.steps, cycle.path.n
    left, struck = [], []
    for other in (ahead, behind):
        there = other.path(path)
        t, q, v, a = (x.reshape(path.a[..., 0].size, -1) for x in there.at(path.tableau.c))
        left.append(other.left_over(t[:, 0], q, v, a))
        struck.append(_struck(other, there))
    right, gaps = np.zeros_like(path.a), np.zeros((len(path.starts), 2 * n))
    right[..., : ahead.kept] = ((left[1] - left[0]) / 2).reshape(*path.a.shape[:2], -1)
    gaps[:, n:] = steps.unit * (struck[0] - struck[1]) / 2
    return steps.change(right, gaps)


def _struck(other: Beside, path: Path) -> Array:
    """Give the jumps of rates at the ends of steps ``(steps, n)``, in the time of the known machine (m/s, rad/s)."""
    n, at = path.n, path if other.linear is None else path.resting
    jumps = np.zeros((len(path.starts), n))
    ends = path.at(np.ones(1))[1][:, 0, :n]
    for k, blows in blows_of(other.machine, at).items():
        jumps[k] = blows.jumps[:, :n].sum(axis=0)
        if other.linear is not None:
            jumps[k] += blows.by_q @ ends[k]
    return jumps / other.pace


def rest_change(
    known: Machine, t: Array, q: Array, a: Array, ahead: Beside, behind: Beside, values: Array, moving: bool
) -> tuple[Array, Array]:
    """Give half of what changes in static answers from one machine to another ``(instants, size)``: q, multipliers.

    Parameters
    ----------
    known
        The machine of the answers.
    t, q, a
        Instants (s), coordinates and multipliers ``(instants, size)``.
    ahead, behind
        Machines as far to both sides of it.
    values
        Entries of the stiffness with the rows, by which the answers were found ``(instants, entries)``.
    moving
        Whether the inertia of the chart's motion acts.
    """
    right, still = np.zeros_like(q), np.zeros_like(q)
    left = (other.left_over(t / other.pace, q, still, a, moving) for other in (ahead, behind))
    right[:, : ahead.kept] = -np.subtract(*left) / 2
    x = solutions(blocks_of(known.pattern, 1), values[..., None, None], right, "the change of a static answer")
    is_coordinate = np.arange(known.size) < known.n
    return np.where(is_coordinate, x, 0.0), np.where(is_coordinate, 0.0, x)


def running_change(
    cycle: Cycle, running: RunningModes, ahead: tuple[Beside, Cycle], behind: tuple[Beside, Cycle]
) -> Array:
    """Give half of what changes in log(multiplier) of disturbances from one motion to another ``(multipliers,)``.

    A simple multiplier mu of the cycle's matrix T changes by y^H dT x/(y^H x), with its left and right eigenvectors
    (Golub and Van Loan, Matrix Computations (2013), section 7.2.2). dT x is what a load adds in a cycle: minus what the
    other tangents leave over of the disturbance that begins with x.

    Parameters
    ----------
    cycle
        The motion.
    running
        Its disturbances.
    ahead, behind
        Machines as far to both sides of its own, and their motions.

    Raises
    ------
    DerivativeError
        When multipliers are so near to each other that they have no derivatives.
    """
    steps, sides = cycle.steps, (ahead, behind)
    values, left, right = scipy.linalg.eig(steps.whole, left=True)
    by_q = np.zeros((len(steps.ends), steps.n, steps.n))
    for sign, (other, motion) in zip((0.5, -0.5), sides):
        for k, blows in motion.blows.items():
            by_q[k] += sign * blows.by_q / other.pace
    changes = []
    for value in running.multipliers:
        i = int(np.argmin(np.abs(values - value)))
        if np.sort(np.abs(values - values[i]))[1] < ALIKE * abs(value):
            raise DerivativeError(f"the multiplier {value:.6g} is one of several that are alike")
        y, x = left[:, i], right[:, i]
        if not abs(size := np.vdot(y, x)) * CONDITION > np.linalg.norm(y) * np.linalg.norm(x):
            raise DerivativeError(f"the multiplier {value:.6g} meets another one")
        parts = (x.real, x.imag) if value.imag else (x.real,)
        ends = [_added(cycle, part, sides, by_q) for part in parts]
        changes.append(sum(f * np.vdot(y, end) for f, end in zip((1, 1j), ends)) / (size * value))
    return np.array(changes, dtype=complex)


def _added(cycle: Cycle, start: Array, sides: Sequence[tuple[Beside, Cycle]], by_q: Array) -> Array:
    """Give half of what the motions on both sides add to the end of a disturbance by its start ``(2 n,)``."""
    steps, path, n = cycle.steps, cycle.path, cycle.path.n
    disturbance = steps.along(start)
    left = []
    for other, motion in sides:
        state = other.path(disturbance).at(path.tableau.c)[1:]
        left.append(other.carried(motion.evaluation, *(x.reshape(path.a[..., 0].size, -1) for x in state)))
    right = np.zeros_like(path.a)
    right[..., : sides[0][0].kept] = ((left[1] - left[0]) / 2).reshape(*path.a.shape[:2], -1)
    ends, gaps = disturbance.at(np.ones(1))[1][:, 0, :n], np.zeros((len(path.starts), 2 * n))
    gaps[:, n:] = steps.unit * np.einsum("kij,kj->ki", by_q, ends)
    return steps.through(np.zeros((1, 2 * n)), right, gaps)[0][0]
