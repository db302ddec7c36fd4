"""How far the speed is from a critical one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fenics_mech.recovery.result import Result
from fenics_mech.safety.check import Check, unknown, wanted

MODE = "resonance"


@dataclass(frozen=True)
class Nearest:
    """The critical speed that is nearest to the present one.

    Parameters
    ----------
    margin
        Distance of the speed from it, over the speed.
    link
        The link that vibrates most there.
    words
        Which harmonic meets which mode.
    """

    margin: float
    link: str
    words: str


resonance_margin: Callable[[Result], Nearest | None] | None = None  # critical speeds are not yet computed


def resonating(result: Result, link: str) -> Check:
    """Judge the distance of the speed from the nearest critical speed, at the link that vibrates most there.

    Parameters
    ----------
    result
        The result.
    link
        The link that is judged.
    """
    nearest = resonance_margin(result) if resonance_margin is not None else None
    if nearest is None or nearest.link != link:
        return unknown(MODE, "critical speeds are not computed")
    return Check(MODE, 1.0, nearest.margin, "share", wanted(result.scene.design, MODE), detail=nearest.words)
