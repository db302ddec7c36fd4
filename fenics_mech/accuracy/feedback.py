"""What an error comes to that acts back on itself: ``(1 - T)^{-1} T q``, T giving the error that a motion makes.

T q is its first order, which is enough where T changes little. T itself is known to first order, so that the answer is
not known where a harmonic lies between the frequencies of a mode of the mesh and of the linkage. There an eigenvalue of
T is about 1. The eigenvalues are found by Arnoldi's method.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.accuracy.corrected_response import WithoutMesh, corrected_for_mesh
from fenics_mech.accuracy.mesh_residual import neglected
from fenics_mech.effects import Loads
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.mechanism import System


@dataclass(frozen=True)
class FeedbackLimits:
    """Limits of the search for what an error does to itself."""

    near: float = 0.5  # of T's eigenvalues, to which T may be 1.4 times too large: the error is then at most so, too
    little: float = 0.03  # share of a harmonic of a motion that its error is, from which nothing is amplified
    felt: float = 1e-3  # of a motion, from which a part of it is followed: less would have to grow 100 times to count
    unfelt: float = 1e-2  # of the size up to which a motion is linear: 1e-6 of it, which no resonance makes felt
    most: int = 4  # times that T is applied


FEEDBACK = FeedbackLimits()


def fed_back(first: Array, again: Callable[[Array], Array], unit: Array, within: float = np.inf) -> tuple[Array, bool]:
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
    within
        Size up to which `again` is linear.

    Returns
    -------
    tuple
        The error, and whether T has an eigenvalue beyond `FEEDBACK.near`, so that its first order does not tell it.
    """
    size = float(np.linalg.norm(first * unit))
    if size <= (FEEDBACK.unfelt * within if np.isfinite(within) else 0.0):  # rounding of fine meshes, too
        return first, False
    tried = min(size, within) or size
    basis, projected, near = [first / size], np.zeros((FEEDBACK.most + 1, FEEDBACK.most)), False
    for count in range(1, FEEDBACK.most + 1):
        found = again(tried * basis[-1]) / tried
        reach = _reach(basis[-1] * unit, found * unit)
        for i, vector in enumerate(basis):
            projected[i, count - 1] = np.sum(found * vector * unit**2)
            found = found - projected[i, count - 1] * vector
        projected[count, count - 1] = left = np.linalg.norm(found * unit)
        square = projected[:count, :count]
        parts, near = np.linalg.solve(np.eye(count) - square, np.eye(count)[0]), _nearest(square) > FEEDBACK.near
        if near or reach < FEEDBACK.little or left * abs(parts[-1]) < FEEDBACK.felt:
            break
        basis.append(found / left)
    answer = size * np.tensordot(parts, np.array(basis[: len(parts)]), axes=1)
    return np.asarray(answer, dtype=np.float64), near


@dataclass(frozen=True)
class Answer:
    """How a motion answers to small loads beside its own.

    Parameters
    ----------
    system, step
        The mechanism, and the duration between its positions (s).
    unit
        What the numbers of a change are multiplied by for their sizes to be compared, ``(numbers,)``.
    within
        Size of a change up to which the answer is linear.
    to
        Gives what loads on the links (N, N m, N/m) change of the motion, ``(angles, numbers)``; it is linear.
    changed
        Gives the motion with such a change, under the loads of this change.
    """

    system: System
    step: float
    unit: Array
    within: float
    to: Callable[[Loads], Array]
    changed: Callable[[Array, Loads], ElasticResponse]


def without_mesh(answer: Answer, response: ElasticResponse) -> WithoutMesh:
    """Give a motion under the loads that its elements neglect, with all that they do to themselves.

    Where the answer is linear for little only, the motion has so little of them.

    Parameters
    ----------
    answer
        How the motion answers to loads.
    response
        The motion as it is.
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
    error, near = fed_back(first, again, unit, within=answer.within)
    share = min(1.0, answer.within / max(float(np.linalg.norm(error * unit)), TINY))
    change, beside = parts(share * error)
    return corrected_for_mesh(system, answer.changed(change, beside), beside, share=share, near=near)


def _reach(motion: Array, error: Array) -> float:
    """Give the largest share of a harmonic of a motion that its error is."""
    before, after = (np.linalg.norm(np.fft.rfft(part, axis=0), axis=1) for part in (motion, error))
    felt = before > FEEDBACK.felt * np.linalg.norm(before)
    return float((after[felt] / before[felt]).max())


def _nearest(projected: Array) -> float:
    """Give the largest eigenvalue of those that are nearly real, as others are at no resonance."""
    values = np.linalg.eigvals(projected)
    return float(np.abs(values[np.abs(values.imag) < values.real]).max(initial=0.0))
