"""A damped oscillator under a load that is linear in time: the exact answer (5.12)-(5.13), with damping (E.13)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array


@dataclass(frozen=True)
class Oscillators:
    """Many oscillators ``y'' + 2 zeta omega y' + omega^2 y = p(t)``, arrays of one shape.

    Their state is y and y'/omega, both (m sqrt(kg)), along a new last axis.

    Parameters
    ----------
    omega
        Circular frequencies (rad/s).
    zeta
        Damping ratios, 0 <= zeta < 1.
    """

    omega: Array
    zeta: Array

    def transition(self, time: Array | float) -> Array:
        """Matrix from the state at 0 to the free state after `time`, shape ``(..., 2, 2)``.

        Parameters
        ----------
        time
            Duration (s), a number or of a shape that goes with the oscillators'.
        """
        root = np.sqrt(1 - self.zeta**2)
        decay = np.exp(-self.zeta * self.omega * time)
        c = decay * np.cos(root * self.omega * time)
        s = decay * np.sin(root * self.omega * time) / root
        return np.stack([np.stack([c + self.zeta * s, s], -1), np.stack([-s, c - self.zeta * s], -1)], -2)

    def particular(self, load: Array, slope: Array, time: Array | float) -> Array:
        """State at `time` that follows the load ``load + slope t`` without free vibration, ``(..., 2)``.

        Parameters
        ----------
        load
            p at 0 (N/sqrt(kg)), of the oscillators' shape.
        slope
            Its rate (N/(s sqrt(kg))), of the same shape.
        time
            When (s).
        """
        y = (load + slope * time) / self.omega**2 - 2 * self.zeta * slope / self.omega**3
        return np.stack([y, slope / self.omega**3], -1)

    def forced(self, load: Array, slope: Array, time: Array | float) -> Array:
        """State at `time` from rest at 0, the Duhamel integral of (5.12), ``(..., 2)``.

        Parameters
        ----------
        load, slope, time
            As of `particular`.
        """
        start = self.particular(load, slope, 0.0)
        return self.particular(load, slope, time) - np.einsum("...ij,...j->...i", self.transition(time), start)
