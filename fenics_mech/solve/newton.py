"""Newton's method."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

import numpy as np

from fenics_mech.errors import SolverError

ROUNDING = 1e-2  # changes below which Newton's method converges, unless rounding makes them


def newton(step: Callable[[], float], tolerance: float, most: int, what: str) -> list[float]:
    """Step until the change is small, and give the sizes of all changes."""
    changes: list[float] = []
    while len(changes) < most:
        try:
            changes.append(step())
        except FloatingPointError:  # it has gone too far to be told
            changes.append(math.inf)
        if not np.isfinite(changes[-1]):
            break
        if changes[-1] < tolerance:
            return changes
    last = ", ".join(f"{change:.1e}" for change in changes[-3:])
    said = f"{what}: Newton's method has not converged in {len(changes)} steps (changes {last})"
    if len(changes) > 2 and max(changes[-3:]) < ROUNDING:
        said += ", which is rounding. Look for damping far beyond stiffness or inertia, or for a very stiff spring"
    raise SolverError(said)


FIRST_SHARE, LEAST_SHARE = 0.25, 1e-3  # of the loads, by which they are increased where all at once lead to no answer
MOST_OF_SHARE = 12  # steps of Newton's method for a share of the loads: half the share costs less than more of them


class Loaded(Protocol):
    """Newton's method for an answer of which a share of the loads is known."""

    share: float  # of the loads that act

    def step(self) -> float:
        """Take a step, and give its size."""

    def rest(self) -> None:
        """Go back to where the answer is that no loads have."""

    def refuse_beyond(self, reached: float) -> None:
        """Raise `SolverError` where what was found is not near the answer to the share that was reached before."""


def converge(answer: Loaded, tolerance: float, most: int, what: str) -> list[float]:
    """Step until the change is small, and give the sizes of all changes."""
    # Where that does not lead to an answer, the loads are increased from none, and no sizes are given.
    begun = dict(vars(answer))
    try:
        return newton(answer.step, tolerance, most, what)
    except SolverError as error:
        failed = error
    vars(answer).update(begun)
    answer.rest()
    reached, ahead = 0.0, FIRST_SHARE
    while reached < 1.0:
        before = dict(vars(answer))
        answer.share = min(reached + ahead, 1.0)
        try:
            newton(answer.step, tolerance, MOST_OF_SHARE, what)
        except SolverError:
            ahead = (answer.share - reached) / 2
            if ahead < LEAST_SHARE:
                known = f"There are answers up to {reached:.3g} of the load"
                none = f"None is found for {answer.share:.3g} of the load either"
                raise SolverError(
                    f"{failed}. {known if reached else none}. Lower the loads, or take stiffer members"
                ) from None
            vars(answer).update(before)
        else:
            answer.refuse_beyond(reached)
            reached, ahead = answer.share, 2 * ahead
    return []
