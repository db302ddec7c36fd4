"""Pictures of an optimisation: the history of its trials, and the trade-off between two aims (Pareto)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from fenics_mech.views.figures import COLOURS, empty_figure, finish, save_all
from fenics_mech.views.study_summary import unit_of
from fenics_mech.views.study_units import Told

if TYPE_CHECKING:
    from fenics_mech.studies.design.optimise import Optimum
    from fenics_mech.studies.design.trial import Trial

HEIGHT, PANEL = 4.0, 2.2  # inches, of a figure with one panel, and of each further one
MOST_DRAWN = 4  # aims
PLANE = 2  # aims whose trade-off is a curve
WITHIN: dict[str, Any] = {"ls": "", "marker": ".", "color": COLOURS[0], "label": "within the limits"}
BEYOND: dict[str, Any] = {"ls": "", "marker": "x", "color": COLOURS[1], "label": "beyond a limit"}
FAILED: dict[str, Any] = {"ls": "", "marker": "|", "color": "0.5", "label": "failed"}


def plot_study(found: Optimum, folder: str | Path) -> list[Path]:
    """Make the plots of an optimisation as PNG files in a folder."""
    figures = {"history": history_figure(found)}
    if found.problem.trades_off:
        figures["pareto"] = pareto_figure(found)
    return save_all(figures, folder)


def history_figure(found: Optimum) -> Figure:
    """Draw each aim of every trial, and with one aim the best so far within the limits."""
    problem = found.problem
    aims = problem.aims[:MOST_DRAWN]
    figure, panels = empty_figure(len(aims), HEIGHT + PANEL * (len(aims) - 1))
    within = np.array([problem.rank(trial)[0] == 0 for trial in found.history])
    failed = np.array([trial.failed for trial in found.history])
    at = np.arange(1, len(within) + 1)
    for axes, (name, sign) in zip(panels, aims):
        told = unit_of(found, name)
        values = np.array([trial.numbers[name] for trial in found.history]) / told.size
        for which, style in ((within, WITHIN), (~within & ~failed, BEYOND)):
            if which.any():
                axes.plot(at[which], values[which], **style)
        if failed.any():
            axes.plot(at[failed], 0 * at[failed], transform=axes.get_xaxis_transform(), clip_on=False, **FAILED)
        if within.any() and (len(problem.aims) == 1):
            best = sign * np.minimum.accumulate(np.where(within, sign * values, np.inf))
            best = np.where(np.isfinite(best), best, np.nan)
            axes.step(at, best, where="post", color="black", label="best so far")
        finish(axes, "Trials" if axes is panels[0] else "", told.label(name))
        if axes is not panels[0] and axes.get_legend():
            axes.get_legend().remove()
    panels[-1].set_xlabel("trial")
    panels[-1].xaxis.get_major_locator().set_params(integer=True)
    return figure


def pareto_figure(found: Optimum) -> Figure:
    """Draw the first two aims of every trial within the limits, and those that no other beats."""
    figure, (axes,) = empty_figure()
    problem = found.problem
    (first, _), (second, _), *_ = problem.aims
    within = [trial for trial in found.history if not trial.failed and problem.rank(trial)[0] == 0]
    told = {name: unit_of(found, name) for name in (first, second)}
    axes.plot(*_places(within, told), ".", color="0.7", label="trial within the limits")
    front = sorted(found.front, key=lambda trial: trial.numbers[first])
    line = "o-" if len(problem.aims) == PLANE else "o"  # of more aims the first two are no curve
    axes.plot(*_places(front, told), line, color=COLOURS[0], ms=4, label="none is better in every aim")
    axes.plot(*_places([problem.first], told), "s", color=COLOURS[1], label="start")
    if found.within_limits:
        axes.plot(*_places([found.best], told), "D", color="black", mfc="none", ms=9, label="best.toml")
    axes.set_xlabel(told[first].label(first))
    finish(axes, "Trade-off", told[second].label(second))
    return figure


def _places(trials: Sequence[Trial], told: Mapping[str, Told]) -> list[list[float]]:
    return [[trial.numbers[name] / one.size for trial in trials] for name, one in told.items()]
