"""The last answers of a sweep: where a point turns out to be a peak, its errors are estimated from its answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fenics_mech._guard import guarded
from fenics_mech.accuracy.estimate import Errors
from fenics_mech.effects.effect import Choice
from fenics_mech.recovery.fields import Fields
from fenics_mech.recovery.labelled import errors_of
from fenics_mech.response.few_nodes import FEW_NODES
from fenics_mech.response.setup import CommonParts
from fenics_mech.response.solution import Solution
from fenics_mech.solve.last_motions import LastMotions

KEPT_ANSWERS = 2  # a point is known as a peak when the next one is computed
LARGEST = 30_000  # numbers of a displacement over the cycle: an answer of that size takes 0.1 GB
Answer = tuple[Solution, Fields, Sequence[Choice]]


class PointParts(CommonParts):
    """What points of a sweep have in common, and the answers of the last ones."""

    def __init__(self) -> None:
        super().__init__()
        self.last: LastMotions[Any] = LastMotions()
        self._answer: Answer | None = None
        self._answers: dict[Path, Answer] = {}

    def answered(self, solution: Solution, fields: Fields, choices: Sequence[Choice]) -> None:
        """Take note of an answer, unless it is large.

        Parameters
        ----------
        solution, fields, choices
            The response, what was recovered from it, and what was decided about each effect.
        """
        fine = np.bincount(solution.system.beams.mesh.cell_member).max() > FEW_NODES.from_elements
        large = solution.response.displacement.size > LARGEST
        self._answer = None if fine or large else (solution, fields, choices)  # estimates solve fine meshes another way

    def keep_answer(self, path: Path) -> None:
        """Keep the last answer.

        Parameters
        ----------
        path
            The file of its motion, by which it is found again.
        """
        last = list(self._answers.items())[1 - KEPT_ANSWERS :]
        self._answers = dict(last) if self._answer is None else {**dict(last), path: self._answer}
        self._answer = None

    @guarded()
    def errors(self, path: Path, estimates: bool | Literal["contacts"]) -> Errors | None:
        """Estimate the errors of an answer that is kept, however large they are; None where it is not.

        Parameters
        ----------
        path
            The file of its motion.
        estimates
            What its scene says of estimates, True or "contacts".
        """
        if path not in self._answers:
            return None
        solution, fields, choices = self._answers.pop(path)
        analysis = solution.scene.analysis.model_copy(update={"error_estimates": estimates, "allow_coarse": True})
        scene = solution.scene.model_copy(update={"analysis": analysis})
        return errors_of(replace(solution, scene=scene), fields, choices)
