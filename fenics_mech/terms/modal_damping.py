"""Damping ratios of modes as a viscous stress of beams, stated in the rates of their strains."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.beams.made_once import LastMade
from fenics_mech.geometry import harmonics
from fenics_mech.geometry.charts import Complex


@dataclass(frozen=True)
class ModalDamping:
    """Stress P . (rates of the strains) of the modes of a machine that is held at each position of its cycle.

    With the strains e_i of its mode i of unit mass and the stiffness D of the strains, P is the sum of
    ``2 zeta_i/w_i^3 (D e_i)(D e_i)^T``. So a small vibration in mode i has the ratio zeta_i, and a rigid motion has no
    drag. P is smooth where modes cross or veer, as single modes are not; it is interpolated, and split into modes anew.

    Parameters
    ----------
    patterns
        Stresses that all modes of the cycle consist of ``(elements, strains, patterns)``.
    exponents, coefficients
        P between these patterns, over time: ``(harmonics,)`` (1/s) and ``(harmonics, patterns, patterns)``.
    modes
        Modes at each instant.
    clock
        Time in the cycle by time; None where both are one.
    """

    patterns: Array
    exponents: Complex
    coefficients: Complex
    modes: int
    clock: Callable[[Array], Array] | None = None
    _last: LastMade = field(default_factory=lambda: LastMade(4), repr=False, compare=False)

    @classmethod
    def of(cls, stiffness: Array, strains: Sequence[Array], lags: Sequence[Array], period: float) -> ModalDamping:
        """Make it of the modes at even positions of a cycle."""
        # stiffness (elements, strains, strains) (N m); strains (elements, strains, modes); lags (s)
        half = np.linalg.cholesky(stiffness)
        shape = stiffness.shape[:2]
        roots = [
            (np.einsum("eji,ejk->eik", half, strain) * np.sqrt(lag)).reshape(math.prod(shape), len(lag))
            for strain, lag in zip(strains, lags)
        ]
        left, sizes, _ = np.linalg.svd(np.hstack(roots), full_matrices=False)
        left = left[:, sizes > NEGLIGIBLE * sizes[0]]
        parts = [left.T @ root for root in roots]
        exponents, coefficients = harmonics(np.array([part @ part.T for part in parts]), period)
        modes = min(left.shape[1], max(len(lag) for lag in lags))
        return cls(half @ left.reshape(*shape, -1), exponents, coefficients, modes)

    def at(self, t: Array) -> Array:
        """Give E, with E E^T = P, at some instants: ``(instants, elements, strains, modes)``."""
        # Every step of Newton's method asks for the same instants.
        return self._last.once(t.tobytes(), self._at, t)

    def _at(self, t: Array) -> Array:
        t = t if self.clock is None else self.clock(t)
        between = np.tensordot(np.exp(np.outer(t, self.exponents)), self.coefficients, 1).real
        values, vectors = np.linalg.eigh(between)
        roots = vectors[..., -self.modes :] * np.sqrt(np.maximum(values[:, None, -self.modes :], 0.0))
        flat = self.patterns.reshape(-1, self.patterns.shape[-1]) @ roots
        return flat.reshape(len(t), *self.patterns.shape[:2], self.modes)


@dataclass
class HeldDamping:
    """Stress of modes as of `ModalDamping`, of a machine that is held where it comes to in time.

    Parameters
    ----------
    starts
        Instants from which each of the roots holds, ascending (s).
    roots
        E of each ``(elements, strains, modes)``.
    """

    starts: list[float]
    roots: list[Array]

    @property
    def modes(self) -> int:
        """Modes at each instant."""
        return int(self.roots[0].shape[-1])

    def at(self, t: Array) -> Array:
        """Give E at some instants ``(instants, elements, strains, modes)``; where one begins, the one before holds."""
        return np.array([self.roots[max(k, 0)] for k in np.searchsorted(self.starts, t, side="left") - 1])


NEGLIGIBLE = 1e-7  # of the largest pattern: its square is the share of P that is left out
