"""How Floquet multipliers change with the equation, by their disturbances and the left vectors that go with them.

A simple multiplier of the monodromy matrix T changes by ``y^H dT x / (y^H x)``, with x and y its right and left
eigenvectors. ``dT x`` needs no other matrix: it is what a load adds to the state in a cycle, minus what the other
equation leaves over of the disturbance that begins with x.

Source: Golub and Van Loan, Matrix Computations (2013), section 7.2.2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech.errors import DerivativeError
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.newton import Orbit, orbit_of
from fenics_mech.response.stability.floquet import Stability

Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class ChangeLimits:
    """When multipliers have derivatives that can be found so."""

    most_states: int = 3000  # of which the whole monodromy matrix is made
    iterations: int = 4  # of inverse iteration, from a multiplier that is known
    apart: float = 1e-9  # of the size of a multiplier, by which the shift misses it: the matrix is not singular
    alike: float = 1e-6  # sine between two vectors that count as one
    exact: float = (
        1e-6  # of a multiplier: how exactly slow disturbances are found without those that steps are long for
    )
    condition: float = 1e8  # of a multiplier, beyond which it meets another one


CHANGES = ChangeLimits()


@dataclass(frozen=True, eq=False)
class Disturbance:
    """A disturbance of a periodic motion over a cycle, and how its multiplier changes.

    Parameters
    ----------
    left
        Left eigenvector y at the start of the cycle, ``(states,)``, with ``y^H x = 1``.
    parts
        Real and imaginary part of the disturbance; the first alone where the multiplier is real.
    """

    left: Complex
    parts: tuple[Orbit, ...]

    def change(self, flow: Flow, left_over: Sequence[Array]) -> complex:
        """Give the change of the multiplier.

        Parameters
        ----------
        flow
            The steps.
        left_over
            What the other equation leaves over of each part, less what the known one does, ``(points, coordinates)``.
        """
        still = np.zeros(2 * flow.size)
        ends = [flow.march(still, flow.added_by(-load))[-1] for load in left_over]
        return complex(sum(factor * np.vdot(self.left, end) for factor, end in zip((1, 1j), ends)))


@dataclass(frozen=True, eq=False)
class Disturbances:
    """Disturbances whose multipliers have derivatives.

    Parameters
    ----------
    flow
        The steps of a cycle, of the equation linearised about the motion.
    stability
        The multipliers.
    of
        Disturbance by number of the multiplier. Of a conjugate pair it is one.
    """

    flow: Flow
    stability: Stability
    of: dict[int, Disturbance]

    @classmethod
    def find(cls, flow: Flow, stability: Stability, share: float = 0.0) -> Disturbances:
        """Find the disturbances of multipliers.

        Parameters
        ----------
        flow
            The steps of a cycle at Gauss points.
        stability
            The multipliers.
        share
            Of the largest magnitude, below which multipliers are left as they are.

        Raises
        ------
        DerivativeError
            When there are too many states, or two multipliers are so near to each other that they have no derivatives.
        """
        if 2 * flow.size > CHANGES.most_states:
            raise DerivativeError(f"{2 * flow.size} states are too many for the derivatives of multipliers")
        unit, values = np.tile(flow.unit, 2), stability.multipliers
        matrix = flow.after_cycle(np.diag(1 / unit)) * unit[:, None]
        counted = np.flatnonzero((values.imag >= 0) & (np.abs(values) >= share * np.abs(values).max(initial=0.0)))
        return cls(flow, stability, {int(i): _disturbance(flow, matrix, unit, values[i]) for i in counted})

    @property
    def parts(self) -> list[Orbit]:
        """Parts of all disturbances, one after the other."""
        return [part for one in self.of.values() for part in one.parts]

    def changes(self, left_over: Sequence[Array]) -> Complex:
        """Give the changes of all multipliers, ``(multipliers,)``.

        Parameters
        ----------
        left_over
            As of `Disturbance.change`, of all `parts`.
        """
        values, remaining = self.stability.multipliers, iter(left_over)
        found = np.zeros(len(values), dtype=complex)
        for i, one in self.of.items():
            change = one.change(self.flow, [next(remaining) for _ in one.parts])
            found[i] = change
            found[np.isin(values, values[i].conj()) & (values.imag != 0)] = change.conjugate()
        return found

    def changed(self, change: Complex, faster: float) -> Stability:
        """Give the multipliers of a machine beside the known one.

        Parameters
        ----------
        change
            Changes of the multipliers, ``(multipliers,)``.
        faster
            How many times as fast its drive is.
        """
        known = self.stability
        values, turns = known.multipliers + change, known.frequency * known.period
        part = np.angle(known.multipliers) / (2 * math.pi)
        ahead = np.abs(np.round(turns - part) - (turns - part)) < np.abs(np.round(turns + part) - (turns + part))
        more = np.angle(values / known.multipliers) / (2 * math.pi)
        period = known.period / faster
        frequency = np.abs(turns + np.where(ahead, more, -more)) / period
        return replace(known, multipliers=values, frequency=frequency, period=period)


def _disturbance(flow: Flow, matrix: Array, unit: Array, value: complex) -> Disturbance:
    """Find both eigenvectors by inverse iteration from two random vectors, and follow the right one.

    Of a multiplier that is one of several, the two come to different vectors. One that was found among the slow
    disturbances alone may be none of the matrix, where steps are long.
    """
    size, real = len(unit), value.imag == 0
    shift = value * (1 + CHANGES.apart)
    factors = scipy.linalg.lu_factor(matrix - (shift.real if real else shift) * np.eye(size), check_finite=False)
    found, alike = [], True
    for transposed in (0, 2):
        vectors = np.random.default_rng(0).standard_normal((size, 2)).astype(factors[0].dtype)
        for _ in range(CHANGES.iterations):
            vectors = scipy.linalg.lu_solve(factors, vectors, trans=transposed, check_finite=False)
            vectors /= np.linalg.norm(vectors, axis=0)
        across = vectors[:, 1] - vectors[:, 0] * np.vdot(vectors[:, 0], vectors[:, 1])
        alike &= bool(np.linalg.norm(across) < CHANGES.alike)
        found.append(vectors[:, 0])
    right, left = found
    product, error = np.vdot(left, right), abs(np.vdot(right, matrix @ right) / value - 1)
    if not error < CHANGES.exact:
        raise DerivativeError(f"the sub_intervals are long for the multiplier {value:.6g}, known to {error:.1e} of it")
    if not alike:
        raise DerivativeError(f"the multiplier {value:.6g} is one of several that are alike")
    if not abs(product) * CHANGES.condition > 1:
        raise DerivativeError(f"the multiplier {value:.6g} meets another one")
    parts = (right.real,) if real else (right.real, right.imag)
    passed = flow.march_several(np.stack(parts, axis=1) / unit[:, None])
    load = np.zeros_like(flow.matrices.load)
    orbits = (orbit_of(flow, passed[:-1, :, k], load) for k in range(len(parts)))
    return Disturbance((left / product.conjugate()).astype(complex) * unit, tuple(orbits))
