"""Quantities with their first two time derivatives, as lists of one or three arrays of shape ``(angles, ...)``."""

from __future__ import annotations

import operator
from collections.abc import Callable

import numpy as np

from fenics_mech._arrays import Array, Numbers
from fenics_mech.beams.attachment import QUARTER
from fenics_mech.kinematics import Motion

Jets = list[Array]  # the value alone, or value, first and second derivative


def constant(value: Array, motion: Motion, orders: int) -> Jets:
    """Give the jets of a constant matrix.

    Parameters
    ----------
    value
        The value at every angle.
    motion
        The rigid motion, for its number of angles.
    orders
        1 for values, 3 with two time derivatives.
    """
    spread = np.broadcast_to(value, (len(motion.theta), *value.shape))
    return [spread, *(np.zeros_like(spread),) * (orders - 1)]


def product(a: Jets, b: list[Numbers], times: Callable[[Array, Numbers], Numbers] = operator.matmul) -> list[Numbers]:
    """Product of two factors, by Leibniz' rule.

    Parameters
    ----------
    a, b
        Both factors, of the same orders; b may be complex.
    times
        Multiplies two arrays; that of matrices unless another is given.
    """
    if len(a) == 1:
        return [times(a[0], b[0])]
    return [
        times(a[0], b[0]),
        times(a[1], b[0]) + times(a[0], b[1]),
        times(a[2], b[0]) + times(2 * a[1], b[1]) + times(a[0], b[2]),
    ]


def rotation_matrices(angle: Array, omega: Array, alpha: Array, orders: int) -> Jets:
    """Rotation matrices (7.3) and their derivatives (7.4), (7.5), ``(angles, 2, 2)`` each.

    Parameters
    ----------
    angle, omega, alpha
        Angle (rad) and its time derivatives (rad/s, rad/s^2), ``(angles,)`` each.
    orders
        1 for values, 3 with two time derivatives.
    """
    c, s = np.cos(angle), np.sin(angle)
    turn = np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)
    if orders == 1:
        return [turn]
    across = QUARTER @ turn
    omega, alpha = omega[:, None, None], alpha[:, None, None]
    return [turn, omega * across, alpha * across - omega**2 * turn]
