"""The block-cyclic linear system that closes a cycle: ``z_{k+1} - T_k z_k = r_k`` with ``z_n = z_0``, (5.16)."""

from __future__ import annotations

import weakref
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from fenics_mech._arrays import Array, times
from fenics_mech._constants import TINY
from fenics_mech._petsc import DIRECT, PETSc, configured, name_of, to_petsc
from fenics_mech.errors import SolverError


@dataclass(frozen=True)
class CyclicLimits:
    """Limits of the system of a cycle: how exactly it is solved, and when its numbers are lost to rounding."""

    tolerance: float = 1e-13  # of the system, relative to what is added in the steps
    tolerance_of_change: float = 1e-11  # the same where a small change of a known motion is sought
    tolerance_of_estimate: float = 1e-6  # where the answer itself is an estimate, of which few digits count
    least_reduction: float = 1e-2  # of the residual, however good the guess is
    largest_residual: float = 1e-8  # of the system, relative to its right-hand side
    above: float = 2.0  # times the tolerance of an answer, which by rounding it may miss by
    rounding: float = 100.0  # times that, as a share of the states: what very fine meshes round by is less
    most_direct: float = 5e7  # numbers of the matrices of a cycle, up to which they are made
    terms: float = 4.0  # of the size of a number, that add up to it in a step
    growth: float = 1e3  # of a state since the last cut, at which the march is cut
    most_blocks: int = 24  # that PETSc gets where states grow; else it gets one: whole products make two steps one
    growth_of_pairs: float = 10.0  # of the largest coefficient in two steps: beyond it rounding grows in such products
    smallest_state: float = 1e-150  # norm, from which a state is scaled up again before it is lost
    largest_spread: float = 1e12  # of the fastest coordinate's frequency over the slowest one's
    fastest: float = 1e14  # rad in a step; measured: right at 5e13, and multipliers next to 1 of no vibration at 5e15
    largest_series_error: float = 1e-3  # of the motion, by the harmonics of a series


CYCLIC = CyclicLimits()


@dataclass(frozen=True, eq=False)
class BlockCyclic:
    """The system of a cycle. What is factorised for the first load is kept for others.

    Parameters
    ----------
    transitions
        T, from the state at the start of each step to that at its end, ``(steps, state, state)``.
    options
        PETSc options with the prefix "periodic_".
    """

    transitions: Array
    options: Mapping[str, Any]

    def solve(self, right: Array) -> Array:
        """Solve for the states at the starts of all steps, ``(steps, state)``, or of several cycles.

        Parameters
        ----------
        right
            What the load adds to the state in each step, ``(steps, state)``, or with several loads
            ``(steps, state, loads)``.

        Raises
        ------
        SolverError
            When the KSP does not converge or its answer is not accurate, as at an undamped resonance.
        """
        if right.ndim == 2:
            return self.solve(right[..., None])[..., 0]
        if len(right) == 1 or (len(right) <= CYCLIC.most_blocks and self._grows):
            return self._solved(right)
        first, second = slice(0, len(right) - 1, 2), slice(1, None, 2)
        over_pairs = right[second] + self.transitions[second] @ right[first]
        if odd := len(right) % 2:
            over_pairs = np.append(over_pairs, right[-1:], axis=0)
        states = np.empty_like(right)
        states[::2] = self._of_pairs.solve(over_pairs)
        starts = states[::2][:-1] if odd else states[::2]
        states[1::2] = right[first] + self.transitions[first] @ starts
        return states

    def roughly(self, right: Array) -> Array:
        """Solve as `solve` does.

        Parameters
        ----------
        right
            As of `solve`.
        """
        return self.solve(right)

    def terms(self, states: Array) -> Array:
        """Give the size of what adds up to the states at the ends of the steps, from those at their starts.

        Parameters
        ----------
        states
            The states at the starts, ``(steps, state)``.

        Returns
        -------
        numpy.ndarray
            Of the same shape.
        """
        return times(np.abs(self.transitions), np.abs(states))

    @cached_property
    def _of_pairs(self) -> BlockCyclic:
        """The same system, two steps made one; of an odd number the last is left."""
        parts = self.transitions
        pairs = parts[1::2] @ parts[: len(parts) - 1 : 2]
        return BlockCyclic(np.append(pairs, parts[-1:], axis=0) if len(parts) % 2 else pairs, self.options)

    @cached_property
    def _grows(self) -> bool:
        """Whether the states of two steps grow too much for them to be made one."""
        return bool(np.abs(self._of_pairs.transitions).max() > CYCLIC.growth_of_pairs * np.abs(self.transitions).max())

    @cached_property
    def _ksp(self) -> PETSc.KSP:
        """The KSP, destroyed with this; row k + 1 of its system has the transition of k, row 0 that of the last."""
        ksp = PETSc.KSP().create(comm=PETSc.COMM_SELF)
        weakref.finalize(self, ksp.destroy)
        matrix = _assembled(self.transitions)
        ksp.setOperators(matrix)
        matrix.destroy()  # the KSP holds it
        return ksp

    def _solved(self, right: Array) -> Array:
        """Solve by the KSP."""
        loads, ksp = np.roll(right, 1, axis=0), self._ksp
        flat = loads.reshape(-1, loads.shape[-1])
        answers, reasons = np.empty_like(flat), []
        b, x = ksp.getOperators()[0].createVecs()
        with configured(ksp, "periodic_", DIRECT, self.options, keep=True):
            for load, answer in zip(flat.T, answers.T):
                b.array[:] = load
                ksp.solve(b, x)
                answer[:] = x.array_r
                reasons.append(ksp.getConvergedReason())
        for vector in (b, x):
            vector.destroy()
        states = answers.reshape(right.shape)
        if not np.isfinite(states).all():
            states[:] = np.finfo(float).max ** 0.25  # leaves a residual that no answer has
        left_over = states - np.roll(self.transitions @ states, 1, axis=0) - loads
        sizes = np.maximum(np.linalg.norm(loads, axis=(0, 1)), TINY)
        found = min(reasons, key=np.sign)
        residual = float((np.linalg.norm(left_over, axis=(0, 1)) / sizes).max())
        if found <= 0 or not residual < CYCLIC.largest_residual:
            raise not_closed(found, residual, grows=len(right) > 1 and self._grows)
        return states


def not_closed(
    reason: int, residual: float, grows: bool = False, what: str = "the periodic system has no reliable answer"
) -> SolverError:
    """Give the error of a cycle that could not be closed.

    Parameters
    ----------
    reason
        Why PETSc stopped.
    residual
        Residual of the answer, relative to the right-hand side.
    grows
        Whether states grow much within the cycle.
    what
        What failed, in words.
    """
    why = "Without damping the drive may be at resonance: give a damping ratio, or other solver options"
    if grows:
        why = "Some motion grows too fast: a member buckles, or the drive is far inside a tongue of resonance"
    stopped = name_of(PETSc.KSP.ConvergedReason, reason)
    return SolverError(f"{what} (PETSc says {stopped}, relative residual {residual:.1e}). {why}")


def _assembled(blocks: Array) -> PETSc.Mat:
    """Put the blocks of the system into a sparse matrix."""
    count, size, _ = blocks.shape
    behind = sp.bsr_matrix((np.roll(blocks, 1, axis=0), np.roll(np.arange(count), 1), np.arange(count + 1)))
    return to_petsc((sp.identity(count * size, format="csr") - behind.tocsr()).sorted_indices())
