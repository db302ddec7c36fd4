"""Runs of neighbouring points of a sweep, each for one process.

In a run Newton's method begins each motion from the one before it. Such runs are the same however many processes share
the points, so that the result is the same too. A run also shows which points are peaks while their answers are still
kept.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TypeVar

from fenics_mech.effects.known import EXACT_STRAINS
from fenics_mech.scene import Scene

Task = TypeVar("Task")
LONGEST = 8  # points of a run: processes share runs, and the first point of each begins from nothing


def longest_run(scene: Scene) -> int:
    """Give the most points of a run: 1 where no motion needs Newton's method."""
    exact = scene.effects == "auto" or EXACT_STRAINS in scene.named_effects
    return LONGEST if exact and scene.analysis.method == "periodic" else 1


def runs_of(points: Sequence[Sequence[float]], missing: Collection[int], longest: int) -> list[list[int]]:
    """Split those points that are missing into runs."""
    runs: list[list[int]] = []
    for number, point in enumerate(points):
        changes = sum(here != before for here, before in zip(point, points[number - 1]))
        if number and len(runs[-1]) < longest and changes == 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    left = [[number for number in run if number in missing] for run in runs]
    return [run for run in left if run]


def shrinking_runs(missing: Sequence[int], processes: int) -> list[list[int]]:
    """Split points that do not depend on others into runs, long ones first, so that processes end together."""
    runs, left = [], list(missing)
    while left:
        count = max(1, len(left) // (2 * processes)) if processes > 1 else len(left)
        runs.append(left[:count])
        left = left[count:]
    return runs
