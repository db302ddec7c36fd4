"""Strain of a material whose stress goes with the strain's rate too."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def elastic_part(total: Array, material: float, period: float) -> Array:
    """Solve ``strain + material * d strain/dt = total`` over a cycle, harmonic by harmonic.

    Parameters
    ----------
    total
        Stress over E, at equal steps of a whole cycle, ``(angles, ...)``.
    material
        Retardation time of the material (s).
    period
        Duration of the cycle (s).
    """
    harmonics = np.fft.rfft(total, axis=0)
    omega = 2 * np.pi / period * np.arange(len(harmonics))
    lag = (1 + 1j * omega * material).reshape(-1, *(1,) * (total.ndim - 1))
    return np.fft.irfft(harmonics / lag, n=len(total), axis=0)
