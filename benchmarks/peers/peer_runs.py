"""What a run of a program is, in a comparison of programs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from fenics_mech._arrays import Array

COUPLED, EXACT = "coupling", "large rotations"
OURS, EXUDYN = "fenics_mech", "Exudyn"
Note = Callable[[float], None]


@dataclass(frozen=True)
class Entry:
    """One run of a program.

    Parameters
    ----------
    program, equation
        Who solves what.
    work
        Gives the mid-span strains, ``(angles, members, 1, 1)``. It is called with a function that takes the processor
        time of the solver alone (s), where the program knows it.
    settings
        Its settings, of `cost_grid.SETTINGS`.
    """

    program: str
    equation: str
    work: Callable[[Note], Array]
    settings: dict[str, Any] = field(default_factory=dict)
