"""Elements that are stretched evenly and turn far: their state and their forces. `stretch_tangents` has the tangents.

An element has five numbers y: the elongation e of its straight line, and place and slope of the displacement w across
it at both ends. It is stretched lambda times. Its shape z has the places of w over lambda, and the slopes of w: it is
the deflection of an axis of the old length L that turns as much. Such an axis is longer than its straight line by s(z).

    L + e = lambda (L - s(z))                                                                                       (1)

This gives lambda. With ``a = -dz/dlambda``, the places of z over lambda, and ``fold = 1 + (s_z z - s)/L``, the sum over
places, its change is ``fold L dlambda = de + lambda s_z dz``, dz being that by w alone.                             (2)

With the retardation time tau of the material, and the forces m of bending on z, the forces on y do the work

    N dlambda + m dz, with N = EA L (lambda - 1 + tau lambda') - m a                                                (3)

of which the force along the element's straight line is ``P = N/(fold L)``.                                         (4)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array

if TYPE_CHECKING:
    from fenics_mech.beams.bent_axis import BentAxis

PLACES = np.array([1.0, 0.0, 1.0, 0.0])  # which dofs of w are places of an element's ends; the others are slopes


@dataclass(frozen=True)
class EvenLimits:
    """Limits of the iterations for the stretch of elements."""

    tolerance: float = 1e-11  # of its last change but one: the last is its square
    of_force: float = 1e-6  # of the same where it follows a held force
    most_steps: int = 8
    least: float = -0.5  # lambda - 1 by a held force: bars buckle long before


EVEN = EvenLimits()


@dataclass(frozen=True)
class Bars:
    """What elements are made of.

    Parameters
    ----------
    axis
        Their shortening and bending.
    stiffness, length
        EA (N) and L (m), ``(elements,)`` each.
    material
        Retardation time tau (s).
    """

    axis: BentAxis
    stiffness: Array
    length: Array
    material: float


@dataclass(frozen=True)
class Stretched:
    """Elements whose axes are stretched lambda times, ``(angles, elements, ...)``.

    Parameters
    ----------
    strain, beyond
        lambda - 1, and by how much that of their elongation is larger, to the first order.
    shape, slope
        z and the derivative of s by it, ``(..., 4)``.
    fold
        That of (2).
    """

    strain: Array
    beyond: Array
    shape: Array
    slope: Array
    fold: Array

    @classmethod
    def by(cls, strain: Array, y: Array, bars: Bars) -> Stretched:
        """Give the state of elements that are stretched by some lambda.

        Parameters
        ----------
        strain
            lambda - 1, ``(angles, elements)``.
        y
            Their own numbers, ``(angles, elements, 5)``.
        bars
            What they are made of.
        """
        stretch = 1 + strain
        shape = y[..., 1:] * _scale(stretch)
        shorter, slope = bars.axis.shortened(shape)
        fold = 1 + (inner(slope[..., ::2], shape[..., ::2]) - shorter) / bars.length
        beyond = ((y[..., 0] + stretch * shorter) / bars.length - strain) / fold
        return cls(strain, beyond, shape, slope, fold)

    @classmethod
    def of(cls, y: Array, bars: Bars) -> Stretched:
        """Solve (1) for lambda by Newton's method; parameters are those of `by`.

        The right side of (1) is concave in lambda, as s is convex, and rises everywhere. So there is one root, and no
        step ends above it: from the second one on lambda rises to it, and the errors are as squares of those before.
        Stretches of a half to three take seven steps at most. What remains after the last one is rounding. Where an
        axis turns by 90 degrees on the way, there is no number.
        """
        found = cls.by(np.zeros(y.shape[:2]), y, bars)
        for _ in range(EVEN.most_steps):
            if not np.abs(found.beyond).max() > EVEN.tolerance:
                break
            found = cls.by(found.strain + found.beyond, y, bars)
        return replace(found, strain=found.strain + found.beyond, beyond=np.zeros_like(found.beyond))

    def along(self, bars: Bars) -> Array:
        """Derivative of lambda by y by (2), ``(angles, elements, 5)``."""
        found = np.ones((*self.strain.shape, 5))
        found[..., 1:] = self.stretch[..., None] * self.scale * self.slope
        found /= (self.fold * bars.length)[..., None]
        return found

    def in_time(self, rate: Array, second: Array, bars: Bars) -> tuple[list[Array], list[Array]]:
        """Give lambda and z with their two time derivatives, ``(angles, elements)`` and ``(angles, elements, 4)``.

        The second is that of (1): what ``along`` gives of y'', and what products of rates add.

        Parameters
        ----------
        rate, second
            The two time derivatives of the elements' own numbers, ``(angles, elements, 5)`` each.
        bars
            What they are made of.
        """
        along, longer = self.along(bars), self.stretch[..., None]
        faster = inner(along, rate)[..., None]
        moving = self.scale * rate[..., 1:] - self.across * faster
        squared = inner(moving, by_matrix(bars.axis.curvature(self.shape), moving))
        squared = 2 * faster[..., 0] * inner((1 - PLACES) * self.slope, moving) + self.stretch * squared
        more = (inner(along, second) + squared / (self.fold * bars.length))[..., None]
        bending = self.scale * second[..., 1:] - 2 * faster / longer * PLACES * moving - self.across * more
        return [self.stretch, faster[..., 0], more[..., 0]], [self.shape, moving, bending]

    @property
    def stretch(self) -> Array:
        """The factor lambda itself, ``(angles, elements)``."""
        return 1 + self.strain

    @cached_property
    def scale(self) -> Array:
        """Derivative of z by w, which has no other entries than these, ``(..., 4)``."""
        return _scale(self.stretch)

    @cached_property
    def across(self) -> Array:
        """The vector a of (2), ``(..., 4)``."""
        return np.asarray(PLACES * self.shape / self.stretch[..., None])


def _scale(stretch: Array) -> Array:
    scale = np.ones((*stretch.shape, 4))
    scale[..., ::2] /= stretch[..., None]
    return scale


def inner(one: Array, other: Array) -> Array:
    """Inner products along the last axis."""
    return np.asarray(np.einsum("...i,...i->...", one, other))


def by_matrix(matrices: Array, vectors: Array) -> Array:
    """Products of small matrices and vectors."""
    return np.asarray(np.einsum("...ij,...j->...i", matrices, vectors))


def outer(one: Array, other: Array) -> Array:
    """Products of the entries of two vectors, ``(..., i, j)``."""
    return np.asarray(np.einsum("...i,...j->...ij", one, other))


@dataclass(frozen=True)
class Strained:
    """Forces of stretched elements on their own numbers, ``(angles, elements, ...)``.

    Parameters
    ----------
    of
        Their stretch and their shape.
    along
        Derivative of lambda by y by (2), ``(..., 5)``.
    stretch_rate, shape_rate
        Rates of lambda and of z times tau, ``(...)`` and ``(..., 4)``.
    moment
        Forces m of bending on z, ``(..., 4)``.
    whole
        The force N of (3) on lambda (N m).
    """

    of: Stretched
    along: Array
    stretch_rate: Array
    shape_rate: Array
    moment: Array
    whole: Array

    @classmethod
    def by(cls, of: Stretched, rate: Array, bars: Bars) -> Strained:
        """Give the forces of elements whose stretch is known.

        Parameters
        ----------
        of
            Their stretch.
        rate
            Rates of their own numbers, ``(angles, elements, 5)``.
        bars
            What they are made of.
        """
        along = of.along(bars)
        stretch_rate = bars.material * inner(along, rate)
        shape_rate = bars.material * of.scale * rate[..., 1:] - of.across * stretch_rate[..., None]
        moment = bars.axis.force(of.shape, shape_rate)
        whole = bars.stiffness * bars.length * (of.strain + stretch_rate) - inner(moment, of.across)  # (3)
        return cls(of, along, stretch_rate, shape_rate, moment, whole)

    @classmethod
    def held(cls, pull: Array, y: Array, rate: Array, bars: Bars, tolerance: float = EVEN.of_force) -> Strained:
        """Solve (4) for lambda with a held P, whatever (1) gives with an elongation that is not yet right.

        Parameters
        ----------
        pull
            P (N), ``(angles, elements)``.
        y, rate
            The elements' own numbers and their rates, ``(angles, elements, 5)`` each.
        bars
            What they are made of.
        tolerance
            Of lambda.
        """
        strain, gain, before = pull / bars.stiffness, np.ones_like(pull), np.zeros_like(pull)
        for _ in range(EVEN.most_steps):
            found = cls.by(Stretched.by(np.maximum(strain, EVEN.least), y, bars), rate, bars)
            lacking = (pull * found.of.fold - found.whole / bars.length) / bars.stiffness
            if not np.abs(lacking).max() > tolerance:
                break
            left = np.divide(lacking, before, out=np.zeros_like(pull), where=np.abs(before) > tolerance)
            gain /= 1 - np.minimum(left, 0.5)  # secant method
            strain, before = found.of.strain + gain * lacking, lacking
        return found

    @property
    def force(self) -> Array:
        """Forces on the elements' own numbers, ``(..., 5)``."""
        found = self.whole[..., None] * self.along
        found[..., 1:] += self.of.scale * self.moment
        return found
