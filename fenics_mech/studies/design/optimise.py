"""The best values of a study's variables: a search, and the whole analysis of what it found."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from fenics_mech._files import csv_text, write_table
from fenics_mech.analysis import analyse
from fenics_mech.errors import MechanismError, ResultError, SceneError
from fenics_mech.recovery import Result
from fenics_mech.scene import Scene
from fenics_mech.scene.rewriting import write_like
from fenics_mech.scene.writing import write_scene
from fenics_mech.studies.design.methods import METHODS, Ending, Search
from fenics_mech.studies.design.problem import Problem, bounds_of
from fenics_mech.studies.design.trial import Trial, Trials, kept_folder, read_numbers
from fenics_mech.studies.lead_process import led
from fenics_mech.studies.worker_processes import Workers


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


def _head(problem: Problem) -> list[str]:
    variables = [variable.name for variable in problem.trials.design.variables]
    return ["trial", *variables, *problem.first.numbers, "beyond limits", "seconds", "error"]


def _row(problem: Problem, number: int, trial: Trial) -> list[object]:
    beyond = problem.rank(trial)[0]
    return [number, *trial.values, *trial.numbers.values(), beyond, trial.seconds, trial.error]


ERRORS = {  # attribute of a result with the relative error of a number, by how its name begins
    "strain": "error_estimate",
    "stress": "error_estimate",
    "utilisation": "error_estimate",
    "deflection": "deflection_error_estimate",
    "joint_force": "joint_force_error_estimate",
    "support": "joint_force_error_estimate",
    "shaking": "joint_force_error_estimate",
    "input_torque": "drive_effort_error_estimate",
    "drive_effort": "drive_effort_error_estimate",
}


@dataclass(frozen=True)
class Optimum:
    """What a search found.

    Parameters
    ----------
    problem
        The study as a problem of optimisation, with all trials in `history`.
    best
        The best trial.
    result
        The whole analysis of the best scene, with estimates of errors.
    ending
        How the search ended; of several the first that did not converge.
    seconds
        How long all took.

    Examples
    --------
    >>> study = {"maximise": ["input_torque.max"]}
    >>> study["variables"] = {"speed": {"numbers": ["drive.speed"], "between": [10, 40]}}
    >>> quasi_static = {"analysis.method": "quasi-static", "analysis.sub_intervals": 36, "effects": (), "study": study}
    >>> best = fm.optimise(fm.load("demos/four_bar.toml").changed(quasi_static))
    >>> round(best.scene.drive.speed, 6)
    40.0
    """

    problem: Problem
    best: Trial
    result: Result
    ending: Ending
    seconds: float

    @property
    def scene(self) -> Scene:
        """The best scene, with its study."""
        return best_scene(self.problem, self.best)

    @property
    def history(self) -> list[Trial]:
        """All trials, in order."""
        return self.problem.history

    @property
    def front(self) -> list[Trial]:
        """The trials between which only a preference decides, where there are several aims."""
        return self.problem.front

    @property
    def within_limits(self) -> bool:
        """Whether the best trial keeps all limits."""
        return self.problem.rank(self.best)[0] == 0

    def gains(self) -> dict[str, float]:
        """By which share each aim is better than at the start."""
        first, found = self.problem.first, {}
        for name, sign in self.problem.aims:
            start, best = first.numbers[name], self.best.numbers[name]
            found[name] = sign * (start - best) / (abs(start) or 1.0)
        return found

    def errors(self) -> dict[str, float]:
        """Estimated relative error of each aim in the trials; NaN where none is estimated.

        Where the best scene is analysed as a whole on a finer mesh than trials have, what that changes counts too.
        """
        known = {}
        for quantity in self.problem.trials.quantities:
            key = next((key for start, key in ERRORS.items() if quantity.name.startswith(start)), "")
            known[quantity.text] = float(self.result.data.attrs.get(key, np.nan)) if quantity.name != "mass" else 0.0
            if quantity.name == "frequency":
                known[quantity.text] = float(self.result.data["frequency_error"].max())
        aims = {name: known[name] for name, _ in self.problem.aims}
        if "refined" in self.result.data.attrs:
            trials = self.problem.trials
            finer = read_numbers(trials.quantities, self.result, trials.design.study.targets)
            changes = {name: abs(finer[name] / (self.best.numbers[name] or math.inf) - 1) for name in aims}
            aims = {name: error + changes[name] for name, error in aims.items()}
        return aims


def best_scene(problem: Problem, trial: Trial) -> Scene:
    """Give the scene of a trial, with its study."""
    design = problem.trials.design
    return design.scene.changed(design.changes(trial.values) | {"study": design.study})


@led
def optimise(
    scene: Scene,
    folder: str | Path | None = None,
    *,
    method: str | None = None,
    starts: int = 1,
    search: Search | None = None,
    jobs: int = 1,
    like: str | Path | None = None,
    progress: Callable[[int, Trial, Trial | None], None] = lambda count, trial, best: None,
) -> Optimum:
    """Search for the best values of the variables of a scene's study.

    Trials are analysed without estimates of errors, and with stability only where the study asks for it. The best of
    them is analysed again as the scene states.

    Parameters
    ----------
    scene
        The scene, with its study.
    folder
        Where finished trials are kept, so that a search that was ended goes on, with ``history.csv`` and ``best.toml``.
    method
        One of `METHODS`. By default "nsga2" for several aims, "differential-evolution" with choices, else "slsqp".
    starts
        Number of searches: the first from the study's start, the others from seeded random ones.
    search
        How far a search goes.
    jobs
        Processes of this machine that share trials. Those of `mpirun` share them too: all call this and get the same.
    like
        The file of the scene, whose units ``best.toml`` keeps, and its comments where it states all values.
        Without it, that has numbers in SI.
    progress
        Called with the number of trials, the last and the best after each.

    Raises
    ------
    SceneError
        When the study is not valid, or the scene fails at its start.
    MechanismError
        When the method needs a library that is not installed, or no file can be written.

    Examples
    --------
    >>> study = {"minimise": ["strain.max"]}
    >>> study["variables"] = {"ratio": {"numbers": ["drive.speed"], "between": [10, 40]}}
    >>> quasi_static = {"analysis.method": "quasi-static", "analysis.sub_intervals": 36, "effects": (), "study": study}
    >>> found = fm.optimise(fm.load("demos/four_bar.toml").changed(quasi_static))
    >>> round(found.scene.drive.speed, 3)
    10.0
    """
    begun, search = time.perf_counter(), search or Search()
    with kept_folder(folder) as kept, Workers(jobs) as workers:
        trials = Trials.of(scene, folder=kept / "trials", workers=workers)
        bounds_of(trials.design.study)  # which says what is wrong with a limit
        name, trials = _method(Problem(trials), method), trials.with_fixed_effects()
        history = History(kept / "history.csv")

        def known(count: int, trial: Trial, best: Trial | None) -> None:
            history.follow(problem)
            progress(count, trial, best)

        problem = Problem(trials, known, squares=name == "least-squares")
        problem.first  # noqa: B018  (it says what is wrong with the start)
        points = np.random.default_rng(search.seed).random((starts, len(problem.trials.design.variables)))
        points[0] = problem.to_unit(problem.trials.design.start)
        endings = [METHODS[name](problem, point, search) for point in points]
        best = problem.best
        assert best is not None
        if folder is not None:
            history.follow(problem)
            written, values = best_scene(problem, best), problem.trials.design.changes(best.values)
            path = kept / "best.toml"
            write_scene(written, path) if like is None else write_like(like, values, written, path)
            if problem.trades_off:
                front = sorted(problem.front, key=lambda one: one.numbers[problem.aims[0][0]])  # by the first aim
                rows = [_row(problem, problem.history.index(trial) + 1, trial) for trial in front]
                write_table(kept / "front.csv", [_head(problem), *rows])
        result = _analysed_whole(best_scene(problem, best).changed(effects=scene.effects), folder)
        ending = min(endings, key=lambda one: one.converged)
        found = Optimum(problem, best, result, ending, time.perf_counter() - begun)
        if folder is not None:
            found.result.save(kept / "result.nc")
    return found


def _analysed_whole(best: Scene, folder: str | Path | None) -> Result:
    """Analyse the best scene with estimates of errors, which may refuse what trials do not look at."""
    try:
        return analyse(best)
    except MechanismError as error:
        where = "" if folder is None else f", {Path(folder) / 'best.toml'},"
        message = f"the best scene{where} was found, and its whole analysis with estimates of errors fails: {error}"
        raise MechanismError(message) from error


def _method(problem: Problem, method: str | None) -> str:
    """Choose the method, or raise where the one that is asked for does not suit the study."""
    aims, choices = problem.aims, any(variable.choices for variable in problem.trials.design.variables)
    if not aims:
        raise SceneError("there is nothing to optimise", place="study", hint='Write minimise = ["mass"] or maximise')
    if method is not None and method not in METHODS:
        raise SceneError(f"there is no method {method!r}", place="--method", hint=f"Known: {', '.join(METHODS)}")
    if method is None:
        method = "nsga2" if len(aims) > 1 else "differential-evolution" if choices else "slsqp"
    if len(aims) > 1 and method not in ("nsga2", "least-squares"):
        raise SceneError(f"{method} takes one aim, and there are {len(aims)}", place="study", hint="Take nsga2")
    if choices and method not in ("nsga2", "differential-evolution"):
        raise SceneError(f"{method} takes no choices", place="study", hint="Take differential-evolution or nsga2")
    if method == "least-squares" and problem.trials.design.study.limits:
        raise SceneError("least squares know no limits", place="study.limits", hint="Take --method slsqp")
    if method == "nsga2" and find_spec("pymoo") is None:
        message = "several aims need the library pymoo, which is not installed: pip install 'fenics_mech[optimise]'"
        raise MechanismError(message)
    return method
