"""Newton's method, and the stresses that it predicts."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError
from fenics_mech.machine import Evaluation, Machine


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


def predicted(machine: Machine, found: Evaluation, dq: Array, dv: Array, da: Array) -> Sequence[Array]:
    """Predict the stresses of all terms after a step, to first order, for the geometric stiffness of the next tangents.

    That is Newton's method with the stresses as unknowns, condensed. `dq`, `dv` and `da` are ``(instants, size)``.
    """
    return [
        measured.predicted(
            group.variables(dq), group.variables(dv), da[:, modes], da[:, machine.n :][:, list(term.rows)]
        )
        for measured, group, modes, term in zip(found.terms, machine.groups, machine.mode_numbers, machine.terms)
    ]
