"""Derivatives in time of what is known at equal steps of a cycle, and its values between them, by Fourier series."""

from __future__ import annotations

from typing import TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array

Values = TypeVar("Values", Array, NDArray[np.complex128])


def first_derivative(values: Values, step: float) -> Values:
    """Give the first derivative in time over a cycle, by its Fourier series, ``(angles, ...)``.

    Parameters
    ----------
    values
        At equal steps of time, ``(angles, ...)``.
    step
        The step (s).
    """
    return _derived(values, step, 1)


def second_derivative(values: Values, step: float) -> Values:
    """Give the second derivative in time, ``(angles, ...)``; 0 of fewer than three values.

    Parameters are those of `first_derivative`.
    """
    if len(values) < 3:
        return np.zeros_like(values)
    return _derived(values, step, 2)


def _derived(values: Values, step: float, times: int) -> Values:
    """Derive the Fourier series through a cycle; the fastest harmonic of an even number has no first derivative."""
    count = len(values)
    frequency = 2j * np.pi * np.fft.fftfreq(count, step)
    if times % 2 and count % 2 == 0:
        frequency[count // 2] = 0.0
    series = np.fft.fft(values, axis=0) * (frequency**times).reshape(-1, *(1,) * (values.ndim - 1))
    found = np.fft.ifft(series, axis=0)
    return cast(Values, found if np.iscomplexobj(values) else found.real)


def by_fourier_series(curve: Array, places: Array) -> Array:
    """Give a curve over a cycle between its positions, by its Fourier series, ``(positions, places, ...)``.

    Parameters
    ----------
    curve
        At equal steps of the cycle, ``(positions, ...)``.
    places
        Where between a position and the next, 0..1.
    """
    count, series = len(curve), np.fft.rfft(curve, axis=0)
    turned = np.exp(2j * np.pi / count * np.outer(np.arange(len(series)), places))
    if count % 2 == 0:
        turned[-1] = turned[-1].real
    turned = turned.reshape(*turned.shape, *(1,) * (curve.ndim - 1))
    return np.asarray(np.fft.irfft(turned * series[:, None], count, axis=0))
