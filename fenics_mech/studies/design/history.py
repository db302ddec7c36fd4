"""The trials of a search as a table, which is written as they are known."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fenics_mech._files import csv_text, write_table
from fenics_mech.errors import ResultError
from fenics_mech.studies.design.problem import Problem
from fenics_mech.studies.design.trial import Trial


class History:
    """A CSV file of trials, to which each is added when it is known."""

    def __init__(self, path: Path) -> None:
        self.path, self.written = path, 0

    def follow(self, problem: Problem) -> None:
        """Add the trials that are not written yet, once that of the start is known."""
        if problem.best is None:
            return
        new = problem.history[self.written :]
        rows = [_row(problem, number, trial) for number, trial in enumerate(new, self.written + 1)]
        if not self.written:
            write_table(self.path, [_head(problem)])  # a new file, whatever was in its place
        try:
            with open(self.path, "a", encoding="utf-8", newline="") as file:
                file.write(csv_text(rows))
        except OSError as error:
            raise ResultError(f"{self.path}: cannot be written: {error.strerror}") from error
        self.written += len(new)


def write_trials(problem: Problem, trials: Sequence[Trial], path: Path) -> None:
    """Write trials as a table by the first aim, with their numbers in the history."""
    aim, numbers = problem.aims[0][0], {id(trial): number for number, trial in enumerate(problem.history, 1)}
    rows = [_row(problem, numbers[id(trial)], trial) for trial in sorted(trials, key=lambda one: one.numbers[aim])]
    write_table(path, [_head(problem), *rows])


def _head(problem: Problem) -> list[str]:
    variables = [variable.name for variable in problem.trials.design.variables]
    return ["trial", *variables, *problem.first.numbers, "beyond limits", "seconds", "error"]


def _row(problem: Problem, number: int, trial: Trial) -> list[object]:
    beyond = problem.rank(trial)[0]
    return [number, *trial.values, *trial.numbers.values(), beyond, trial.seconds, trial.error]
