"""Sub-intervals with constant coefficients: the answer of every mode inside one, and what joins them (chapter 5).

The state of a mode is (B, A) of (5.12): y, and y' over omega. Inside a sub-interval its load is linear in time.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._petsc import DIRECT, PETSc, configured, name_of
from fenics_mech.classical.modes import Modes, closing
from fenics_mech.errors import SolverError, UnresolvedError

RINGING = 0.02  # of the whole amplitude: by how much a mode may ring that the sub-intervals do not follow


def free(omega: Array, zeta: Array, time: float) -> Array:
    """From the states at 0 to those at `time` without load, (5.12), (5.13) with the damping of (E.13).

    `omega` and `zeta` are ``(positions, modes)``, the matrices ``(positions, modes, 2, 2)``.
    """
    root, decay = np.sqrt(1 - zeta**2), np.exp(-zeta * omega * time)
    c, s = decay * np.cos(root * omega * time), decay * np.sin(root * omega * time) / root
    return np.stack([np.stack([c + zeta * s, s], -1), np.stack([-s, c - zeta * s], -1)], -2)


def steady(omega: Array, zeta: Array, load: Array, slope: Array, time: float = 0.0) -> Array:
    """States that follow the load ``load + slope t`` without vibration, ``(positions, modes, 2)``."""
    y = (load + slope * time) / omega**2 - 2 * zeta * slope / omega**3
    return np.stack([y, slope / omega**3], -1)


def forced(omega: Array, zeta: Array, load: Array, slope: Array, time: float) -> Array:
    """States at `time` from rest at 0: the integrals of (5.12), (5.13) of that load, ``(positions, modes, 2)``."""
    from_rest = np.einsum("kmij,kmj->kmi", free(omega, zeta, time), steady(omega, zeta, load, slope))
    return steady(omega, zeta, load, slope, time) - from_rest


def joins(how: str, modes: Modes, zeta: Array, straining: Array, step: float) -> Array:
    """From the states at the end of each sub-interval to those at the start of the next.

    These are ``y_{k+1} = J y_k`` and ``y'_{k+1} = J y'_k + L y_k`` with ``J = Phi_{k+1}^T M_{k+1} Phi_k``. At a join
    the modes kept lose the displacement ``l = (Phi_k - Phi_{k+1} J) y_k``. The physical join gives back its momentum
    ``Phi_k^T M_k l/h``: ``L = J (1 - B J)/h`` with ``B = Phi_k^T M_k Phi_{k+1}``.
    Damping goes with the rate at which links are strained. What their turning adds to it acts as impulses, each of half
    a sub-interval on both sides of a join.

    Parameters
    ----------
    how
        "physical", "projected", or "modal": each mode goes on by itself (5.14), as printed.
    modes
        The modes.
    zeta
        Damping ratios, ``(positions, modes)``.
    straining
        Rates at which turning strains the modes, ``(positions, modes, modes)`` (1/s).
    step
        Duration of a sub-interval (s).

    Returns
    -------
    numpy.ndarray
        ``(positions, 2 modes, 2 modes)``.
    """
    omega, count = modes.omega, modes.omega.shape[1]
    J, L = modes.ahead, np.zeros_like(modes.ahead)
    if how == "modal":
        J = np.tile(np.eye(count), (len(omega), 1, 1))
        J[-1] = closing(modes)
    else:
        impulse = step / 2 * (2 * zeta * omega)[..., None] * straining  # (E.12)
        L = -(J @ impulse + np.roll(impulse, -1, axis=0) @ J)
    if how == "physical":
        L += J @ (np.eye(count) - modes.back @ J) / step
    ahead = np.roll(omega, -1, axis=0)[..., None]
    upper = np.concatenate([J, np.zeros_like(J)], axis=2)
    return np.concatenate([upper, np.concatenate([L / ahead, J * omega[:, None, :] / ahead], axis=2)], axis=1)


def refuse_ringing(omega: Array, step: float, share: Array) -> None:
    """Raise where modes ring that swing more than once in two sub-intervals.

    The coefficients jump at the joins. A mode that swings a whole number of times in a sub-interval meets each jump in
    the same phase.

    Parameters
    ----------
    omega
        Frequencies (rad/s), ``(positions, modes)``.
    step
        Duration of a sub-interval (s).
    share
        Amplitude of each mode's free vibration over the whole amplitude, ``(modes,)``.

    Raises
    ------
    UnresolvedError
        When one of them vibrates by more than a fiftieth.
    """
    swings = omega.max(axis=0) * step / np.pi  # in two sub-intervals
    if (rings := (swings > 1) & (share > RINGING)).any():
        mode = int(rings.argmax())
        raise UnresolvedError(
            f"mode {mode + 1} ({omega[:, mode].max() / (2 * np.pi):.4g} Hz) is too fast for these sub_intervals, at "
            f"whose joins it is set vibrating: keep {int((swings <= 1).sum())} modes, or take "
            f"{math.ceil(swings.max())} times as many sub_intervals. analysis.allow_ringing lets it pass"
        )


def flat(states: Array) -> Array:
    """States ``(positions, modes, 2)`` as vectors, all y before all y' over omega, ``(positions, 2 modes)``."""
    return states.transpose(0, 2, 1).reshape(len(states), -1)


def whole(matrices: Array) -> Array:
    """Matrices of the modes ``(positions, modes, 2, 2)`` as matrices of such vectors."""
    return np.einsum("kmij,mn->kimjn", matrices, np.eye(matrices.shape[1])).reshape(
        len(matrices), *(2 * matrices.shape[1],) * 2
    )


def closed_cycle(join: Array, transition: Array, force: Array, options: Mapping[str, Any]) -> Array:
    """States at the starts of all sub-intervals, with the last joined to the first: (5.14) and (5.15), as (5.16).

    Parameters
    ----------
    join, transition
        From the end of each to the start of the next, and from its start to its end, ``(positions, n, n)``.
    force
        States at the ends from rest at the starts, ``(positions, n)``.
    options
        PETSc options with the prefix "periodic_".

    Raises
    ------
    SolverError
        When the KSP does not converge.
    """
    count, n = force.shape
    matrix = PETSc.Mat().createAIJ([count * n] * 2, nnz=n + 1, comm=PETSc.COMM_SELF)
    places = np.arange(count * n, dtype=PETSc.IntType).reshape(count, n)
    for k, block in enumerate(join @ transition):
        matrix.setValues(places[(k + 1) % count], places[k], -block)
    matrix.assemble()
    matrix.shift(1.0)
    right, answer = matrix.createVecs()
    right.array[:] = np.roll(np.einsum("kij,kj->ki", join, force), 1, axis=0).ravel()
    ksp = PETSc.KSP().create(comm=PETSc.COMM_SELF)
    ksp.setOperators(matrix)
    with configured(ksp, "periodic_", DIRECT, options):
        ksp.solve(right, answer)
        if ksp.getConvergedReason() < 0:
            reason = name_of(PETSc.KSP.ConvergedReason, ksp.getConvergedReason())
            raise SolverError(f"the sub-intervals could not be joined to a cycle (PETSc says {reason})")
        found = answer.array_r.reshape(count, n).copy()
    for thing in (matrix, right, answer):
        thing.destroy()
    return found


def marched(join: Array, half: Array, to_end: Array, to_middle: Array) -> Array:
    """States at the middles from rest in the middle of the first sub-interval on, ``(positions, n)``.

    Parameters
    ----------
    join, half
        From each end to the next start, and over half a sub-interval, ``(positions, n, n)``.
    to_end, to_middle
        States by the load, from rest at the middle to the end and from rest at the start to the middle.
    """
    states = np.zeros_like(to_end)
    for k in range(len(states) - 1):
        start = join[k] @ (half[k] @ states[k] + to_end[k])
        states[k + 1] = half[k + 1] @ start + to_middle[k + 1]
    return states
