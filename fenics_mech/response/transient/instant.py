"""The scaled equation of motion at an instant: what is left of it at a state, its tangents, its accelerations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, Index, solved
from fenics_mech.response.transient.coefficients import Coefficients


@dataclass(frozen=True)
class Instant:
    """``M z'' + C z' + K z + law = f`` for coordinates z that the `coefficients` scale."""

    coefficients: Coefficients

    @property
    def linear(self) -> bool:
        """Whether the equation is linear."""
        return self.coefficients.law is None

    def residuals(self, time: Array, z: Array, rate: Array, second: Array) -> Array:
        """Give `residual` at several times, ``(times, coordinates)``."""
        return np.stack([self.residual(*here) for here in zip(time.tolist(), z, rate, second)])

    def tangents_at(self, time: Array, z: Array, rate: Array, second: Array) -> tuple[Array, Array, Array]:
        """Give `tangents` at several times, ``(times, coordinates, coordinates)`` each."""
        found = [self.tangents(*here) for here in zip(time.tolist(), z, rate, second)]
        mass, damping, stiffness = (np.stack(part) for part in zip(*found))
        return mass, damping, stiffness

    def accelerations(self, time: Array, z: Array, rate: Array) -> Array:
        """Give `acceleration` at several times, ``(times, coordinates)``."""
        return np.stack([self.acceleration(*here) for here in zip(time.tolist(), z, rate)])

    def residual(self, time: float, z: Array, rate: Array, second: Array) -> Array:
        """``M z'' + C z' + K z + law - f``.

        Parameters
        ----------
        time
            Time (s).
        z, rate, second
            z (sqrt(J)), z' and z'' there, ``(coordinates,)`` each.

        Returns
        -------
        numpy.ndarray
            In sqrt(J), ``(coordinates,)``.
        """
        mass, damping, stiffness, load, *shape = self.coefficients.at(time)
        residual = mass @ second + damping @ rate + stiffness @ z - load
        law = self.coefficients.law
        if law is None:
            return residual
        p, first, *modal = shape
        v, v_rate = self._in_links(p, first, z, rate)
        ends = law.force(v, v_rate)
        if modal:  # C and K hold the linear part
            gradient = law.gradient(v)
            bending, tension = self._modal_rates(shape, gradient, z, rate)
            residual += modal[0].T @ bending
            ends = ends + tension[:, None] * gradient
        residual += _summed(law.dofs, ends, len(p)) @ p
        if (forces := self.coefficients.on_rotations(time)) is not None:
            residual += _summed(forces.dofs, forces.force(v, v_rate), len(p)) @ p
        if (spin := self.coefficients.spin) is not None:
            second_jet, alpha = self.coefficients.on_sections(time)
            v_second = self._accelerated(p, first, second_jet, (z, rate, second))
            residual += _summed(spin.dofs, spin.force(v, v_rate, v_second, alpha[None]), len(p)) @ p
        return residual

    def tangents(self, time: float, z: Array, rate: Array, second: Array | None = None) -> tuple[Array, Array, Array]:
        """M, and the tangents by z' and z.

        Parameters
        ----------
        time
            Time (s).
        z, rate, second
            z (sqrt(J)), z' and z'' there, ``(coordinates,)`` each; z'' matters where sections turn far and have
            inertia.

        Returns
        -------
        tuple
            Three matrices, ``(coordinates, coordinates)`` each.
        """
        mass, damping, stiffness, _, *shape = self.coefficients.at(time)
        law = self.coefficients.law
        if law is None:
            return mass, damping, stiffness
        p, first, *modal = shape
        v, v_rate = self._in_links(p, first, z, rate)
        _, by_v, by_rate = law.about(v, v_rate)[0]
        here, turned = p[law.dofs], first[law.dofs]
        if modal:
            outward, by_place, axial = modal
            gradient, gained = law.gradient(v), law.gradient((p @ rate + first @ z)[None])
            by_v = by_v + self._modal_rates(shape, gradient, z, rate)[1][:, None, None] * law.bow
            steeper = axial @ np.einsum("sn,snj->sj", gradient[0], here)
            turning = axial @ (np.einsum("sn,snj->sj", gradient[0], turned) + np.einsum("sn,snj->sj", gained[0], here))
            whole = outward + steeper
            damping = damping + whole.T @ whole - outward.T @ outward
            stiffness = stiffness + whole.T @ (by_place + turning) - outward.T @ by_place
        blocks = [(here, turned, by_v, by_rate)]
        if (forces := self.coefficients.on_rotations(time)) is not None:
            blocks.append((p[forces.dofs], first[forces.dofs], *forces.linearised(v, v_rate)[1:]))
        for here, turned, by_v, by_rate in blocks:
            back = here.reshape(-1, len(z)).T
            damping = damping + back @ (by_rate[0] @ here).reshape(-1, len(z))
            moved = by_rate[0] @ turned if self.coefficients.coupled else 0.0
            stiffness = stiffness + back @ (by_v[0] @ here + moved).reshape(-1, len(z))
        if self.coefficients.spin is None:
            return mass, damping, stiffness
        state = z, rate, np.zeros_like(z) if second is None else second
        whole = zip((mass, damping, stiffness), self._of_sections(time, p, first, state))
        mass, damping, stiffness = (part + more for part, more in whole)
        return mass, damping, stiffness

    def _of_sections(self, time: float, p: Array, first: Array, state: tuple[Array, Array, Array]) -> list[Array]:
        """Share of M and of the tangents by z' and z that the inertia of sections has where axes turn far."""
        spin, (second_jet, alpha) = self.coefficients.spin, self.coefficients.on_sections(time)
        assert spin is not None
        v, v_rate = self._in_links(p, first, *state[:2])
        v_second = self._accelerated(p, first, second_jet, state)
        k, d, m = (part[0] for part in spin.linearised(v, v_rate, v_second, alpha[None])[1:])
        here, turned, bent = (jet[spin.dofs] for jet in (p, first, second_jet))
        carried, size = here.reshape(-1, len(state[0])).T, len(state[0])
        coupled = float(self.coefficients.coupled)
        blocks = m @ here, d @ here + 2 * coupled * m @ turned, k @ here + coupled * (d @ turned + m @ bent)
        return [carried @ block.reshape(-1, size) for block in blocks]

    def _accelerated(self, p: Array, first: Array, second: Array, state: tuple[Array, Array, Array]) -> Array:
        """Give v'' of the links, ``(1, links' coordinates)``, as `_in_links`; `second` is P''."""
        z, rate, acceleration = state
        found = p @ acceleration
        return (found + 2 * first @ rate + second @ z if self.coefficients.coupled else found)[None]

    def _modal_rates(self, shape: list[Array], gradient: Array, z: Array, rate: Array) -> tuple[Array, Array]:
        """What bending adds to the modes' rates, and the elements' tension by them; see `NonlinearModalForces`."""
        (p, first, outward, by_place, axial), law = shape, self.coefficients.law
        assert law is not None
        bending = axial @ np.sum(gradient * (p @ rate + first @ z)[law.dofs], axis=-1)[0]
        return bending, (outward @ rate + by_place @ z + bending) @ axial

    def _in_links(self, p: Array, first: Array, z: Array, rate: Array) -> tuple[Array, Array]:
        """Give v and v' of the links, ``(1, links' coordinates)``; v' counts P' with the coupling only."""
        v_rate = p @ rate + first @ z if self.coefficients.coupled else p @ rate
        return (p @ z)[None], v_rate[None]

    def growth(self, time: float, z: Array, rate: Array) -> float:
        """Rate at which a nonlinear law lets a motion grow from a state (1/s); 0 without a law.

        Parameters
        ----------
        time, z, rate
            As of `tangents`.
        """
        if self.coefficients.law is None:
            return 0.0
        mass, _, stiffness = (part[None] for part in self.tangents(time, z, rate))
        return growth(mass, stiffness)

    def acceleration(self, time: float, z: Array, rate: Array) -> Array:
        """Give z'' at a state.

        Parameters
        ----------
        time, z, rate
            As of `tangents`.

        Returns
        -------
        numpy.ndarray
            In sqrt(J)/s^2, ``(coordinates,)``.
        """
        residual = self.residual(time, z, rate, np.zeros_like(z))
        mass = self.coefficients.at(time)[0] if self.coefficients.spin is None else self.tangents(time, z, rate)[0]
        return solved(mass, -residual)


def _summed(dofs: Index, forces: Array, size: int) -> Array:
    """Sum forces ``(1, ...)`` of the shape of `dofs`."""
    return np.asarray(np.bincount(dofs.ravel(), weights=forces.ravel(), minlength=size), dtype=float)


def growth(mass: Array, stiffness: Array) -> float:
    """Largest rate at which a motion without vibration grows (1/s), where the stiffness is not positive; else 0.

    Parameters
    ----------
    mass, stiffness
        M and K, ``(instants, coordinates, coordinates)`` each.
    """
    try:
        np.linalg.cholesky(stiffness + stiffness.transpose(0, 2, 1))
    except np.linalg.LinAlgError:
        squares = np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real
        return float(np.sqrt(max(0.0, -squares.min())))
    return 0.0
