"""The block-cyclic linear system that closes a cycle: ``z_{k+1} - T_k z_k = r_k`` with ``z_n = z_0``, (5.16)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from petsc4py import PETSc

from fenics_mech._arrays import times
from fenics_mech._petsc import DIRECT, configured, name_of, to_petsc
from fenics_mech.errors import SolverError

Array = NDArray[np.float64]
LARGEST_RESIDUAL = 1e-8  # of the system, relative to its right-hand side
MOST_BLOCKS = 24  # that PETSc gets: beyond it, two steps of the cycle are made one, in products of whole arrays


def solve_cycle(transitions: Array, right: Array, options: Mapping[str, Any]) -> Array:
    """Solve for the states at the starts of all steps of a cycle, ``(steps, state)``.

    Parameters
    ----------
    transitions
        T, from the state at the start of each step to that at its end, ``(steps, state, state)``.
    right
        What the load adds to the state in each step, ``(steps, state)``.
    options
        PETSc options with the prefix "periodic_".

    Raises
    ------
    SolverError
        When the KSP does not converge or its answer is not accurate, as at an undamped resonance.
    """
    if len(transitions) <= MOST_BLOCKS:
        return _solve(transitions, right, options)
    first, second = slice(0, len(transitions) - 1, 2), slice(1, None, 2)
    pairs = transitions[second] @ transitions[first]
    over_pairs = right[second] + times(transitions[second], right[first])
    if odd := len(transitions) % 2:
        pairs, over_pairs = np.append(pairs, transitions[-1:], axis=0), np.append(over_pairs, right[-1:], axis=0)
    states = np.empty_like(right)
    states[::2] = solve_cycle(pairs, over_pairs, options)
    starts = states[::2][:-1] if odd else states[::2]
    states[1::2] = right[first] + times(transitions[first], starts)
    return states


def _solve(blocks: Array, right: Array, options: Mapping[str, Any]) -> Array:
    """Solve by a KSP."""
    count, size, _ = blocks.shape
    block_rows = np.roll(np.arange(count), -1)  # row k + 1 holds the block of k, row 0 that of the last
    behind = sp.bsr_matrix((np.roll(blocks, 1, axis=0), np.roll(np.arange(count), 1), np.arange(count + 1)))
    cyclic = (sp.identity(count * size, format="csr") - behind.tocsr()).sorted_indices()
    matrix = to_petsc(cyclic)
    b, x = matrix.createVecs()
    b.array.reshape(count, size)[block_rows] = right
    ksp = PETSc.KSP().create(comm=PETSc.COMM_SELF)
    with configured(ksp, "periodic_", DIRECT, options):
        ksp.setOperators(matrix)
        ksp.solve(b, x)
        found = ksp.getConvergedReason()
    answer = x.array_r.copy()
    size_of_right = max(float(np.linalg.norm(right)), float(np.finfo(float).tiny))
    residual = float(np.linalg.norm(cyclic @ answer - b.array_r)) / size_of_right
    for thing in (matrix, b, x):
        thing.destroy()
    if found <= 0 or not residual < LARGEST_RESIDUAL:
        raise SolverError(
            f"the periodic system has no reliable answer (PETSc says {name_of(PETSc.KSP.ConvergedReason, found)}, "
            f"relative residual {residual:.1e}). Without damping the drive may be at resonance: give a damping ratio, "
            "or other solver options"
        )
    return answer.reshape(count, size)
