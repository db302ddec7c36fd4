"""What a small load more does to a motion: the linearised response, by steps that carried the motion itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech.accuracy.time_derivatives import by_fourier_series
from fenics_mech.response.periodic.cyclic import CYCLIC
from fenics_mech.response.periodic.flow import Flow


def periodic_change(load: Array, motion: Array, flow: Flow, regular: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Give the changes of q and q' that a load makes, ``(angles, coordinates)`` each.

    Parameters
    ----------
    load
        At equal steps of the cycle, ``(angles, coordinates)``. Between them it is that of its Fourier series, or where
        steps are cut linear.
    motion
        States at the starts of the steps: the changes are as good as these, even where little changes them much.
    flow
        The steps of the cycle, linearised about the motion. They may be cut.
    regular
        Which of them begin at the angles, ``(steps,)``.
    """
    start = np.cumsum(flow.duration) - flow.duration
    if not regular.all():
        period = float(flow.duration.sum())
        load = np.stack([np.interp(start, start[regular], column, period=period) for column in load.T], axis=1)
        rise = np.roll(load, -1, axis=0) - load
        inside = load[:, None] + flow.tableau.points[:, None] * rise[:, None]
    else:
        inside = by_fourier_series(load, flow.tableau.points)
    added = flow.added_by(inside.reshape(-1, load.shape[1]))
    right = np.roll(motion, -1, axis=0) - flow.carried(motion)  # with it the answer is the motion itself
    return flow.parts((flow.cycle.solve(right + added, motion[0], CYCLIC.tolerance_of_change) - motion)[regular])
