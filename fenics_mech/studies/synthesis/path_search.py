"""Four-bars whose coupler point follows a path: least squares from many seeded starts.

Unknown are the dimensions, and the crank's angle at each place where the task does not state it. A path has several
linkages: by the theorem of Roberts and Chebyshev three four-bars trace one coupler curve.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.scene import PathTask
from fenics_mech.studies.synthesis.planar_four_bar import TURN, Complex, FourBar, middle_and_size

DIMENSIONS = 9  # place of the crank's pivot, angle of the ground, logarithms of four lengths, and the coupler's point
LARGEST = 20.0  # length over the size of the path, and the reverse of the smallest one
FIRST, LAST = 40, 400  # evaluations of a search, and of those that are searched to the end
KEPT = 8  # searches that are
ROUNDING = 1e-15  # relative change at which a search ends
SINGULAR = 1e-6  # share of the coupler by which it must be out of line with the follower for a derivative


@dataclass(frozen=True)
class _Shape:
    """Parts of a linkage at the angles of its crank, in units of the path, in axes with the ground along x."""

    crank: Complex  # from its pivot to the crank pin
    coupler: Complex  # direction
    gap: Complex  # from the crank pin to the follower's pivot
    cosine: Array  # of the angle between coupler and gap; links reach each other where its size is at most 1


@dataclass(frozen=True)
class PathFit:
    """The misfit of a four-bar from a path, and its derivatives."""

    places: Complex  # the path about its middle, in units of its size, ``(places,)``
    given: Array | None  # angles of the crank from the first place on (rad), ``(places,)``; None where they are free
    side: float  # as of `FourBar`

    def angles(self, x: Array) -> Array:
        """Angles of the crank from the line of the pivots (rad), ``(places,)``."""
        return x[:-DIMENSIONS] if self.given is None else x[0] + self.given

    def shape(self, x: Array) -> _Shape:
        """Assemble the links."""
        a, b, c, d = np.exp(x[-6:-2])
        crank = a * np.exp(1j * self.angles(x))
        gap = d - crank
        length = np.maximum(np.abs(gap), np.finfo(float).tiny)
        cosine = (b**2 + length**2 - c**2) / (2 * b * length)
        turned = np.exp(1j * self.side * np.arccos(np.clip(cosine, -1, 1)))
        return _Shape(crank, gap / length * turned, gap, cosine)

    def misfit(self, x: Array) -> Array:
        """Distance from every place by components, and by how much links do not reach each other, ``(3 places,)``."""
        shape = self.shape(x)
        point = complex(*x[-2:])
        there = complex(*x[-9:-7]) + np.exp(1j * x[-7]) * (shape.crank + point * shape.coupler)
        apart = there - self.places
        return np.concatenate([apart.real, apart.imag, np.maximum(np.abs(shape.cosine) - 1, 0)])

    def jacobian(self, x: Array) -> Array:
        """Derivatives of the misfit, ``(3 places, unknowns)``."""
        shape, count = self.shape(x), len(self.places)
        _, b, c, d = np.exp(x[-6:-2])
        point, turn = complex(*x[-2:]), np.exp(1j * x[-7])
        beyond = np.where(np.abs(shape.cosine) <= 1, 0.0, np.sign(shape.cosine))
        still = 0.0 * shape.crank
        changes = [(1j * shape.crank, 0.0, 0.0, 0.0), (shape.crank, 0.0, 0.0, 0.0)]  # by the angle, and the lengths
        changes += [(still, b, 0.0, 0.0), (still, 0.0, c, 0.0), (still, 0.0, 0.0, d)]
        found = np.zeros((2, count, len(x)), complex)
        for k, change in enumerate(changes):
            turned, cosine = self._rates(shape, (b, c), change)
            place = turn * (change[0] + point * 1j * shape.coupler * turned)
            if k:
                found[:, :, k - 7] = place, beyond * cosine
            elif self.given is None:
                found[:, np.arange(count), np.arange(count)] = place, beyond * cosine
            else:
                found[:, :, 0] = place, beyond * cosine
        found[0, :, -9], found[0, :, -8] = 1, 1j
        found[0, :, -7] = 1j * turn * (shape.crank + point * shape.coupler)
        found[0, :, -2], found[0, :, -1] = turn * shape.coupler, 1j * turn * shape.coupler
        return np.concatenate([found[0].real, found[0].imag, found[1].real])

    @staticmethod
    def _rates(
        shape: _Shape, lengths: tuple[float, float], change: tuple[Complex, float, float, float]
    ) -> tuple[Array, Array]:
        """Change of the coupler's angle and of the cosine, as the crank's vector and lengths b, c and d change."""
        (b, c), (crank, longer_b, longer_c, longer_d) = lengths, change
        loop = b * shape.coupler - shape.gap  # the follower, which keeps its length c
        across = np.real(loop.conj() * 1j * b * shape.coupler)
        across = np.where(np.abs(across) < SINGULAR * b * c, np.copysign(SINGULAR * b * c, across), across)
        gap, length = longer_d - crank, np.abs(shape.gap)
        closing = np.real(loop.conj() * (longer_b * shape.coupler - gap)) - c * longer_c
        turned = np.where(np.abs(shape.cosine) <= 1, -closing / across, np.imag(gap / shape.gap))
        cosine = (1 / b - shape.cosine / length) * np.real(shape.gap.conj() * gap) / length
        cosine += (1 / length - shape.cosine / b) * longer_b - c * longer_c / (b * length)
        return turned, cosine


def fits(task: PathTask, starts: int, seed: int) -> Iterator[tuple[FourBar, Array]]:
    """Search from many starts, and give the best with the angles of their cranks, each searched to the end."""
    places = np.array([complex(*place) for place in task.path], dtype=np.complex128)
    middle, size = middle_and_size(places, "path")
    random = np.random.default_rng(seed)
    given = np.array(task.angles) if task.angles else None
    found: list[tuple[float, int, PathFit, Array]] = []
    for number in range(starts):
        fit = PathFit((places - middle) / size, given, float(random.choice([-1.0, 1.0])))
        start = _start(fit, task.closed, random)
        if start is not None:
            cost, x = _searched(fit, start, FIRST)
            found.append((cost, number, fit, x))
    for _, _, fit, x in sorted(found, key=lambda one: one[:2])[:KEPT]:
        yield _fitted(fit, _searched(fit, x, LAST)[1], middle, size)


def _searched(fit: PathFit, start: Array, evaluations: int) -> tuple[float, Array]:
    """Search from a start, and give the sum of squares and where it is."""
    from scipy.optimize import least_squares  # noqa: PLC0415  (slow to import)

    free = np.full(len(start) - DIMENSIONS, np.inf)
    most = np.concatenate([free, [LARGEST, LARGEST, np.inf], np.full(4, np.log(LARGEST)), [LARGEST, LARGEST]])
    found = least_squares(
        fit.misfit,
        np.clip(start, -0.99 * most, 0.99 * most),
        fit.jacobian,
        (-most, most),
        max_nfev=evaluations,
        **dict.fromkeys(("xtol", "ftol", "gtol"), ROUNDING),
    )
    return float(found.cost), found.x


def _start(fit: PathFit, closed: bool, random: np.random.Generator) -> Array | None:
    """Take a random four-bar that can be assembled at all places, turned and scaled onto the path."""
    count = len(fit.places)
    for _ in range(100):
        lengths = random.uniform(-1, 1.5, 4)
        if fit.given is None:
            sense, turned = random.choice([-1.0, 1.0]), TURN if closed else random.uniform(0.6, 4.5)
            angles = random.uniform(0, TURN) + sense * turned * np.arange(count) / count
        else:
            angles = np.array([random.uniform(0, TURN)])
        point = random.normal(size=2) * np.exp(lengths[1])
        x = np.concatenate([angles, [0, 0, 0], lengths, point])
        shape = fit.shape(x)
        if np.abs(shape.cosine).max() < 0.98:
            path = shape.crank + complex(*point) * shape.coupler
            about = path - path.mean()
            scale = np.vdot(about, fit.places - fit.places.mean()) / np.vdot(about, about)
            place = fit.places.mean() - scale * path.mean()
            x[-9:-6] = place.real, place.imag, np.angle(scale)
            x[-6:-2] += np.log(abs(scale))
            x[-2:] *= abs(scale)
            return x
    return None


def _fitted(fit: PathFit, x: Array, middle: complex, size: float) -> tuple[FourBar, Array]:
    a, b, c, d = np.exp(x[-6:-2]) * size
    origin = middle + size * complex(*x[-9:-7])
    pivot = origin + d * np.exp(1j * x[-7])
    linkage = FourBar(complex(origin), complex(pivot), a, b, c, fit.side, size * complex(*x[-2:]))
    return linkage, fit.angles(x) + x[-7]
