"""Tangents of elements that are stretched evenly and turn far, by names and equations of `even_stretch`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects.even_stretch import PLACES, Bars, Strained, by_matrix, inner, outer


@dataclass(frozen=True)
class _StretchRate:
    """Derivatives of ``tau lambda'``, the rate of an element's stretch times the retardation time of the material.

    Parameters
    ----------
    by_stretch
        By lambda, with y and its rate held, ``(angles, elements)``.
    by_y
        By y, with lambda and the rate of y held, ``(angles, elements, 5)``.
    """

    by_stretch: Array
    by_y: Array

    @classmethod
    def of(cls, state: Strained, rate: Array, bars: Bars, curvature: Array) -> _StretchRate:
        """Give them about a state; parameters are those of `Strained.by`, and the second derivative of s by z."""
        of, longer, faster = state.of, state.of.stretch[..., None], state.stretch_rate[..., None]
        firm, sines = of.fold * bars.length, (1 - PLACES) * of.slope
        bowed = longer * by_matrix(curvature, state.shape_rate)
        by_stretch = (bars.material * inner(sines, rate[..., 1:]) - inner(of.across, bowed)) / firm
        by_y = by_stretch[..., None] * state.along
        by_y[..., 1:] += (of.scale * bowed + sines * faster) / firm[..., None]
        return cls(by_stretch, by_y)


@dataclass(frozen=True)
class _Drag:
    """What the material's damping adds to the tangents of elements, ``(angles, elements, ...)``.

    The rate of z, times tau, is ``tau (dz/dw) w' - a tau lambda'``. The forces m of bending and the force N of (3)
    change with it. Derivatives by y go along with those by lambda, which (2) makes of them.

    Parameters
    ----------
    state, bars
        The state that they are about, and what the elements are made of.
    stretch_rate
        Derivatives of ``tau lambda'``.
    by_shape_rate
        Derivative of m by the rate of z times tau, ``(..., 4, 4)``.
    across
        Its product with a, ``(..., 4)``.
    shape_rate_by_w
        Derivative of the rate of z, times tau, by w alone, ``(..., 4)``. It has no other entries than these.
    moment_by_stretch
        Derivative of m by lambda with ``tau lambda'`` held, less that of forces without damping, ``(..., 4)``.
    """

    state: Strained
    bars: Bars
    stretch_rate: _StretchRate
    by_shape_rate: Array
    across: Array
    shape_rate_by_w: Array
    moment_by_stretch: Array

    @classmethod
    def of(cls, state: Strained, rate: Array, bars: Bars, curvature: Array) -> _Drag:
        """Give it about a state; parameters are those of `_StretchRate.of`."""
        of, tau = state.of, bars.material
        longer, faster = of.stretch[..., None], state.stretch_rate[..., None]
        by_shape_rate = bars.axis.tangent_by_rate(of.shape, state.shape_rate)
        change = 2 * faster * of.across / longer - tau * PLACES * rate[..., 1:] / longer**2  # of the rate of z
        return cls(
            state,
            bars,
            _StretchRate.of(state, rate, bars, curvature),
            by_shape_rate,
            by_matrix(by_shape_rate, of.across),
            -PLACES * faster / longer**2,
            by_matrix(by_shape_rate, change),
        )

    @cached_property
    def _of_whole_by_stretch_rate(self) -> Array:
        """Derivative of N by ``tau lambda'``, ``(angles, elements)``."""
        return np.asarray(self.bars.stiffness * self.bars.length + inner(self.state.of.across, self.across))

    @cached_property
    def _fall_of_whole_by_moment(self) -> Array:
        """By how much N falls with lambda as m changes with it, ``(angles, elements)``."""
        return inner(self.state.of.across, self.moment_by_stretch)

    @cached_property
    def of_whole_by_stretch(self) -> Array:
        """Derivative of N by lambda, ``(angles, elements)``."""
        return np.asarray(self._of_whole_by_stretch_rate * self.stretch_rate.by_stretch - self._fall_of_whole_by_moment)

    @cached_property
    def of_whole_by_y(self) -> Array:
        """Derivative of N by y, ``(angles, elements, 5)``."""
        found = self._of_whole_by_stretch_rate[..., None] * self.stretch_rate.by_y
        found -= self._fall_of_whole_by_moment[..., None] * self.state.along
        found[..., 1:] -= self.shape_rate_by_w * self.across
        return found

    @cached_property
    def of_whole_by_rate(self) -> Array:
        """Derivative of N by the rate of y, ``(angles, elements, 5)``."""
        tau = self.bars.material
        found = tau * self._of_whole_by_stretch_rate[..., None] * self.state.along
        found[..., 1:] -= tau * self.state.of.scale * self.across
        return found

    def of_forces_by_stretch(self) -> Array:
        """Derivative of the forces by lambda, ``(angles, elements, 5)``."""
        found = self.of_whole_by_stretch[..., None] * self.state.along
        of_bending = self.moment_by_stretch - self.across * self.stretch_rate.by_stretch[..., None]
        found[..., 1:] += self.state.of.scale * of_bending
        return found

    def of_bending_by_y(self) -> Array:
        """Derivative of the forces of bending by y, ``(angles, elements, 5, 5)``."""
        along, d = self.state.along, self.state.of.scale
        found = np.zeros((*along.shape, 5))
        found[..., 1:, :] = outer(d * self.moment_by_stretch, along) - outer(d * self.across, self.stretch_rate.by_y)
        found[..., 1:, 1:] += d[..., :, None] * self.by_shape_rate * self.shape_rate_by_w[..., None, :]
        return found

    def of_forces_by_rate(self) -> Array:
        """Derivative of the forces by the rate of y, ``(angles, elements, 5, 5)``."""
        along, d, tau = self.state.along, self.state.of.scale, self.bars.material
        found = outer(along, self.of_whole_by_rate)
        found[..., 1:, :] -= outer(tau * (d * self.across), along)
        found[..., 1:, 1:] += d[..., :, None] * self.by_shape_rate * (tau * d)[..., None, :]
        return found


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
        turn, eased = row.copy(), by_matrix(bent, a)
        turn[..., 1:] -= d * eased  # of the forces, by lambda
        # of N by lambda
        stiff = bars.stiffness * bars.length + inner(a, eased) + 2 * inner(state.moment, a) / of.stretch
        by_stretch = turn + stiff[..., None] * along
        row += stiff[..., None] * along
        row[..., 1:] -= d * by_matrix(bent.swapaxes(-1, -2), a)  # of N, by y: damping is not symmetric
        drag = _Drag.of(state, rate, bars, curvature) if bars.material else None
        by_y = outer(turn, along) + outer(along, row if drag is None else row + drag.of_whole_by_y)
        by_y[..., 1:, 1:] += d[..., :, None] * bent * d[..., None, :]
        by_rate = pull_by_rate = None
        if drag is not None:
            stiff, row = stiff + drag.of_whole_by_stretch, row + drag.of_whole_by_y
            by_stretch = by_stretch + drag.of_forces_by_stretch()
            by_y += drag.of_bending_by_y()
            by_rate, pull_by_rate = drag.of_forces_by_rate(), drag.of_whole_by_rate / firm[..., None]
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
