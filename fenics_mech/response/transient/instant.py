"""The scaled equation of motion at an instant: what is left of it at a state, its tangents, its accelerations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.response.transient.coefficients import Coefficients


@dataclass(frozen=True)
class Instant:
    """``M z'' + C z' + K z + law = f`` for coordinates z that the `coefficients` scale."""

    coefficients: Coefficients

    def residual(self, time: float, z: Array, rate: Array, second: Array) -> Array:
        """``M z'' + C z' + K z + law - f``."""
        mass, damping, stiffness, load, *shape = self.coefficients.at(time)
        residual = mass @ second + damping @ rate + stiffness @ z - load
        law, dofs = self.coefficients.law, self.coefficients.dofs
        if law is None or dofs is None:
            return residual
        p, first = shape
        ends = law.force((p @ z)[None], (p @ rate + first @ z)[None])
        return residual + np.bincount(dofs.ravel(), weights=ends.ravel(), minlength=len(p)) @ p

    def tangents(self, time: float, z: Array, rate: Array) -> tuple[Array, Array, Array]:
        """M, and the tangents by z' and z."""
        mass, damping, stiffness, _, *shape = self.coefficients.at(time)
        law, dofs = self.coefficients.law, self.coefficients.dofs
        if law is None or dofs is None:
            return mass, damping, stiffness
        p, first = shape
        v, v_rate = (p @ z)[None], (p @ rate + first @ z)[None]
        _, by_v, by_rate = law.linearised(v, v_rate, law.tension(v, v_rate))
        here, turning = p[dofs], first[dofs]
        back = here.reshape(-1, len(z)).T
        damping = damping + back @ (by_rate[0] @ here).reshape(-1, len(z))
        stiffness = stiffness + back @ (by_v[0] @ here + by_rate[0] @ turning).reshape(-1, len(z))
        return mass, damping, stiffness

    def growth(self, time: float, z: Array, rate: Array) -> float:
        """Rate at which a nonlinear law lets a motion grow from a state (1/s); 0 without a law."""
        if self.coefficients.law is None:
            return 0.0
        mass, _, stiffness = (part[None] for part in self.tangents(time, z, rate))
        return growth(mass, stiffness)

    def acceleration(self, time: float, z: Array, rate: Array) -> Array:
        """Give z'' at a state."""
        residual = self.residual(time, z, rate, np.zeros_like(z))
        return np.linalg.solve(self.coefficients.at(time)[0], -residual)


def growth(mass: Array, stiffness: Array) -> float:
    """Largest rate at which a motion without vibration grows (1/s), where the stiffness is not positive; else 0.

    Both are ``(instants, coordinates, coordinates)``.
    """
    try:
        np.linalg.cholesky(stiffness + stiffness.transpose(0, 2, 1))
    except np.linalg.LinAlgError:
        squares = np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real
        return float(np.sqrt(max(0.0, -squares.min())))
    return 0.0
