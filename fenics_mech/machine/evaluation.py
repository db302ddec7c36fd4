"""What the residual gives: forces, tangents, and the stresses of every term."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fenics_mech._arrays import Array
from fenics_mech.machine.groups import Moved
from fenics_mech.machine.measured import Measured
from fenics_mech.machine.pattern import Pattern


@dataclass(frozen=True)
class Evaluation:
    """The residual of a machine at some instants.

    Parameters
    ----------
    force
        Residual of the coordinates (N, N m), then of the rows, ``(instants, size)``.
    M, C, K
        Derivatives by accelerations and multipliers, by rates, and by coordinates, ``(instants, entries)``.
    pattern
        Where their entries lie.
    terms
        Measures and stresses of every term.
    at
        The poses.
    t
        Instants ``(instants,)`` (s).
    """

    force: Array
    M: Array
    C: Array
    K: Array
    pattern: Pattern
    terms: Sequence[Measured]
    at: Moved
    t: Array
