"""An optimisation for people: what was found, variables, numbers with their limits, history of trials and trade-off."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from fenics_mech.errors import percent
from fenics_mech.planning.answer_remarks import in_words
from fenics_mech.studies.design.design_variables import Design
from fenics_mech.studies.design.problem import WITHIN as ROUNDED
from fenics_mech.studies.design.result_numbers import Quantity
from fenics_mech.views.figures import COLOURS, empty_figure, finish, save_all
from fenics_mech.views.study_units import Told, cost_of, failures_of, number_unit, variable_unit
from fenics_mech.views.tables import table_of

if TYPE_CHECKING:
    from fenics_mech.scene import Scene
    from fenics_mech.studies.design.optimise import Optimum
    from fenics_mech.studies.design.trial import Trial

HEIGHT, PANEL = 4.0, 2.2  # inches, of a figure with one panel, and of each further one
MOST_DRAWN = 4  # aims
PLANE = 2  # aims whose trade-off is a curve
WITHIN: dict[str, Any] = {"ls": "", "marker": ".", "color": COLOURS[0], "label": "within the limits"}
BEYOND: dict[str, Any] = {"ls": "", "marker": "x", "color": COLOURS[1], "label": "beyond a limit"}
FAILED: dict[str, Any] = {"ls": "", "marker": "|", "color": "0.5", "label": "failed"}


def study_summary(found: Optimum) -> Group:
    """Tell what an optimisation found."""
    said, why = found.ending.message.rstrip("."), found.problem.why_differences
    end = "" if found.ending.converged else f" It was not searched to the end ({said}): more --steps may find better."
    cost = f"{cost_of(found.history, found.seconds, 0)} The search ended with: {said}."
    cost += f" Derivatives are differences of trials, as {why}." if why else ""
    parts: list[RenderableType] = [Text(f"{verdict(found)}{end}", style="bold"), _variables(found), _numbers(found)]
    parts.append(Text(cost))
    if kinds := failures_of(found.history):
        parts.append(Text(f"Trials that failed, and were passed over: {kinds}."))
    if finer := in_words(str(found.result.data.attrs.get("refined", ""))):
        why = "as the program may choose mesh and steps. What that changes counts in the error"
        parts.append(Text(f"The best scene was analysed with {finer}, {why}. State them in the scene for all trials."))
    return Group(*parts)


def best_so_far(scene: Scene, best: Trial | None) -> str:
    """Tell the numbers of the best trial so far, with a comma before them; nothing where there is none."""
    if best is None or scene.study is None:
        return ""
    design = Design(scene, scene.study, ())
    told = {name: number_unit(Quantity.read(name), design, value) for name, value in best.numbers.items()}
    return ", best " + ", ".join(f"{name} {told[name].whole(value, 4)}" for name, value in best.numbers.items())


def verdict(found: Optimum) -> str:
    """Say in one or two sentences whether there is a better design, and whether it is better than its error."""
    if not found.within_limits:
        return f"No trial keeps all limits. In the nearest one {missed(found)}. Widen the bounds, or relax a limit."
    if found.problem.squares:
        gain = 1 - math.sqrt(found.problem.size(found.best) / found.problem.size(found.problem.first))
        return f"The root of the sum of the squares is {percent(gain, 3)} less than at the start."
    if len(found.problem.aims) > 1:
        return (
            f"{len(found.front)} designs are best in their own way: none is better than another in every aim. The "
            "tables and best.toml hold the one with the least sum of all aims, over those of the start."
        )
    ((name, gain),), error = found.gains().items(), found.errors()[found.problem.aims[0][0]]
    if gain <= 0:
        return f"No better design than the start was found for {name}."
    better = f"{name} is {percent(gain, 3)} better than at the start, within all limits."
    if not math.isfinite(error):
        return f"{better} The error of this number is not estimated."
    if gain < error:
        return f"{better} This gain is below the estimated error of {percent(error)}: it may be none."
    return better + (f" Its estimated error is {percent(error)}." if error else "")


def missed(found: Optimum) -> str:
    """Say which limits the best trial misses, and by how much."""
    problem, said = found.problem, []
    for bound, excess in zip(problem.bounds, problem.excess_of(found.best)):
        if excess > ROUNDED:
            number, told = found.best.numbers[bound.of], unit_of(found, bound.of)
            beyond = bound.sign * (number - bound.limit)
            far = f" ({percent(beyond / abs(bound.limit))} beyond it)" if bound.limit else ""
            said.append(
                f"{bound.of} is {told.whole(number)}, where {bound.words} {told.whole(bound.limit)} is asked{far}"
            )
    return ", and ".join(said)


def unit_of(found: Optimum, name: str) -> Told:
    """Give the unit of a number of an optimisation, which fits it at the start and in the best design."""
    trials = found.problem.trials
    shown = [trial.numbers[name] for trial in (found.problem.first, found.best)]
    return number_unit(trials.quantity(name), trials.design, shown)


def _variables(found: Optimum) -> Table:
    table = table_of("Variables", "variable", "start", "best", "bounds", "unit")
    problem = found.problem
    for variable, start, best in zip(problem.trials.design.variables, problem.first.values, found.best.values):
        told = variable_unit(variable, problem.trials.design.scene)
        shown = [str(variable.shown(v)) if variable.choices else told.text(v) for v in (start, best)]
        near = 1e-6 * (variable.upper - variable.lower)
        at = min(best - variable.lower, variable.upper - best) <= near and not variable.choices
        bounds = f"{told.text(variable.lower)} to {told.text(variable.upper)}" + " (reached)" * at
        table.add_row(variable.name, *map(escape, shown), "choice" if variable.choices else bounds, told.unit)
    return table


def _numbers(found: Optimum) -> Table:
    table = table_of("Numbers of the result", "number", "start", "best", "limit", "unit")
    problem = found.problem
    for quantity in problem.trials.quantities:
        name, told = quantity.text, unit_of(found, quantity.text)
        limits = [f"{'most' if b.sign > 0 else 'least'} {told.text(b.limit)}" for b in problem.bounds if b.of == name]
        values = [told.text(trial.numbers[name]) for trial in (problem.first, found.best)]
        table.add_row(escape(name), *values, ", ".join(limits), told.unit)
    return table


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
