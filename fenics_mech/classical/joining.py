"""Sub-intervals with constant coefficients: the answer of every mode inside one, and what joins them (chapter 5).

The state of a mode is (B, A) of (5.12): y, and y' over omega. Inside a sub-interval its load is linear in time.
"""

from __future__ import annotations

import math
import weakref
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from fenics_mech._arrays import Array, times
from fenics_mech._petsc import DIRECT, PETSc, configured, name_of, to_petsc
from fenics_mech.classical.modes import Modes, closing
from fenics_mech.errors import SolverError, UnresolvedError

LEFT = 1e-8  # of the right-hand side, that the answer of the system (5.16) may leave
MOST_ADVISED = 1000  # sub-intervals: beyond, other ways cost less
RINGING = 0.02  # of the whole amplitude: by how much a mode may ring that the sub-intervals do not follow


def free(omega: Array, zeta: Array, time: Array) -> Array:
    """From the states at 0 to those at `time` without load, (5.12), (5.13) with the damping of (E.13)."""
    # `omega` and `zeta` are (positions, modes), `time` is (positions, 1) (s). Matrices are (positions, modes, 2, 2).
    root, decay = np.sqrt(1 - zeta**2), np.exp(-zeta * omega * time)
    c, s = decay * np.cos(root * omega * time), decay * np.sin(root * omega * time) / root
    return np.stack([np.stack([c + zeta * s, s], -1), np.stack([-s, c - zeta * s], -1)], -2)


def steady(omega: Array, zeta: Array, load: Array, slope: Array, time: Array | float = 0.0) -> Array:
    """States that follow the load ``load + slope t`` without vibration, ``(positions, modes, 2)``."""
    y = (load + slope * time) / omega**2 - 2 * zeta * slope / omega**3
    return np.stack([y, slope / omega**3], -1)


def forced(omega: Array, zeta: Array, load: Array, slope: Array, time: Array) -> Array:
    """States at `time` from rest at 0: the integrals of (5.12), (5.13) of that load, ``(positions, modes, 2)``."""
    from_rest = np.einsum("kmij,kmj->kmi", free(omega, zeta, time), steady(omega, zeta, load, slope))
    return steady(omega, zeta, load, slope, time) - from_rest


def joins(how: str, modes: Modes, zeta: Array, straining: Array, step: Array) -> Array:
    """From the states at the end of each sub-interval to those at the start of the next."""
    # zeta (positions, modes); straining (positions, modes, modes) (1/s); step (positions, 1) (s)
    # These are y_{k+1} = J y_k and y'_{k+1} = J y'_k + L y_k with J = Phi_{k+1}^T M_{k+1} Phi_k. At a join the modes
    # kept lose the displacement l = (Phi_k - Phi_{k+1} J) y_k. The physical join gives back its momentum Phi_k^T M_k
    # l/h: L = J (1 - B J)/h with B = Phi_k^T M_k Phi_{k+1}. Damping goes with the rate at which links are strained.
    # What their turning adds to it acts as impulses, each of half a sub-interval on both sides of a join.
    omega, count = modes.omega, modes.omega.shape[1]
    J, L = modes.ahead, np.zeros_like(modes.ahead)
    if how == "modal":
        J = np.tile(np.eye(count), (len(omega), 1, 1))
        J[-1] = closing(modes)
    else:
        impulse = step[..., None] / 2 * (2 * zeta * omega)[..., None] * straining  # (E.12)
        L = -(J @ impulse + np.roll(impulse, -1, axis=0) @ J)
    if how == "physical":
        L += J @ (np.eye(count) - modes.back @ J) / step[..., None]
    ahead = np.roll(omega, -1, axis=0)[..., None]
    upper = np.concatenate([J, np.zeros_like(J)], axis=2)
    return np.concatenate([upper, np.concatenate([L / ahead, J * omega[:, None, :] / ahead], axis=2)], axis=1)


def refuse_ringing(omega: Array, period: float, count: int, share: Array) -> None:
    """Raise where modes ring that swing more than once in two sub-intervals."""
    # omega (positions, modes) (rad/s); period (s); share (modes,)
    # The coefficients jump at the joins. A mode that swings a whole number of times in a sub-interval meets each jump
    # in the same phase.
    fastest = omega.max(axis=0) / (2 * np.pi)
    fast = 2 * fastest * period > count
    if (rings := fast & (share > RINGING)).any():
        mode, slow, enough = int(np.argmax(share * rings)), int((~fast).sum()), math.ceil(2 * fastest.max() * period)
        ways = [f"keep {slow} mode{'s' * (slow > 1)}"] if slow else []
        ways += [f"take at least {enough} sub_intervals"] if enough <= MOST_ADVISED else []
        said = ", or ".join([*ways, "add 'coupling' to effects, whose equation is solved without modes"])
        raise UnresolvedError(
            f"mode {mode + 1} ({fastest[mode]:.4g} Hz) is too fast for these sub_intervals, at whose joins it is set "
            f"vibrating. {said[0].upper()}{said[1:]}; analysis.allow_ringing lets it pass, and analysis.allow_coarse "
            "what the error estimate may refuse then"
        ).finer_by(sub_intervals=enough)


def flat(states: Array) -> Array:
    """States ``(positions, modes, 2)`` as vectors, all y before all y' over omega, ``(positions, 2 modes)``."""
    return states.transpose(0, 2, 1).reshape(len(states), -1)


def whole(matrices: Array) -> Array:
    """Matrices of the modes ``(positions, modes, 2, 2)`` as matrices of such vectors."""
    return np.einsum("kmij,mn->kimjn", matrices, np.eye(matrices.shape[1])).reshape(
        len(matrices), *(2 * matrices.shape[1],) * 2
    )


@dataclass(frozen=True, eq=False)
class Closed:
    """All sub-intervals with the last joined to the first: (5.14) and (5.15), as the system (5.16)."""

    transitions: Array  # from the start of each to the start of the next, (positions, n, n)
    options: Mapping[str, Any]  # PETSc options with the prefix "periodic_"

    @cached_property
    def _ksp(self) -> PETSc.KSP:
        """The KSP with its matrix, destroyed with this."""
        count, n, _ = self.transitions.shape
        behind = sp.bsr_matrix(
            (np.roll(self.transitions, 1, axis=0), np.roll(np.arange(count), 1), np.arange(count + 1))
        )
        matrix = to_petsc((sp.identity(count * n, format="csr") - behind.tocsr()).sorted_indices())
        ksp = PETSc.KSP().create(comm=PETSc.COMM_SELF)
        weakref.finalize(self, ksp.destroy)
        ksp.setOperators(matrix)
        matrix.destroy()  # the KSP holds it
        return ksp

    def solve(self, right: Array) -> Array:
        """Give the states at the starts, ``(positions, n)``."""
        # right (positions, n)
        loads, ksp = np.roll(right, 1, axis=0), self._ksp
        b, x = ksp.getOperators()[0].createVecs()
        with configured(ksp, "periodic_", DIRECT, self.options, keep=True):
            b.array[:] = loads.ravel()
            ksp.solve(b, x)
            reason, states = ksp.getConvergedReason(), x.array_r.reshape(right.shape).copy()
        for vector in (b, x):
            vector.destroy()
        left = states - np.roll(times(self.transitions, states), 1, axis=0) - loads
        if reason <= 0 or not np.linalg.norm(left) <= LEFT * np.linalg.norm(loads):
            said = name_of(PETSc.KSP.ConvergedReason, reason)
            raise SolverError(
                f"the sub-intervals could not be joined to a cycle (PETSc says {said}). Without damping the drive may "
                "be at resonance: give a damping ratio, or other solver options"
            )
        return states

    roughly = solve

    def terms(self, states: Array) -> Array:
        """Give the size of what adds up to the states at the next starts, ``(positions, n)``; see `magnification`."""
        return times(np.abs(self.transitions), np.abs(states))


def marched(join: Array, half: Array, to_end: Array, to_middle: Array) -> Array:
    """States at the middles from rest in the middle of the first sub-interval on, ``(positions, n)``."""
    # join, half (positions, n, n) each
    states = np.zeros_like(to_end)
    for k in range(len(states) - 1):
        start = join[k] @ (half[k] @ states[k] + to_end[k])
        states[k + 1] = half[k + 1] @ start + to_middle[k + 1]
    return states
