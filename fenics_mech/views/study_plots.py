"""Pictures of an optimisation: the history of its trials, and the trade-off between two aims (Pareto)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from fenics_mech.views.figures import COLOURS, empty_figure, save_all
from fenics_mech.views.study_units import Told, number_unit

if TYPE_CHECKING:
    from fenics_mech.studies.design.optimise import Optimum
    from fenics_mech.studies.design.trial import Trial


def plot_study(found: Optimum, folder: str | Path) -> list[Path]:
    """Make the plots of an optimisation as PNG files in a folder.

    Parameters
    ----------
    found
        The optimum.
    folder
        Where to write.

    Raises
    ------
    ResultError
        When a file cannot be written.
    """
    figures = {"history": history_figure(found)}
    if len(found.problem.aims) > 1 and not found.problem.squares:
        figures["pareto"] = pareto_figure(found)
    return save_all(figures, folder)


def history_figure(found: Optimum) -> Figure:
    """Draw the first aim of every trial, and the best so far within the limits."""
    figure, (axes,) = empty_figure()
    problem, name = found.problem, found.problem.aims[0][0]
    told = _told(found, name)
    values = np.array([trial.numbers[name] for trial in found.history]) / told.size
    within = np.array([problem.rank(trial)[0] == 0 for trial in found.history])
    at = np.arange(1, len(values) + 1)
    axes.plot(at[within], values[within], ".", color=COLOURS[0], label="within the limits")
    axes.plot(at[~within], values[~within], "x", color=COLOURS[1], label="beyond a limit")
    sign = problem.aims[0][1]
    best = sign * np.minimum.accumulate(np.where(within, sign * values, np.inf))
    axes.step(at, np.where(np.isfinite(best), best, np.nan), where="post", color="black", label="best so far")
    axes.set_xlabel("trial")
    axes.xaxis.get_major_locator().set_params(integer=True)
    axes.set_ylabel(told.label(name))
    axes.legend()
    return figure


def pareto_figure(found: Optimum) -> Figure:
    """Draw the first two aims of every trial within the limits, and those that no other beats."""
    figure, (axes,) = empty_figure()
    problem = found.problem
    (first, _), (second, _), *_ = problem.aims
    within = [trial for trial in found.history if not trial.failed and problem.rank(trial)[0] == 0]
    told = {name: _told(found, name) for name in (first, second)}
    axes.plot(*_places(within, told), ".", color="0.7", label="trials within the limits")
    front = sorted(found.front, key=lambda trial: trial.numbers[first])
    axes.plot(*_places(front, told), "o-", color=COLOURS[0], label="none is better in all aims")
    axes.plot(*_places([problem.first], told), "s", color=COLOURS[1], label="start")
    axes.set_xlabel(told[first].label(first))
    axes.set_ylabel(told[second].label(second))
    axes.legend()
    return figure


def _places(trials: Sequence[Trial], told: Mapping[str, Told]) -> list[list[float]]:
    return [[trial.numbers[name] / one.size for trial in trials] for name, one in told.items()]


def _told(found: Optimum, name: str) -> Told:
    trials = found.problem.trials
    return number_unit(next(one for one in trials.quantities if one.text == name), trials.design)
