"""What a small load more does to a motion: the linearised response, by steps that carried the motion itself."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import times
from fenics_mech.mechanism.equation import Array, Matrices
from fenics_mech.response.cyclic import solve_cycle
from fenics_mech.response.flow import Flow


def periodic_change(
    load: Array, motion: Array, flow: Flow, regular: NDArray[np.bool_], options: Mapping[str, Any]
) -> tuple[Array, Array]:
    """Give the changes of q and q' that a load makes, ``(angles, coordinates)`` each.

    Parameters
    ----------
    load
        At equal steps of the cycle, ``(angles, coordinates)``; between them it is linear.
    motion
        States at the starts of the steps: the changes are as good as these, even where little changes them much.
    flow
        The steps of the cycle, linearised about the motion. They may be cut.
    regular
        Which of them begin at the angles, ``(steps,)``.
    options
        PETSc options with the prefix "periodic_".
    """
    start = np.cumsum(flow.duration) - flow.duration
    if not regular.all():
        period = float(flow.duration.sum())
        load = np.stack([np.interp(start, start[regular], column, period=period) for column in load.T], axis=1)
    rise = np.roll(load, -1, axis=0) - load
    added = flow.added_by(load[:, None] + flow.tableau.points[:, None] * rise[:, None])
    right = np.roll(motion, -1, axis=0) - times(flow.transitions, motion)  # with it the answer is the motion itself
    return flow.parts((solve_cycle(flow.transitions, right + added, options) - motion)[regular])


def change_in_time(load: Array, matrices: Matrices, step: float, before: Array) -> Array:
    """Give the changes that a load makes in time, by Newmark's method (average acceleration).

    Source: Newmark, J. Eng. Mech. Div. ASCE 85 (1959) 67.

    Parameters
    ----------
    load, matrices
        The load and the linearised equation at equal steps of time.
    step
        The step (s).
    before
        q, q' and q'' a step before the first time, ``(3, coordinates)``.

    Returns
    -------
    numpy.ndarray
        Changes of q, q' and q'', ``(3, times, coordinates)``.
    """
    change = np.zeros((3, *load.shape))
    whole = np.linalg.inv(matrices.mass + step / 2 * matrices.damping + step**2 / 4 * matrices.stiffness)
    q, rate, acceleration = before
    for k, (mass, damping, stiffness) in enumerate(zip(whole, matrices.damping, matrices.stiffness)):
        rate = rate + step / 2 * acceleration
        q = q + step * rate - step**2 / 4 * acceleration
        acceleration = mass @ (load[k] - damping @ rate - stiffness @ q)
        q, rate = q + step**2 / 4 * acceleration, rate + step / 2 * acceleration
        change[:, k] = q, rate, acceleration
    return change
