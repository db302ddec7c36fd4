"""Errors of natural frequencies, and the harmonics of a load that would be felt on a mode."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array


@dataclass(frozen=True)
class FrequencyLimits:
    """How the errors of natural frequencies are estimated."""

    largest_known: float = 0.2  # of a natural frequency: beyond it the first order says no more
    positions: int = 8  # of the cycle, at which modes are looked at


FREQUENCY = FrequencyLimits()


def highest_felt(load: Array, static: Array, loss: float, enough: float) -> int:
    """Give the number of the highest harmonic of a load that would be felt on a mode; 0 where none would."""
    # load, static: the load and its static answer at equal steps of time, ``(angles, coordinates)`` each
    spectrum = np.fft.rfft(np.stack([load, static]), axis=1) * (2 / len(load))
    harmonics = np.sqrt(np.abs(np.einsum("hi,hi->h", spectrum[0], spectrum[1].conj())))
    least = loss * enough + np.finfo(float).tiny
    return int(np.flatnonzero(harmonics > least).max(initial=0))
