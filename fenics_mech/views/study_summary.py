"""Summary of an optimisation: what was found first, then the variables, and the numbers with their limits."""

from __future__ import annotations

import math
from collections import Counter
from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from fenics_mech.errors import percent
from fenics_mech.planning.answer_remarks import in_words
from fenics_mech.studies.design.design_variables import Design
from fenics_mech.studies.design.problem import PROBLEM
from fenics_mech.studies.design.result_numbers import Quantity
from fenics_mech.views.study_units import Told, number_unit, variable_unit
from fenics_mech.views.tables import table_of

if TYPE_CHECKING:
    from fenics_mech.scene import Scene
    from fenics_mech.studies.design.optimise import Optimum
    from fenics_mech.studies.design.trial import Trial


def study_summary(found: Optimum) -> Group:
    """Tell what an optimisation found."""
    parts: list[RenderableType] = [
        Text(f"{verdict(found)} {_end(found)}".rstrip(), style="bold"),
        _variables(found),
        _numbers(found),
        Text(_cost(found)),
    ]
    if failures := Counter(trial.error for trial in found.history if trial.failed):
        kinds = ", ".join(f"{count} with {kind}" for kind, count in failures.items())
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
        several = f"{len(found.front)} designs are best in their own way: none is better than another in every aim."
        return (
            f"{several} The tables and best.toml hold the one with the least sum of all aims, over those of the start."
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
        number = found.best.numbers[bound.of]
        beyond = bound.sign * (number - bound.limit)
        if excess > PROBLEM.within:
            told = unit_of(found, bound.of)
            far = f" ({percent(beyond / abs(bound.limit))} beyond it)" if bound.limit else ""
            asked = f"{bound.words} {told.whole(bound.limit)} is asked"
            said.append(f"{bound.of} is {told.whole(number)}, where {asked}{far}")
    return ", and ".join(said)


def unit_of(found: Optimum, name: str) -> Told:
    """Give the unit of a number of an optimisation, which fits it at the start and in the best design."""
    trials = found.problem.trials
    shown = [trial.numbers[name] for trial in (found.problem.first, found.best)]
    return number_unit(trials.quantity(name), trials.design, shown)


def _end(found: Optimum) -> str:
    """Say so where the search did not converge."""
    if found.ending.converged:
        return ""
    return f"It was not searched to the end ({found.ending.message.rstrip('.')}): more --steps may find better."


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


def _cost(found: Optimum) -> str:
    run, count = sum(trial.seconds for trial in found.history), len(found.history)
    said = found.ending.message.rstrip(".")
    cost = f"{count} trials of {run:.0f} s in all; {found.seconds:.0f} s in this run. The search ended with: {said}."
    why = found.problem.why_differences
    return f"{cost} Derivatives are differences of trials, as {why}." if why else cost
