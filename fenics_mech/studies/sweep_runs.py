"""Runs of neighbouring points of a sweep, each for one process.

In a run Newton's method begins each motion from the one before it. Such runs are the same however many processes share
the points, so that the result is the same too. A run also shows which points are peaks while their answers are still
kept.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from typing import TypeVar

from fenics_mech.effects.large_rotations import EFFECT as LARGE_ROTATIONS
from fenics_mech.scene import Scene
from fenics_mech.studies.sweep_peaks import peaks_of
from fenics_mech.studies.sweep_points import stacked

Task = TypeVar("Task")
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


def shrinking_runs(missing: Sequence[int], processes: int) -> list[list[int]]:
    """Split points that do not depend on others into runs, long ones first, so that processes end together.

    Parameters
    ----------
    missing
        Numbers of the points to be computed.
    processes
        Number of processes that share them: one has one run.

    Returns
    -------
    list
        Numbers of the points of each run: half of what each process would have of those that are left.
    """
    runs, left = [], list(missing)
    while left:
        count = max(1, len(left) // (2 * processes)) if processes > 1 else len(left)
        runs.append(left[:count])
        left = left[count:]
    return runs


def with_peaks(
    run: Sequence[int],
    count: int,
    task: Callable[[int], Task],
    errors_of: Callable[[int], Task],
    strains: Callable[[int], Sequence[float] | None],
) -> Iterator[Task]:
    """Give the tasks of a run of points along a line, each followed by those of the peaks and ends that it reveals.

    Parameters
    ----------
    run
        Numbers of the points.
    count
        Number of points of the whole line.
    task, errors_of
        Give the task of a point, and that of the errors at a peak or an end.
    strains
        Gives the values of all curves at a point whose task is done; None where it failed.

    Yields
    ------
    Task
        Each is asked for when the one before it is done.
    """
    known: dict[int, Sequence[float] | None] = {}  # of the last three
    for index in run:
        yield task(index)
        known = dict([*known.items(), (index, strains(index))][-3:])
        for at in (index - 1, index):
            beside = range(max(at - 1, 0), min(at + 2, count))
            if at >= 0 and known.keys() >= set(beside) and known[at] is not None:
                curves = stacked([known[number] for number in beside])
                if at in (0, count - 1) or peaks_of(curves, 1)[beside.index(at)]:
                    yield errors_of(at)
