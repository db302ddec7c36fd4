"""What a small load more does to a motion: the linearised response, by steps that carried the motion itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from fenics_mech._arrays import Array
from fenics_mech.accuracy.time_derivatives import by_fourier_series
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.response.periodic.cyclic import CYCLIC
from fenics_mech.response.periodic.flow import Flow


@dataclass(frozen=True)
class LagLimits:
    """When steps in time lag behind a vibration."""

    vibrates: float = 0.03  # square root of a mode's kinetic energy, over that of the largest, from which it counts
    behind: float = 3.0  # phase (rad) by which steps in time may lag behind a vibration while that lasts
    left: float = 0.8  # of what is much too fast for the steps, after each: if all is left, matrices feed it
    looked_at: int = 8  # positions of a cycle at which vibration is looked for


LAG = LagLimits()


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


def change_in_time(load: Array, matrices: Matrices, step: float, before: Array) -> Array:
    """Give the changes that a load makes in time, by the generalised alpha method.

    Source: Chung and Hulbert, J. Appl. Mech. 60 (1993) 371.

    Parameters
    ----------
    load, matrices
        The load and the linearised equation at equal steps of time.
    step
        The step (s).
    before
        q, q', q'' and the force that goes on, a step before the first time, ``(4, coordinates)``.

    Returns
    -------
    numpy.ndarray
        Changes of q, q', q'' and that force, ``(4, times, coordinates)``.
    """
    change = np.zeros((4, *load.shape))
    old, old_inertia = (
        LAG.left / (1 + LAG.left),
        (2 * LAG.left - 1) / (1 + LAG.left),
    )  # shares of the state before in the equation
    new, new_inertia = 1 - old, 1 - old_inertia
    of_rate, of_place = (0.5 - old_inertia + old) * step, ((1 - old_inertia + old) / 2 * step) ** 2
    masses, dampings, stiffnesses = matrices.full
    whole = np.linalg.inv(new_inertia * masses + new * (of_rate * dampings + of_place * stiffnesses))
    q, rate, acceleration, lasting = before
    for k, inverse in enumerate(whole):
        mass, damping, stiffness = masses[k], dampings[k], stiffnesses[k]
        q = q + step * rate + (step**2 / 2 - of_place) * acceleration
        rate = rate + (step - of_rate) * acceleration
        acceleration = inverse @ (new * (load[k] - damping @ rate - stiffness @ q) + lasting)
        q, rate = q + of_place * acceleration, rate + of_rate * acceleration
        lasting = old * (load[k] - damping @ rate - stiffness @ q) - old_inertia * mass @ acceleration
        change[:, k] = q, rate, acceleration, lasting
    return change


def too_fast(matrices: Matrices, motion: tuple[Array, Array], step: float, duration: float) -> float | None:
    """Give the frequency (Hz) of the slowest vibration in a motion that `change_in_time` does not follow, or None.

    It lags behind one of frequency w by about ``(w step)^2 / 12`` of its phase, for as long as damping lets it last.

    Parameters
    ----------
    matrices, motion
        The linearised equation, and q and q', at equal steps of time.
    step, duration
        The step, and for how long the whole motion lasts (s).
    """
    found, largest = [], 0.0
    for k in range(0, len(motion[0]), max(1, len(motion[0]) // LAG.looked_at)):
        mass, stiffness = matrices.mass.symmetric.dense(k), matrices.stiffness.symmetric.dense(k)
        try:
            square, shapes = eigh(mass, stiffness)  # 1 over w^2
        except np.linalg.LinAlgError:  # it is held by nothing, or buckles
            continue
        moves = square > np.finfo(float).eps * square[-1]
        square, shapes = square[moves], shapes[:, moves]
        elastic, kinetic = ((shapes.T @ stiffness @ part[k]) ** 2 for part in motion)
        kinetic *= square
        decay = np.einsum("im,im->m", shapes, matrices.damped_at(k, shapes)) / (2 * square)
        lasts = 1 / np.maximum(decay, 1 / max(duration, step))
        largest = max(largest, float(np.sum(elastic + kinetic)))
        found.append((1 / np.sqrt(square), kinetic, lasts))
    slow = []
    for omega, kinetic, lasts in found:
        vibrates = (kinetic > LAG.vibrates**2 * largest) & (omega * lasts > 1)
        slow += omega[vibrates & (omega**3 * step**2 / 12 * lasts > LAG.behind)].tolist()
    return min(slow) / (2 * np.pi) if slow else None
