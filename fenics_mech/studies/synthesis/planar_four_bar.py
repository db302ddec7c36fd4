"""A four-bar of rigid links in the complex plane: its kind, its motion, and what may be wrong with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError

Complex = NDArray[np.complex128]
TURN = 2 * np.pi
CLOSE = 1e-9  # of the longest link: smaller differences are rounding
SMALLEST = 1e-150  # m, of places: the squares of smaller ones are lost
COURSE = 721  # angles of a course at which it is looked whether links can be assembled


@dataclass(frozen=True)
class FourBar:
    """A four-bar, whose crank is pinned to the ground at `origin`."""

    # origin, pivot: fixed pivots of crank and follower (m), as x + i y
    origin: complex
    pivot: complex
    # crank, coupler, follower: lengths (m). That of crank or follower is negative where its angle is that of the
    # opposite direction.
    crank: float
    coupler: float
    follower: float
    # 1 where the coupler pin of the follower is left of the line from the crank pin to the follower's pivot, else -1
    side: float
    point: complex = 0j  # A point of the coupler in its frame (m): from the crank pin, x along the coupler

    @property
    def ground(self) -> float:
        """Distance of the fixed pivots (m)."""
        return abs(self.pivot - self.origin)

    @property
    def lengths(self) -> tuple[float, float, float, float]:
        """Lengths of crank, coupler, follower and ground (m)."""
        return abs(self.crank), self.coupler, abs(self.follower), self.ground

    @property
    def kind(self) -> str:
        """Kind by Grashof's rule."""
        lengths = self.lengths
        ordered = sorted(lengths)
        excess = ordered[0] + ordered[3] - ordered[1] - ordered[2]
        if abs(excess) <= CLOSE * ordered[3]:
            return "change point"
        if excess > 0:
            return "triple rocker"
        return ("crank-rocker", "double rocker", "rocker-crank", "double crank")[int(np.argmin(lengths))]

    @property
    def turns(self) -> bool:
        """Whether the crank turns round."""
        return self.kind in ("crank-rocker", "double crank")

    def pins(self, angles: Array) -> tuple[Complex, Complex]:
        """Places of both pins of the coupler (m), ``(angles,)`` each; that of the follower is NaN where none is."""
        first: Complex = self.origin + self.crank * np.exp(1j * np.asarray(angles, dtype=float)).astype(np.complex128)
        to_pivot = self.pivot - first
        distance = np.maximum(np.abs(to_pivot), np.finfo(float).tiny)
        cosine = (self.coupler**2 + distance**2 - self.follower**2) / (2 * self.coupler * distance)
        inside = np.abs(cosine) <= 1 + CLOSE
        turned = np.exp(1j * self.side * np.arccos(np.clip(cosine, -1, 1)))
        second = first + self.coupler * to_pivot / distance * turned
        return first, np.where(inside, second, complex(np.nan, np.nan)).astype(np.complex128)

    def points(self, angles: Array) -> Complex:
        """Places of the coupler's point (m), ``(angles,)``."""
        first, second = self.pins(angles)
        return np.asarray(first + self.point * (second - first) / self.coupler)

    def transmission(self, angles: Array) -> Array:
        """Angle between coupler and follower, 0 to pi/2 (rad), ``(angles,)``."""
        first, second = self.pins(angles)
        square = self.coupler**2 + self.follower**2 - np.abs(self.pivot - first) ** 2
        cosine = np.abs(square) / (2 * self.coupler * abs(self.follower))
        return np.where(np.isfinite(second), np.arccos(np.minimum(cosine, 1)), np.nan)

    def side_of(self, first: complex, second: complex) -> float:
        """Side on which the follower's pin is where both pins are at given places: 1 is left, 0 in line."""
        across = ((second - first) * (self.pivot - first).conjugate()).imag
        return float(np.sign(across)) if abs(across) > CLOSE * max(self.lengths) ** 2 else 0.0


@dataclass(frozen=True)
class Course:
    """How the crank passes the asked positions."""

    start: float  # angle of the crank at the first (rad)
    # angle from there to each position (rad), the first being 0; with the sign of the turning
    turned: tuple[float, ...]

    @property
    def angles(self) -> Array:
        """Angles of the crank along the course (rad)."""
        return self.start + np.linspace(0, self.turned[-1], COURSE)


def course_of(linkage: FourBar, angles: Sequence[float]) -> tuple[Course, list[str]]:
    """Find how the crank passes some angles in their order, and what hinders it."""
    steps, found = np.diff(angles), []
    for sense in (1.0, -1.0):
        turned = sense * np.append(0.0, np.cumsum((sense * steps) % TURN))
        course = Course(float(angles[0]), tuple(turned.tolist()))
        in_order = abs(turned[-1]) < TURN + CLOSE
        whole = course.angles if in_order else course.start + np.linspace(0, TURN, COURSE)
        assembled = float(np.isfinite(linkage.pins(whole)[1]).mean())
        found.append((in_order, assembled, -abs(turned[-1]), course))
    in_order, assembled, _, course = max(found, key=lambda one: one[:3])
    wrong = []
    if not in_order:
        wrong.append("order: the crank does not pass the positions in their order in one turn")
    if assembled < 1:
        wrong.append("branch: the links cannot be assembled at all angles between the positions")
    return course, wrong


def three_point_circle(points: Sequence[complex]) -> complex | None:
    """Give the centre of the circle through three points; None where they are in line."""
    first, second, third = points
    u, v = second - first, third - first
    across = (u.conjugate() * v).imag
    if abs(across) <= CLOSE * max(abs(u), abs(v)) ** 2:
        return None
    return first + 1j * (v * abs(u) ** 2 - u * abs(v) ** 2) / (-2 * across)


def middle_and_size(places: Complex, key: str) -> tuple[complex, float]:
    """Give the middle of places and the largest distance from it (m), or 1 m where they are one."""
    middle = complex(places.mean())
    size = float(np.abs(places - middle).max())
    if 0 < size < SMALLEST:
        raise SceneError(f"these places are {size:.3g} m apart", place=key, hint="Give them in SI, or with a unit")
    return middle, size or 1.0
