"""When impulses strike in a motion in time, and when a drive comes to an angle."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.scene.models import Scene

ROUNDING = 1e-12  # of a whole motion, by which an impulse may be beside an instant
SAME = 1e-9  # of a cycle, between times that count as one
PLACES = 200  # of a cycle, between which a run-up turns in one sense


@dataclass(frozen=True)
class Strike:
    """Impulses that strike at one time."""

    time: float  # s
    names: tuple[str, ...]


def strikes_between(scene: Scene, start: float, end: float) -> tuple[Strike, ...]:
    """Give the impulses from `start` to `end` (s) in the order of time; one at the start strikes at time 0 only."""
    found: dict[float, tuple[str, ...]] = {}
    rounding = ROUNDING * max(abs(end), scene.period)
    for name, impulse in scene.impulses.items():
        times = [impulse.time] if impulse.angle is None else passages(scene, impulse.angle, start, end).tolist()
        for time in times:
            if time is None or time >= end - rounding or time < start or (time <= start + rounding and start > 0):
                continue
            same = next((other for other in found if abs(other - time) <= rounding), time)
            found[same] = (*found.get(same, ()), name)
    return tuple(Strike(time, found[time]) for time in sorted(found))


def passages(scene: Scene, angle: float, start: float, end: float) -> Array:
    """Ascending times (s) at which the drive is at an angle (rad) in any cycle, `start` only where it is 0."""
    period, run_up = scene.period, scene.drives[0].run_up or 0.0
    sense = math.copysign(1, scene.cycle_rate)

    def turns(time: Array) -> Array:
        return sense * (scene.coordinate(time).value - angle) / TURN

    done = float(turns(np.array([run_up]))[0])
    first = run_up + period * (math.ceil(done - 1e-12) - done)
    found = [first + period * np.arange(math.ceil(end / period) + 2)]
    if run_up:
        grid = np.linspace(0, run_up, PLACES * (math.ceil(run_up / period) + 1))
        found.append(_crossings(turns, grid))
    times = np.unique(np.concatenate(found))
    same = SAME * period
    times = times[np.diff(times, prepend=-np.inf) > same]
    return times[(times <= end + same) & ((times > start + same) | ((start == 0) & (times >= 0)))]


def _crossings(turns: Callable[[Array], Array], grid: Array) -> Array:
    """Times on a grid, and between its points, at which a number of turns is whole."""
    from scipy.optimize import brentq  # noqa: PLC0415  (slow to import, and few scenes have jumps)

    values = turns(grid)
    found = list(grid[values == np.round(values)])
    for before, after, low, high in zip(grid, grid[1:], values, values[1:]):
        for whole in range(math.floor(min(low, high)) + 1, math.ceil(max(low, high))):
            found.append(brentq(lambda time, whole=whole: turns(np.array([time]))[0] - whole, before, after))
    return np.array(found)
