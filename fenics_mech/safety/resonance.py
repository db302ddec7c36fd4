"""How far the speed is from a critical one, where the answer has no vibration."""

from __future__ import annotations

from fenics_mech.recovery.result import Result
from fenics_mech.safety.check import Check, unknown, wanted
from fenics_mech.safety.critical_speeds import resonance_margin

MODE = "resonance"


def resonating(result: Result, link: str) -> Check:
    """Judge the distance of the speed from the nearest critical speed, at the link that vibrates most there."""
    # An answer with vibration has that in its stresses, which other modes judge: then the distance is no factor.
    if result.scene.analysis.method == "static":
        return unknown(MODE, "nothing moves in a static answer")
    if result.scene.analysis.method != "quasi-static":
        return unknown(MODE, "the stresses have the vibration, and critical speeds are told by themselves")
    nearest = resonance_margin(result)
    if nearest is None or nearest.link != link:
        return unknown(MODE, "no critical speed of its own is near")
    return Check(MODE, 1.0, nearest.margin, "share", wanted(result.scene.design, MODE), detail=nearest.words)
