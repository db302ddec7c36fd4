"""Elements that are stretched evenly and turn far: their state, their forces, and the tangents of these.

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
        fold = 1 + (_sum(slope[..., ::2], shape[..., ::2]) - shorter) / bars.length
        beyond = ((y[..., 0] + stretch * shorter) / bars.length - strain) / fold
        return cls(strain, beyond, shape, slope, fold)

    @classmethod
    def of(cls, y: Array, bars: Bars) -> Stretched:
        """Solve (1) for lambda by Newton's method; parameters are those of `by`."""
        found = cls.by(np.zeros(y.shape[:2]), y, bars)
        for _ in range(EVEN.most_steps):
            if not np.abs(found.beyond).max() > EVEN.tolerance:
                break
            found = cls.by(found.strain + found.beyond, y, bars)
        return replace(found, strain=found.strain + found.beyond, beyond=np.zeros_like(found.beyond))

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


def _sum(one: Array, other: Array) -> Array:
    """Inner products along the last axis."""
    return np.asarray(np.einsum("...i,...i->...", one, other))


def _times(matrices: Array, vectors: Array) -> Array:
    """Products of small matrices and vectors."""
    return np.asarray(np.einsum("...ij,...j->...i", matrices, vectors))


def _products(one: Array, other: Array) -> Array:
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
        along = np.ones_like(rate)
        along[..., 1:] = of.stretch[..., None] * of.scale * of.slope
        along /= (of.fold * bars.length)[..., None]
        stretch_rate = bars.material * _sum(along, rate)
        shape_rate = bars.material * of.scale * rate[..., 1:] - of.across * stretch_rate[..., None]
        moment = bars.axis.force(of.shape, shape_rate)
        whole = bars.stiffness * bars.length * (of.strain + stretch_rate) - _sum(moment, of.across)  # (3)
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


@dataclass(frozen=True)
class _Drag:
    """What the material's damping adds to the tangents of elements, ``(angles, elements, ...)``.

    The rate of z, times tau, is ``tau (dz/dw) w' - a tau lambda'``.

    Parameters
    ----------
    drag, drag_across
        Derivative of m by that rate, ``(..., 4, 4)``, and its product with a, ``(..., 4)``.
    rate_by_stretch, rate_by_y
        Derivatives of ``tau lambda'`` by lambda and by y, ``(..., 5)``.
    shape_rate_by_w
        Derivative of the rate of z by w alone, which has no other entries than these, ``(..., 4)``.
    moment_by_stretch
        Derivative of m by lambda, with the rate of lambda held, less that of forces without damping, ``(..., 4)``.
    stiff
        Derivative of N by lambda.
    by_y, by_rate
        Derivatives of N by y and by its rate, ``(..., 5)`` each.
    """

    drag: Array
    drag_across: Array
    rate_by_stretch: Array
    rate_by_y: Array
    shape_rate_by_w: Array
    moment_by_stretch: Array
    stiff: Array
    by_y: Array
    by_rate: Array

    @classmethod
    def of(cls, state: Strained, rate: Array, bars: Bars, curvature: Array) -> _Drag:
        """Give it about a state; parameters are those of `Strained.by`, and the second derivative of s by z."""
        of, along, tau = state.of, state.along, bars.material
        a, d, longer, faster = of.across, of.scale, of.stretch[..., None], state.stretch_rate[..., None]
        drag, firm, sines = (
            bars.axis.tangent_by_rate(of.shape, state.shape_rate),
            of.fold * bars.length,
            (1 - PLACES) * of.slope,
        )
        eased, bowed = _times(drag, a), longer * _times(curvature, state.shape_rate)
        rate_by_stretch = (tau * _sum(sines, rate[..., 1:]) - _sum(a, bowed)) / firm
        rate_by_y = rate_by_stretch[..., None] * along
        rate_by_y[..., 1:] += (d * bowed + sines * faster) / firm[..., None]
        shape_rate_by_w = -PLACES * faster / longer**2
        pressed = _times(drag, 2 * faster * a / longer - tau * PLACES * rate[..., 1:] / longer**2)
        through, narrower = (bars.stiffness * bars.length + _sum(a, eased))[..., None], _sum(a, pressed)
        by_y = through * rate_by_y - narrower[..., None] * along
        by_y[..., 1:] -= shape_rate_by_w * eased
        by_rate = tau * through * along
        by_rate[..., 1:] -= tau * d * eased
        stiff = through[..., 0] * rate_by_stretch - narrower
        return cls(drag, eased, rate_by_stretch, rate_by_y, shape_rate_by_w, pressed, stiff, by_y, by_rate)

    def by_stretch(self, state: Strained) -> Array:
        """Derivative of the forces by lambda, ``(..., 5)``."""
        found = self.stiff[..., None] * state.along
        found[..., 1:] += state.of.scale * (self.moment_by_stretch - self.drag_across * self.rate_by_stretch[..., None])
        return found

    def matrices(self, state: Strained, material: float) -> tuple[Array, Array]:
        """Give what it adds to the tangents by y, less that along lambda, and the tangents by the rate."""
        along, d = state.along, state.of.scale
        by_y, held = np.zeros((*along.shape, 5)), d * self.drag_across
        by_y[..., 1:, :] = _products(d * self.moment_by_stretch, along) - _products(held, self.rate_by_y)
        firm = d[..., :, None] * self.drag
        by_y[..., 1:, 1:] += firm * self.shape_rate_by_w[..., None, :]
        by_rate = _products(along, self.by_rate)
        by_rate[..., 1:, :] -= _products(material * held, along)
        by_rate[..., 1:, 1:] += firm * (material * d)[..., None, :]
        return by_y, by_rate


@dataclass(frozen=True)
class Linearised:
    """Forces of elements about a state, on their own numbers y, ``(angles, elements, ...)``.

    Parameters
    ----------
    force
        Forces where the stretch has its lambda, with what that lacks to the first order, ``(..., 5)``.
    by_y, by_rate
        Derivatives by y and by its rate, ``(..., 5, 5)``; the latter is None without damping of the material.
    pull
        P where y does not change (N).
    pull_by_y, pull_by_rate
        Derivatives of P by y and by its rate, ``(..., 5)``.
    by_stretch, pull_by_stretch
        Derivatives of the forces, ``(..., 5)``, and of P by lambda.
    """

    force: Array
    by_y: Array
    by_rate: Array | None
    pull: Array
    pull_by_y: Array
    pull_by_rate: Array | None
    by_stretch: Array
    pull_by_stretch: Array

    @classmethod
    def about(cls, state: Strained, rate: Array, bars: Bars, pull: Array | None) -> Linearised:
        """Linearise, with a force P that is held, or that of the state.

        Parameters
        ----------
        state, rate, bars
            As of `Strained.by`.
        pull
            P (N), ``(angles, elements)``; None for that of the state.
        """
        of, along, curvature = state.of, state.along, bars.axis.curvature(state.of.shape)
        a, d, firm = of.across, of.scale, of.fold * bars.length
        force = state.whole / firm if pull is None else pull
        bent = (force * of.stretch)[..., None, None] * curvature + bars.axis.tangent(of.shape, state.shape_rate)
        row = np.zeros_like(along)
        row[..., 1:] = force[..., None] * (1 - PLACES) * of.slope - PLACES * state.moment / of.stretch[..., None] ** 2
        turn, eased = row.copy(), _times(bent, a)
        turn[..., 1:] -= d * eased  # of the forces, by lambda
        stiff = bars.stiffness * bars.length + _sum(a, eased) + 2 * _sum(state.moment, a) / of.stretch  # of N by lambda
        by_stretch = turn + stiff[..., None] * along
        row += stiff[..., None] * along
        row[..., 1:] -= d * _times(bent.swapaxes(-1, -2), a)  # of N, by y: damping is not symmetric
        drag = _Drag.of(state, rate, bars, curvature) if bars.material else None
        by_y = _products(turn, along) + _products(along, row if drag is None else row + drag.by_y)
        by_y[..., 1:, 1:] += d[..., :, None] * bent * d[..., None, :]
        by_rate = pull_by_rate = None
        if drag is not None:
            stiff, row, by_stretch = stiff + drag.stiff, row + drag.by_y, by_stretch + drag.by_stretch(state)
            more, by_rate = drag.matrices(state, bars.material)
            by_y += more
            pull_by_rate = drag.by_rate / firm[..., None]
        return cls(
            force=state.force + by_stretch * of.beyond[..., None],
            by_y=by_y,
            by_rate=by_rate,
            pull=np.asarray(state.whole + stiff * of.beyond, dtype=np.float64) / firm,
            pull_by_y=row / firm[..., None],
            pull_by_rate=pull_by_rate,
            by_stretch=by_stretch,
            pull_by_stretch=stiff / firm,
        )
