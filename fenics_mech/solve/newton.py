"""Newton's method."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fenics_mech.errors import SolverError


def newton(step: Callable[[], float], tolerance: float, most: int, what: str) -> list[float]:
    """Step until the change is small, and give the sizes of all changes.

    Parameters
    ----------
    step
        Makes a step, and gives its size relative to what is sought.
    tolerance
        Of that size.
    most
        Steps that it may take.
    what
        What is sought, for the message.

    Raises
    ------
    SolverError
        When it has not converged.
    """
    changes: list[float] = []
    while len(changes) < most:
        changes.append(step())
        if not np.isfinite(changes[-1]):
            break
        if changes[-1] < tolerance:
            return changes
    last = ", ".join(f"{change:.1e}" for change in changes[-3:])
    raise SolverError(f"{what}: Newton's method has not converged in {len(changes)} steps (changes {last})")
