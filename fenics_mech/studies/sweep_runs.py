"""Runs of neighbouring points of a sweep, in which Newton's method begins each motion from the one before it.

They are the same however many processes share the points, so that the result is the same too.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from fenics_mech.effects.large_rotations import EFFECT as LARGE_ROTATIONS
from fenics_mech.scene import Scene

LONGEST = 8  # points of a run: processes share runs, and the first point of each begins from nothing


def longest_run(scene: Scene) -> int:
    """Give the most points of a run: 1 where no motion needs Newton's method.

    Parameters
    ----------
    scene
        The scene.
    """
    exact = scene.effects == "auto" or LARGE_ROTATIONS.name in scene.named_effects
    return LONGEST if exact and scene.analysis.method == "periodic" else 1


def runs_of(points: Sequence[Sequence[float]], missing: Collection[int], longest: int) -> list[list[int]]:
    """Split those points that are missing into runs.

    Parameters
    ----------
    points
        Values of the swept fields of all points, in their order.
    missing
        Numbers of the points to be computed.
    longest
        Most points of a run.

    Returns
    -------
    list
        Numbers of the points of each run. In all of its points but one field has the same value.
    """
    runs: list[list[int]] = []
    for number, point in enumerate(points):
        changes = sum(here != before for here, before in zip(point, points[number - 1]))
        if number and len(runs[-1]) < longest and changes == 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    left = [[number for number in run if number in missing] for run in runs]
    return [run for run in left if run]
