"""How much memory the matrices of a cycle take."""

from __future__ import annotations

from dataclasses import dataclass

from fenics_mech._guard import require_memory
from fenics_mech._sparse import DENSE
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.system import System


@dataclass(frozen=True)
class MemoryNeed:
    """Numbers that a solver holds at each position."""

    nonzero: int = 14  # of a nonzero of the matrices, beside their factors
    mode: int = 32  # of what a mode sees of the coordinates, for each mode that is damped
    factors: int = 3  # of the modes' own equations in each step
    coordinate: int = 300  # of a coordinate, with its factors: rough, for meshes that are not yet made
    damped: int = 1000  # the same with damping of modes
    beside_pin: int = 8  # of a coordinate for each other one, where pins travel, which pass all elements


MEMORY_NEED = MemoryNeed()


def require_room(system: System, positions: int, stages: int, modes: tuple[int, int] | None) -> None:
    """Raise `TooLargeError` where the matrices of a cycle and their factors do not fit into memory.

    Parameters
    ----------
    system
        The mechanism, at any of its angles.
    positions
        Number of collocation points in the cycle.
    stages
        Of them, those in a step.
    modes
        Number of modes that modal damping is made for, and of what they see of the coordinates; None for all modes,
        which make the matrices full.
    """
    if modes is None:
        numbers = DENSE * system.size**2
    else:
        pattern, (count, seen) = Equation(system).pattern, modes
        numbers = (
            MEMORY_NEED.nonzero * len(pattern.rows)
            + stages * (pattern.elimination.blocks + MEMORY_NEED.factors * count**2)
            + MEMORY_NEED.mode * count * seen
        )
    what = f"the matrices of {positions} positions with {system.size} degrees of freedom"
    require_memory(numbers * positions, what, "Take fewer sub_intervals or elements")
