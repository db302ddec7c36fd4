"""Strain of a material whose stress goes with the strain's rate too."""

from __future__ import annotations

import math

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.scene import Scene


def elastic_strain(scene: Scene, stress: Array, every: int = 1) -> Array:
    """Strain of a stress over the modulus, ``(angles, ...)``, of which a part goes with the strain's rate."""
    # Where only one position of a few is given, `every` says of how many.
    retardation = scene.damping.material
    if retardation and scene.analysis.method == "periodic":
        return _elastic_part(stress, retardation, scene.period)
    if retardation and scene.analysis.method == "transient":
        return delayed(stress, retardation, every * scene.period / scene.analysis.sub_intervals)
    return stress


def _elastic_part(total: Array, material: float, period: float) -> Array:
    """Solve ``strain + material * d strain/dt = total`` over a cycle of that period (s), harmonic by harmonic."""
    harmonics = np.fft.rfft(total, axis=0)
    omega = 2 * np.pi / period * np.arange(len(harmonics))
    lag = (1 + 1j * omega * material).reshape(-1, *(1,) * (total.ndim - 1))
    return np.fft.irfft(harmonics / lag, n=len(total), axis=0)


def delayed(stress: Array, retardation: float, step: float) -> Array:
    """Solve ``strain + retardation strain' = stress/E`` in time, exactly for a stress that is a cubic spline."""
    # In each step the strain is ``sum (-retardation)^m`` times the m-th derivative of the stress, and a part that
    # dies out. It begins as if it did not change.
    # stress: stress over the modulus at equal steps of time, ``(times, ...)``
    from scipy.interpolate import CubicSpline  # noqa: PLC0415  (slow to import, and few scenes need them)
    from scipy.signal import lfilter  # noqa: PLC0415

    cubic, square, slope, start = CubicSpline(step * np.arange(len(stress)), stress).c
    polynomial = np.stack([start, slope, 2 * square, 6 * cubic])  # derivatives at the start of each step
    shift = np.array([[step ** (m - k) / math.factorial(m - k) if m >= k else 0.0 for m in range(4)] for k in range(4)])
    by_order = (-retardation) ** np.arange(4.0)
    forced_start, forced_end = np.tensordot(np.stack([by_order, by_order @ shift]), polynomial, 1)
    decay = math.exp(-step / retardation)
    gain = np.concatenate([stress[:1], forced_end - decay * forced_start])
    return lfilter([1.0], [1.0, -decay], gain, axis=0)
