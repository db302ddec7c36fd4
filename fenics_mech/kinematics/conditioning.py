"""How well a position determines the motion: singular values of the loop Jacobian, made free of units.

The smallest one is 0 at a dead centre, where the drive cannot go on, and at a change point, where the linkage can go on
in two ways. It is about the sine of the transmission angle. Rounding e of the coordinates' equations changes angles by
e over it, and accelerations, relatively, by e over its square.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import AssemblyError
from fenics_mech.kinematics.loops import Loops


@dataclass(frozen=True)
class ConditionLimits:
    """When a position of a linkage counts as singular, and a link as free to move."""

    singular: float = 3e-6  # smallest singular value: below it rounding changes accelerations by more than about 1e-4
    bounded: float = 1e-4  # that value times the rate of the fastest link by the drive: below it the links do not lock
    in_two_ways: float = 1e-5  # that value without drives: `singular`, and by how much steps stay away from it
    flat: float = 1e-9  # relative change of that value over the range that counts as none
    free: float = 1e-9  # singular value of the Jacobian without units, up to which a motion is free
    seen: float = 1e-6  # of the largest motion, above which a link moves
    most_named: int = 4  # links that a message about one freedom names
    samples: int = 361  # of the range of the drive
    points: int = 21  # of each pass of the search for a minimum, which leaves a tenth of the interval


CONDITION = ConditionLimits()
REMEDY = (  # where a motion is not unique
    "The program follows no motion through it: take a drive whose range keeps away from it, or other lengths. Where "
    "two equal cranks turn together, drive both, and let one pin of their rod slide in a slot along it"
)


def singular_values(loops: Loops, q: Array) -> tuple[Array, Array]:
    """Singular values of the Jacobian without units, ``(positions, coordinates)``, and the right vectors."""
    # q (positions, 3 links)
    _, values, right = np.linalg.svd(loops.without_units(q))
    return values, right * loops.unit


def smallest_value(loops: Loops, q: Array) -> float:
    """Give the smallest singular value at one position, ``(3 links,)``."""
    # q (3 links,)
    return float(np.linalg.svd(loops.without_units(q[None]), compute_uv=False)[0, -1])


def links_moved(loops: Loops, motion: Array) -> tuple[str, ...]:
    """Links that a motion, ``(3 links,)``, turns, the most turned first."""
    # motion (3 links,)
    turned = np.abs(motion[2::3])
    order = np.argsort(-turned)
    return tuple(loops.links[i] for i in order if turned[i] > 0.05 * turned.max())


def locks(loops: Loops, q: Array, rate: Array) -> bool:
    """Whether a singular position is a dead centre, where links turn without bound, and not a change point."""
    # q, rate (3 links,) each
    return bool(smallest_value(loops, q) * np.abs(rate[2::3]).max() > CONDITION.bounded)


def refuse_singular(loops: Loops, theta: Array, q: Array) -> None:
    """Raise `AssemblyError` where the motion follows from the positions only to few digits."""
    try:
        bound = 1 / np.linalg.norm(np.linalg.inv(loops.without_units(q)), axis=(1, 2))  # not above the smallest value
    except np.linalg.LinAlgError:
        bound = np.zeros(len(q))
    if not (near := np.flatnonzero(bound < CONDITION.singular)).size:
        return
    values, right = singular_values(loops, q[near])
    worst = int(values[:, -1].argmin())
    if values[worst, -1] < CONDITION.singular:
        moved = ", ".join(links_moved(loops, right[worst, -1]))
        raise AssemblyError(
            f"the linkage is at a dead centre or change point at drive angle {np.degrees(theta[near[worst]]):.10g} deg "
            f"(smallest singular value {values[worst, -1]:.1e}): the motion of {moved} is lost to rounding there. "
            f"{REMEDY}"
        )
