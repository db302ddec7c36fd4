"""Charts: known motions of all poses, from which the coordinates are deviations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech.geometry.poses import PoseMotion
from fenics_mech.geometry.spaces import Geometry

Complex = NDArray[np.complex128]
Path = Callable[[Array], tuple[Array, Array, Array, Array, Array, Array]]  # t -> r, R, v, w, a, al of one pose


class Chart(Protocol):
    """A known motion of all poses; `still` says whether every pose that has coordinates rests in it."""

    still: bool

    def at(self, t: Array) -> PoseMotion:
        """Give the motion at some instants ``(instants,)`` (s)."""


@dataclass
class Rest:
    """Poses at rest, but for those that are led.

    Parameters
    ----------
    geometry
        The plane or space.
    r, R
        Places ``(poses, d)`` (m) and rotations ``(poses, d, d)``.
    led
        Motions of poses that a law leads.
    """

    geometry: Geometry
    r: Array
    R: Array
    led: Mapping[int, Path] = field(default_factory=dict)
    still: bool = True

    def at(self, t: Array) -> PoseMotion:
        """Give the motion at some instants."""
        shape, turns = (len(t), *self.r.shape), self.geometry.turns
        motion = PoseMotion(
            np.broadcast_to(self.r, shape).copy(),
            np.broadcast_to(self.R, (*shape, shape[-1])).copy(),
            np.zeros(shape),
            np.zeros((*shape[:2], turns)),
            np.zeros(shape),
            np.zeros((*shape[:2], turns)),
        )
        for pose, path in self.led.items():
            for array, value in zip((motion.r, motion.R, motion.v, motion.w, motion.a, motion.al), path(t)):
                array[:, pose] = value
        return motion


def harmonics(values: Array, period: float) -> tuple[Complex, Complex]:
    """Give exponents (1/s) and coefficients of the trigonometric polynomial through values at even instants from 0.

    Its values are the real part of ``tensordot(exp(outer(t, exponents)), coefficients, 1)``.

    Parameters
    ----------
    values
        ``(instants, ...)``.
    period
        s.
    """
    n = len(values)
    k = np.arange(n // 2 + 1)
    shares = np.where((k == 0) | (2 * k == n), 1.0, 2.0) / n
    return 2j * np.pi / period * k, np.tensordot(np.diag(shares), np.fft.rfft(values, axis=0), 1)


@dataclass
class Fourier:
    """A periodic motion by trigonometric polynomials of its places and rotation matrices.

    Parameters
    ----------
    geometry
        The plane or space.
    period
        Its period (s).
    r, R
        Places ``(instants, poses, d)`` and rotations ``(instants, poses, d, d)`` at even instants from 0.
    """

    geometry: Geometry
    period: float
    r: Array
    R: Array
    still: bool = False

    def __post_init__(self) -> None:
        self._rate, self._r = harmonics(self.r, self.period)
        self._R = harmonics(self.R, self.period)[1]

    def at(self, t: Array) -> PoseMotion:
        """Give the motion at some instants."""
        waves = np.exp(np.outer(t, self._rate))
        r, v, a = (np.tensordot(waves * self._rate**p, self._r, 1).real for p in range(3))
        R, R1, R2 = (np.tensordot(waves * self._rate**p, self._R, 1).real for p in range(3))
        back = np.swapaxes(R, -1, -2)
        axial = self.geometry.axial
        return PoseMotion(r, R, v, axial(R1 @ back), a, axial(R2 @ back))


@dataclass
class Given:
    """A motion that is known at some instants alone.

    Parameters
    ----------
    t
        The instants, ascending (s).
    motion
        All poses there.
    """

    t: Array
    motion: PoseMotion
    still: bool = False

    def at(self, t: Array) -> PoseMotion:
        """Give the motion at those of these instants that are the nearest."""
        return self.motion.part(np.searchsorted((self.t[1:] + self.t[:-1]) / 2, t))
