"""The last answers of a sweep: where a point turns out to be a peak, its errors are told without a second analysis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from fenics_mech._guard import guarded
from fenics_mech.accuracy.estimate import Errors
from fenics_mech.effects.effect import Choice
from fenics_mech.recovery.labelled import recovered
from fenics_mech.response.few_nodes import FEW_NODES
from fenics_mech.response.setup import CommonParts
from fenics_mech.response.solution import Solution
from fenics_mech.scene import Scene

KEPT_ANSWERS = 2  # a point is known as a peak when the next one is computed
MOST = 30_000  # numbers of a displacement over the cycle: with all that is kept of it, 0.1 GB
Answer = tuple[Solution, Sequence[Choice]]


class PointParts(CommonParts):
    """What points of a sweep have in common, and the answers of the last ones."""

    def __init__(self) -> None:
        super().__init__(begin_from_last=True)
        self._answer: Answer | None = None
        self._answers: dict[Path, Answer] = {}

    def answered(self, solution: Solution, choices: Sequence[Choice]) -> None:
        """Take note of an answer, unless it is large.

        Parameters
        ----------
        solution, choices
            The response, and what was decided about each effect.
        """
        fine = np.bincount(solution.system.beams.mesh.cell_member).max() > FEW_NODES.from_elements
        large = solution.response.displacement.size > MOST
        self._answer = None if fine or large else (solution, choices)  # estimates solve fine meshes another way

    def keep_answer(self, path: Path) -> None:
        """Keep the last answer.

        Parameters
        ----------
        path
            The file of its point.
        """
        last = list(self._answers.items())[1 - KEPT_ANSWERS :]
        self._answers = dict(last) if self._answer is None else {**dict(last), path: self._answer}
        self._answer = None

    @guarded()
    def errors(self, path: Path, scene: Scene) -> Errors | None:
        """Estimate the errors of an answer that is kept; None where it is not.

        Parameters
        ----------
        path
            The file of its point.
        scene
            The scene of the point with estimates.

        Raises
        ------
        UnresolvedError
            When a numerical error is too large.
        """
        if path not in self._answers:
            return None
        solution, choices = self._answers.pop(path)
        stated = solution.scene.changed(analysis__error_estimates=scene.analysis.error_estimates)
        return recovered(replace(solution, scene=stated), choices, lambda step: None)[1]
