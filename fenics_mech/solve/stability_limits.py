"""When a periodic motion counts as unstable."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class StabilityLimits:
    """Limits of the judgement of stability."""

    longest_step: float = 2 / 3  # angle (rad) per collocation point that a disturbance may turn by in a step
    tolerance: float = 1e-4  # of the magnitude: what steps may make of an undamped motion (7e-6 for 360 on the seed)
    resonant: float = 1e-6  # distance of a multiplier from 1: Radau points damp an undamped resonance by 1e-7 of it
    kept: int = 6  # multipliers that are kept


STABILITY = StabilityLimits()
