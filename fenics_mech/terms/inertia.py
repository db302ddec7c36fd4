"""Inertia as one constant mass between vectors of poses: their places and the columns of their rotations.

Rigid bodies, point masses, beams and their sections have a constant mass in these vectors. So no gyroscopic or
centrifugal force is written: they come from the second rates of the vectors.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.geometry import End

ROUNDING = 1e-12  # of the largest entry of a mass matrix
Vector = tuple[int, int]  # pose; 0 for its place, 1 + j for column j of its rotation


def place_of(end: End) -> dict[Vector, float]:
    """Give the place of an end by vectors of its pose: r + sum p_j d_j."""
    return {(end.pose, 0): 1.0, **{(end.pose, 1 + j): float(p) for j, p in enumerate(end.offset) if p}}


def axis_of(end: End, axis: int) -> dict[Vector, float]:
    """Give an axis of an end by vectors of its pose: sum S_j d_j."""
    return {(end.pose, 1 + j): float(s) for j, s in enumerate(end.turn[:, axis]) if s}


@dataclass
class Masses:
    """The mass matrix of a machine, by pairs of vectors (kg)."""

    entries: dict[tuple[Vector, Vector], float] = field(default_factory=lambda: defaultdict(float))
    changes: int = 0  # so many masses were added

    def couple(self, one: dict[Vector, float], other: dict[Vector, float], mass: float) -> None:
        """Add a mass between two combinations of vectors."""
        self.changes += 1
        for a, x in one.items():
            for b, y in other.items():
                self.entries[a, b] += mass * x * y

    def add_body(self, end: End, mass: float, tensor: Array) -> None:
        """Add a rigid body, or with a tensor of zeros a point mass."""
        # tensor (d, d) (kg m^2)
        _refuse_negative(np.array([[mass]]), "the mass of a body", "kg")
        _refuse_negative(tensor, "a second moment of the mass of a body", "kg m^2")
        self.couple(place_of(end), place_of(end), mass)
        for i, j in np.argwhere(tensor):
            self.couple(axis_of(end, i), axis_of(end, j), tensor[i, j])

    def add_beam(
        self, ends: tuple[End, End], mass: Array, sections: Array, beside: Array, inside: Sequence[int] = ()
    ) -> None:
        """Add an element whose places are Hermite polynomials between its ends' places and first axes."""
        # sections (bends,) (kg m^2); beside (bends, 4, 2)
        _refuse_negative(mass, "the mass of a beam element", "kg")
        _refuse_negative(np.diag(sections), "the rotary inertia of a beam element", "kg m^2")
        vectors = [made for end in ends for made in (place_of(end), axis_of(end, 0))]
        vectors += [{(pose, 0): 1.0} for pose in inside]
        for i, one in enumerate(vectors):
            for j, other in enumerate(vectors):
                self.couple(one, other, float(mass[i, j]))
        for axis, inertia in enumerate(sections, start=1):
            if inertia:
                first, second = (axis_of(end, axis) for end in ends)  # between them linear
                for one, other, share in (
                    (first, first, 2),
                    (first, second, 1),
                    (second, first, 1),
                    (second, second, 2),
                ):
                    self.couple(one, other, inertia * share / 6)
        for (axis, i, k), moment in np.ndenumerate(beside):
            if moment:
                self.couple(vectors[i], axis_of(ends[k], 1 + axis), float(moment))
                self.couple(axis_of(ends[k], 1 + axis), vectors[i], float(moment))


def _refuse_negative(mass: Array, what: str, unit: str) -> None:
    """Raise `ValueError` where a mass matrix has a negative eigenvalue, or is no number."""
    least = np.linalg.eigvalsh(mass).min() if np.isfinite(mass).all() else np.nan
    if not least >= -ROUNDING * np.abs(mass).max():
        raise ValueError(f"{what} is {least:.6g} {unit}: expected 0 or more")


def hermite_mass(length: float, line_mass: float) -> Array:
    """Give the mass of a uniform beam between its ends' places and first axes, ``(4, 4)``.

    Parameters
    ----------
    length
        m.
    line_mass
        kg/m.
    """
    numbers = [[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]
    scale = np.array([1, length, 1, length])
    return np.asarray(line_mass * length / 420 * np.array(numbers) * np.outer(scale, scale))


def beside_line(length: float, moment: Array) -> Array:
    """Give the mass between places and first axes of both ends, and their other axes, ``(bends, 4, 2)``."""
    # moment (bends,) (kg)
    # It is that of a uniform mass beside the line of the places: r(x) + e d(x), d linear between the ends.
    shares = np.array([[21, 9], [3, 2], [9, 21], [-2, -3]]) / 60 * np.array([1, length, 1, length])[:, None]
    return np.asarray(length * moment[:, None, None] * shares)
