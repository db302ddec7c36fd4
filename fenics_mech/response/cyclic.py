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
ITERATIVE = {"ksp_rtol": 1e-12, "ksp_max_it": 1000, "ksp_gmres_restart": 200}
LARGEST_RESIDUAL = 1e-8  # of the system, relative to its right-hand side
MOST_BLOCKS = 24  # that PETSc gets: beyond it, two steps of the cycle are made one, in products of whole arrays


def solve_cycle(transitions: Array, right: Array, options: Mapping[str, Any]) -> Array:
    """Solve for the states at the starts of all steps of a cycle, ``(steps, state)``, or of several cycles.

    Parameters
    ----------
    transitions
        T, from the state at the start of each step to that at its end, ``(steps, state, state)``.
    right
        What the load adds to the state in each step, ``(steps, state)``, or with several loads
        ``(steps, state, loads)``.
    options
        PETSc options with the prefix "periodic_". With an iterative periodic_ksp_type, and no periodic_pc_type, nothing
        is factorised: `_March` is the preconditioner.

    Raises
    ------
    SolverError
        When the KSP does not converge or its answer is not accurate, as at an undamped resonance.
    """
    if right.ndim == 2:
        return solve_cycle(transitions, right[..., None], options)[..., 0]
    if options.get("periodic_ksp_type", "preonly") != "preonly" and "periodic_pc_type" not in options:
        return _solve(transitions, right, options, _March(transitions))
    if len(transitions) <= MOST_BLOCKS:
        return _solve(transitions, right, options)
    first, second = slice(0, len(transitions) - 1, 2), slice(1, None, 2)
    pairs = transitions[second] @ transitions[first]
    over_pairs = right[second] + transitions[second] @ right[first]
    if odd := len(transitions) % 2:
        pairs, over_pairs = np.append(pairs, transitions[-1:], axis=0), np.append(over_pairs, right[-1:], axis=0)
    states = np.empty_like(right)
    states[::2] = solve_cycle(pairs, over_pairs, options)
    starts = states[::2][:-1] if odd else states[::2]
    states[1::2] = right[first] + transitions[first] @ starts
    return states


class _March:
    """The system as an operator, and as its preconditioner the march through the cycle from a state that is known.

    The march solves all of the system but that the last state is the first one again. Preconditioned so, the
    eigenvalues are 1 and, for each Floquet multiplier mu, ``1 - mu``: what dies out in a cycle costs no iteration.
    """

    def __init__(self, transitions: Array) -> None:
        self.transitions = transitions

    def mult(self, matrix: PETSc.Mat, x: PETSc.Vec, y: PETSc.Vec) -> None:
        states = x.array_r.reshape(len(self.transitions), -1)
        y.array[:] = (states - np.roll(times(self.transitions, states), 1, axis=0)).ravel()

    def apply(self, pc: PETSc.PC, x: PETSc.Vec, y: PETSc.Vec) -> None:
        states = x.array_r.reshape(len(self.transitions), -1).copy()
        for k, transition in enumerate(self.transitions[:-1]):
            states[k + 1] += transition @ states[k]
        y.array[:] = states.ravel()


def _solve(blocks: Array, right: Array, options: Mapping[str, Any], march: _March | None = None) -> Array:
    """Solve by a KSP; row k + 1 of the system has the transition of k, row 0 that of the last."""
    loads = np.roll(right, 1, axis=0)
    flat = loads.reshape(-1, loads.shape[-1])
    answers, reasons = np.empty_like(flat), []
    matrix, defaults = (_assembled(blocks), DIRECT) if march is None else (PETSc.Mat(), ITERATIVE)
    if march is not None:
        matrix.createPython((len(flat), len(flat)), context=march, comm=PETSc.COMM_SELF).setUp()
    b, x = matrix.createVecs()
    ksp = PETSc.KSP().create(comm=PETSc.COMM_SELF)
    with configured(ksp, "periodic_", defaults, options):
        ksp.setOperators(matrix)
        if march is not None:
            ksp.getPC().setType(PETSc.PC.Type.PYTHON)
            ksp.getPC().setPythonContext(march)
        for load, answer in zip(flat.T, answers.T):
            b.array[:] = load
            ksp.solve(b, x)
            answer[:] = x.array_r
            reasons.append(ksp.getConvergedReason())
    for thing in (matrix, b, x):
        thing.destroy()
    states = answers.reshape(right.shape)
    if not np.isfinite(states).all():
        states[:] = np.finfo(float).max ** 0.25  # leaves a residual that no answer has
    lack = states - np.roll(blocks @ states, 1, axis=0) - loads
    sizes = np.maximum(np.linalg.norm(loads, axis=(0, 1)), np.finfo(float).tiny)
    found = min(reasons, key=np.sign)
    residual = float((np.linalg.norm(lack, axis=(0, 1)) / sizes).max())
    if found <= 0 or not residual < LARGEST_RESIDUAL:
        raise SolverError(
            f"the periodic system has no reliable answer (PETSc says {name_of(PETSc.KSP.ConvergedReason, found)}, "
            f"relative residual {residual:.1e}). Without damping the drive may be at resonance: give a damping ratio, "
            "or other solver options"
        )
    return states


def _assembled(blocks: Array) -> PETSc.Mat:
    """Put the blocks of the system into a sparse matrix."""
    count, size, _ = blocks.shape
    behind = sp.bsr_matrix((np.roll(blocks, 1, axis=0), np.roll(np.arange(count), 1), np.arange(count + 1)))
    return to_petsc((sp.identity(count * size, format="csr") - behind.tocsr()).sorted_indices())
