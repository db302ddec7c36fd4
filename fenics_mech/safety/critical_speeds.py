"""Speeds at which a harmonic of the drive meets a mode: how strong each is, how broad, and how far the present one is.

A harmonic whose strain without vibration is the share s of the peak makes ``s |H|`` near the mode, with

    ``1/|H|^2 = (1 - r^2)^2 + (2 zeta r)^2``,

r being the speed over the critical one. Source: Den Hartog, Mechanical Vibrations, section 2.8.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fenics_mech.recovery.result import Result

STRONG = 0.2  # of the peak strain: two fifths of what a factor of safety of 1.5 keeps for all that is not known


@dataclass(frozen=True)
class CriticalSpeed:
    """A speed at which a harmonic of the drive meets a mode."""

    speed: float  # rate of the drive's cycle (rad/s)
    distance: float  # by which share of the present speed it is above that; negative below
    order: float  # multiple of the drive's rate
    mode: int  # number of the mode, from 1
    modes: tuple[int, ...]  # that of the mode, and of those with which it veers, ascending
    link: str  # link that has the largest part of the mode
    share: float  # strain that the harmonic makes on the mode without vibration, over the peak strain (1)
    damping: float  # damping ratio of the mode

    @property
    def rise(self) -> float:
        """What vibration in the mode by itself adds to the peak strain, over that; infinite where nothing damps it."""
        if not self.damping:
            return math.inf if self.share else 0.0
        if self.damping >= math.sqrt(0.5):  # beyond it there is no peak
            return 0.0
        return self.share * (1 / (2 * self.damping * math.sqrt(1 - self.damping**2)) - 1)

    @property
    def band(self) -> tuple[float, float] | None:
        """Rates between which vibration adds more than `STRONG` of the peak strain (rad/s); None if nowhere."""
        if self.rise <= STRONG:
            return None
        gain, middle = 1 + STRONG / self.share, 1 - 2 * self.damping**2
        half = math.sqrt(middle**2 - 1 + gain**-2)  # of r^2, where |H| is the gain
        return self.speed * math.sqrt(max(middle - half, 0.0)), self.speed * math.sqrt(middle + half)

    @property
    def numbered(self) -> str:
        """The mode in words."""
        numbers = [str(mode) for mode in self.modes]
        return f"modes {', '.join(numbers[:-1])} and {numbers[-1]} together" if numbers[1:] else f"mode {numbers[0]}"

    @property
    def name(self) -> str:
        """The mode and its link in words."""
        return f"{self.numbered}, link {self.link}"


class Nearest(NamedTuple):
    """The strong critical speed that is nearest to the present speed."""

    margin: float  # distance from it over the present speed, 0 or more
    words: str  # which harmonic meets which mode there
    link: str  # link that has the largest part of the mode


def critical_speeds(result: Result) -> list[CriticalSpeed]:
    """Give all critical speeds of a result, the strongest first; none where it has none."""
    data = result.data
    if "critical_speed" not in data:
        return []
    speed, order, load = (
        data[f"critical_{name}"].transpose("mode", "order").to_numpy() for name in ("speed", "order", "share")
    )
    group, damping = data["mode_group"].to_numpy(), data["mode_damping"].to_numpy()
    numbers, links = data["mode"].to_numpy(), data["link"].to_numpy()
    shares = data["mode_share"].transpose("mode", "link").to_numpy()
    rate, found = abs(result.scene.cycle_rate), []
    for m, n in np.argwhere(np.isfinite(speed) & np.isfinite(load)):
        of_mode = CriticalSpeed(
            speed=float(speed[m, n]),
            distance=float(speed[m, n]) / rate - 1,
            order=float(order[m, n]),
            mode=int(numbers[m]),
            modes=tuple(int(mode) for mode in numbers[group == group[m]]),
            link=str(links[shares[m].argmax()]),
            share=float(load[m, n]),
            damping=float(damping[m]),
        )
        found.append(of_mode)
    return sorted(found, key=lambda one: (-one.rise, -one.share))


def speeds_to_avoid(result: Result, each: int = 2) -> list[CriticalSpeed]:
    """Give the nearest strong critical speeds below and above the present one, the strongest first."""
    # Of two that are nearer to each other than either is broad, the stronger one is given.
    strong: list[CriticalSpeed] = []
    for one in critical_speeds(result):
        if one.band and not any(abs(one.speed / other.speed - 1) < other.damping for other in strong):
            strong.append(one)
    sides = [one for one in strong if one.distance < 0], [one for one in strong if one.distance >= 0]
    nearest = [one for side in sides for one in sorted(side, key=lambda one: abs(one.distance))[:each]]
    return sorted(nearest, key=strong.index)


def resonance_margin(result: Result) -> Nearest | None:
    """Give the distance of the present speed from the nearest strong critical speed; None where none is known.

    Parameters
    ----------
    result
        The result.
    """
    nearest = min(speeds_to_avoid(result), key=lambda one: abs(one.distance), default=None)
    if nearest is None:
        return None
    words = f"{cause_of(result, nearest)}: {turns(result, nearest.speed)}"
    return Nearest(abs(nearest.distance), words, nearest.link)


def cause_of(result: Result, one: CriticalSpeed) -> str:
    """Say which multiple of the drive, or of the cycle that drives have in common, meets which mode."""
    return f"{one.name}, {multiple_of(result, one)}"


def multiple_of(result: Result, one: CriticalSpeed) -> str:
    """Say at which multiple of the drive, or of the cycle that drives have in common, a mode is met."""
    return f"at {one.order:g} times the {'drive' if len(result.scene.drives) == 1 else 'cycle'}"


def multiplier_distances(result: Result) -> dict[int, float]:
    """Give the distance ``|1 - mu|`` from resonance of the present motion, by mode, of those that are known."""
    data, found = result.data, dict[int, float]()
    if "multiplier_mode" not in data:
        return found
    real, imaginary = data["multiplier"].transpose("part", "disturbance").to_numpy()
    for mode, distance in zip(data["multiplier_mode"].to_numpy(), np.hypot(1 - real, imaginary)):
        found[int(mode)] = min(float(distance), found.get(int(mode), math.inf))
    return found


def turns(result: Result, *rates: float) -> str:
    """Write rates of the drive's cycle in turns a minute, or in cycles where they are no turns of one drive."""
    # rates: rates (rad/s): one, or the ends of a range
    drives, data = result.scene.drives, result.data
    turning = len(drives) == 1 and drives[0].speed is not None and data["input_torque"].attrs.get("units") != "N"
    numbers = [rate * 30 / math.pi for rate in rates]
    digits = 0 if min(numbers) >= 100 else 1
    said = "\N{EN DASH}".join(dict.fromkeys(f"{number:.{digits}f}" for number in numbers))  # a narrow range is one
    return f"{said} {'rpm' if turning else 'cycles/min'}"
