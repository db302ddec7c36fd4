"""What an error comes to that acts back on itself: ``(1 - T)^{-1} T q``, T giving the error that a motion makes.

T q is its first order, which is enough where T changes little. It is not enough where a harmonic lies between the
frequencies of a mode of the mesh and of the linkage. There an eigenvalue of T is about 1, and only damping limits the
part of the motion that the mesh misses. T itself is known to first order, so the largest of the possible answers is
taken. The eigenvalues are found by Arnoldi's method.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.accuracy.mesh_residual import neglected
from fenics_mech.effects import Loads
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.mechanism import System


@dataclass(frozen=True)
class FeedbackLimits:
    """Limits of the search for what an error does to itself."""

    near: float = 0.3  # of T's eigenvalues, from where it may
    little: float = 0.03  # share of a harmonic of a motion that its error is, from which nothing is amplified
    felt: float = 1e-3  # of a motion, from which a part of it is followed: less would have to grow 100 times to count
    hardly_damped: float = 0.02  # imaginary part over real one of an eigenvalue, up to which hardly anything damps
    least_loss: float = 1e-3  # loss factor that is taken where there is less
    unfelt: float = 1e-2  # of the size up to which a motion is linear: 1e-6 of it, which no resonance makes felt
    few: int = 4  # times that T is applied
    most: int = 8  # the same where a resonance may be near
    open: tuple[float, float] = (-0.2, 0.7)  # by which share T may be wrong at an eigenvalue of 1: 0.4 in mode 3
    tried: int = 31  # shares of T, and those at which it has the eigenvalue 1


FEEDBACK = FeedbackLimits()


def fed_back(
    first: Array,
    again: Callable[[Array], Array],
    unit: Array,
    loss: float,
    within: float = np.inf,
) -> tuple[Array, bool]:
    """Give the error of a motion with all that it does to itself.

    Source: Saad, Iterative Methods for Sparse Linear Systems (2003), section 6.4 (full orthogonalization).

    Parameters
    ----------
    first
        ``T q``, ``(angles, numbers)``.
    again
        Gives ``T x``; it is linear for small x.
    unit
        What numbers are multiplied by for their sizes to be compared, ``(numbers,)``.
    loss
        Least loss factor of vibration, twice the damping ratio: at an eigenvalue that T may have as 1, its inverse is
        the most by which anything is amplified.
    within
        Size up to which `again` is linear.

    Returns
    -------
    tuple
        The error, and whether T may have an eigenvalue 1 that hardly anything damps, so that the error may be more.
    """
    size = float(np.linalg.norm(first * unit))
    if size <= (FEEDBACK.unfelt * within if np.isfinite(within) else 0.0):  # rounding of fine meshes, too
        return first, False
    tried = min(size, within) or size
    basis, projected, parts, held = [first / size], np.zeros((FEEDBACK.most + 1, FEEDBACK.most)), np.ones(1), True
    for count in range(1, FEEDBACK.most + 1):
        found = again(tried * basis[-1]) / tried
        reach = _reach(basis[-1] * unit, found * unit)
        for i, vector in enumerate(basis):
            projected[i, count - 1] = np.sum(found * vector * unit**2)
            found = found - projected[i, count - 1] * vector
        projected[count, count - 1] = left = np.linalg.norm(found * unit)
        before, held_before = parts, held
        parts, nearest, held = _largest(projected[:count, :count], max(loss, FEEDBACK.least_loss))
        if (
            reach < FEEDBACK.little
            or left * abs(parts[-1]) < FEEDBACK.felt
            or (count >= FEEDBACK.few and nearest < FEEDBACK.near)
        ):
            break
        basis.append(found / left)
    else:  # an eigenvalue that only the last basis has is by chance: the smaller answer is without it
        parts, held = min(before, parts, key=np.linalg.norm), held or held_before
    answer = size * np.tensordot(parts, np.array(basis[: len(parts)]), axes=1)
    return np.asarray(answer, dtype=np.float64), not held


@dataclass(frozen=True)
class Answer:
    """How a motion answers to small loads beside its own.

    Parameters
    ----------
    system, step
        The mechanism, and the duration between its positions (s).
    unit
        What the numbers of a change are multiplied by for their sizes to be compared, ``(numbers,)``.
    loss, within
        Least loss factor of vibration, and size of a change up to which the answer is linear; as of `fed_back`.
    to
        Gives what loads on the links (N, N m, N/m) change of the motion, ``(angles, numbers)``; it is linear.
    changed
        Gives the motion with such a change, under the loads of this change.
    """

    system: System
    step: float
    unit: Array
    loss: float
    within: float
    to: Callable[[Loads], Array]
    changed: Callable[[Array, Loads], ElasticResponse]


def without_mesh(answer: Answer, response: ElasticResponse) -> tuple[ElasticResponse, Loads, bool]:
    """Give a motion under the loads that its elements neglect, and these, with all that they do to themselves.

    Parameters
    ----------
    answer
        How the motion answers to loads.
    response
        The motion as it is.

    Returns
    -------
    tuple
        The motion, the loads, and what `fed_back` says of a resonance.
    """
    system, size = answer.system, len(answer.unit)
    missing = neglected(system, response, answer.step)

    def under(loads: Loads) -> Array:
        return np.concatenate([answer.to(loads), loads.columns()], axis=1)

    def parts(error: Array) -> tuple[Array, Loads]:
        return error[:, :size], missing.of_columns(error[:, size:])

    def again(error: Array) -> Array:
        change, beside = parts(error)
        there = system.with_loads(beside)
        found = neglected(there, answer.changed(change, beside), answer.step)
        return under(missing.of_columns(found.columns() - missing.columns()))

    first = under(missing)
    unit = np.pad(answer.unit, (0, first.shape[1] - size))
    error, resonant = fed_back(first, again, unit, answer.loss, within=answer.within)
    change, beside = parts(error)
    return answer.changed(change, beside), beside, resonant


def _reach(motion: Array, error: Array) -> float:
    """Give the largest share of a harmonic of a motion that its error is."""
    before, after = (np.linalg.norm(np.fft.rfft(part, axis=0), axis=1) for part in (motion, error))
    felt = before > FEEDBACK.felt * np.linalg.norm(before)
    return float((after[felt] / before[felt]).max())


def _largest(projected: Array, loss: float) -> tuple[Array, float, bool]:
    """Give the largest ``(1 - s T)^{-1} T q`` in the basis, s being 1 or near it, and ``T q`` the basis' first.

    Beside it T's largest eigenvalue of those that are nearly real, as others are at no resonance, and whether damping
    holds those that are.
    """
    values = np.linalg.eigvals(projected)
    values = values[np.abs(values.imag) < values.real]
    nearest = float(np.abs(values).max(initial=0.0))
    strength = min(1.0, (1 + FEEDBACK.open[1]) * nearest)
    least, most = 1 + strength * np.array(FEEDBACK.open)
    poles = values.real / np.abs(values) ** 2
    inside = (poles >= least) & (poles <= most)
    held, poles = bool((np.abs(values.imag) > FEEDBACK.hardly_damped * values.real)[inside].all()), poles[inside]
    shares = np.concatenate([np.linspace(least, most, FEEDBACK.tried), poles * (1 + loss)])
    found = np.linalg.inv(np.eye(len(projected)) - shares[:, None, None] * projected)[..., 0]
    return found[np.linalg.norm(found, axis=1).argmax()], nearest, held
