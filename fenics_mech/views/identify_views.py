"""An identification for people: the variables with their confidence, the fit, and its pictures."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from fenics_mech.studies.design.result_numbers import Curve
from fenics_mech.views.figures import COLOURS, angle_axis, empty_figure, finish, save_all
from fenics_mech.views.study_units import cost_of, number_unit, variable_unit
from fenics_mech.views.tables import table_of

if TYPE_CHECKING:
    from fenics_mech.studies.design.identify import Identified

CORRELATED = 0.9  # correlation of two variables, from which it is told
UNUSUAL = 3.0  # deviations from nothing but noise, from which a fit is doubted
BAND = 2  # standard deviations of noise, that the band of the differences has on both sides
FAINT = 0.15  # opacity of that band
HEIGHTS = {"height_ratios": [3, 1]}


def identify_summary(found: Identified) -> Group:
    """Tell what measured data say of the variables."""
    parts: list[RenderableType] = [Text(headline(found), style="bold"), _variables(found)]
    parts += [Text(line) for line in (*_correlations(found), *doubts(found))]
    return Group(*parts, _fit(found), Text(cost_of(found.history, found.seconds)))


def headline(found: Identified) -> str:
    """Say which variables the data tell, and which they do not."""
    told = [name for name, known in zip(found.names, found.fit.told) if known]
    rest = [name for name in found.names if name not in told]
    if not rest:
        return f"The data tell {_listed(told)}."
    first = f"The data tell {_listed(told)}, and not" if told else "The data do not tell"
    first = f"{first} {_listed(rest)}."
    if all(len(one) == 1 for one in found.untold):
        return first
    ways = (" and ".join(f"{part:+.2f} of the range of {name}" for name, part in one.items()) for one in found.untold)
    return f"{first} These change hardly any prediction together: {'; '.join(ways)}."


def doubts(found: Identified) -> list[str]:
    """Say what speaks against the intervals: bounds, differences that are no noise, deviations that are exceeded."""
    said = []
    if not found.fit.converged:
        said.append("The search did not converge: give narrower bounds, or more --starts.")
    if bound := [name for name, there in zip(found.names, found.at_bound) if there]:
        said.append(f"{_listed(bound)} ended at a bound: widen it. The intervals do not hold there.")
    for one, part in zip(found.observations, found.parts):
        limit = UNUSUAL / math.sqrt(max(len(one.values), 1))
        if isinstance(one.of, Curve) and (follows := found.follows(part)) > limit:
            said.append(
                f"The differences of {one.text} follow one another (correlation {follows:.2f}): the model lacks "
                f"something, or the noise is not independent. The intervals are too narrow."
            )
    known = [
        (abs(found.fit.weighted[part.start]), one.text)
        for one, part in zip(found.observations, found.parts)
        if not math.isnan(one.deviation)
    ]
    most, name = max(known, key=lambda pair: pair[0], default=(0.0, ""))
    if most > UNUSUAL:
        said.append(f"{name} is {most:.1f} standard deviations off: the model does not fit.")
    return said


def _listed(names: list[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def _variables(found: Identified) -> Table:
    table = table_of("Variables", "variable", "start", "identified", "deviation", "95 % interval", "unit")
    design = found.explorer.trials.design
    for k, variable in enumerate(design.variables):
        told, known = variable_unit(variable, design.scene), bool(found.fit.told[k])
        ends = map(told.text, found.interval[k] if known else (variable.lower, variable.upper))
        interval = "not told: " * (not known) + " to ".join(ends)
        deviation = told.text(found.deviation[k], 2) if known else "-"
        values = told.text(variable.start), told.text(found.values[k])
        table.add_row(escape(variable.name), *values, deviation, interval, told.unit)
    return table


def _correlations(found: Identified) -> list[str]:
    """Name the pairs of variables that the data hardly tell from one another."""
    correlation = found.covariance / np.outer(found.deviation, found.deviation)
    return [
        f"{second} and {first} are correlated ({correlation[i, j]:.2f}): the data tell a combination better."
        for i, first in enumerate(found.names)
        for j, second in enumerate(found.names[:i])
        if abs(correlation[i, j]) > CORRELATED
    ]


def _fit(found: Identified) -> Table:
    table = table_of("Prediction and measurement", "measured", "points", "rms difference", "noise", "unit")
    for k, (one, part) in enumerate(zip(found.observations, found.parts)):
        told = number_unit(one.of, found.explorer.trials.design, one.values)
        rms = float(np.sqrt(((one.values - found.fit.predicted[part]) ** 2).mean()))
        noise = told.text(found.fit.noise[k], 3) + " (estimated)" * math.isnan(one.deviation)
        table.add_row(escape(one.text), str(len(one.values)), told.text(rms, 3), noise, told.unit)
    return table


def plot_identified(found: Identified, folder: str | Path) -> list[Path]:
    """Make the plots of an identification in a folder: one of each curve, and one of all single numbers."""
    curves = [k for k, one in enumerate(found.observations) if isinstance(one.of, Curve)]
    figures = {f"prediction_{i}": curve_figure(found, k) for i, k in enumerate(curves, 1)}
    if len(curves) < len(found.observations):
        figures["prediction_numbers"] = numbers_figure(found)
    return save_all(figures, folder)


def curve_figure(found: Identified, which: int) -> Figure:
    """Draw a measured curve, what is predicted at the start and in the end, and the difference below."""
    one, part = found.observations[which], found.parts[which]
    assert isinstance(one.of, Curve)
    angle = np.degrees(one.of.angles) % 360
    order = np.argsort(angle)
    figure, (above, below) = empty_figure(rows=2, height=5.2, grid=HEIGHTS)
    told = number_unit(one.of, found.explorer.trials.design, one.values)
    first, last, measured = (v / told.size for v in (found.first[part], found.fit.predicted[part], one.values))
    above.plot(angle, measured, ".", color="0.45", ms=4, label="measured")
    above.plot(angle[order], first[order], "--", color=COLOURS[1], lw=1.1, label="at the start")
    above.plot(angle[order], last[order], color=COLOURS[0], label="in the end")
    above.plot([], [], color=COLOURS[0], alpha=FAINT, lw=8, label=f"{BAND} deviations of the noise, below")
    finish(above, "Prediction and measurement", told.label(one.text))
    noise = float(found.fit.noise[which]) / told.size
    below.axhspan(-BAND * noise, BAND * noise, color=COLOURS[0], alpha=FAINT, lw=0)
    below.plot(angle, measured - last, ".", color="0.45", ms=4)
    below.set_ylabel(told.label("difference"))
    angle_axis(below)
    return figure


def numbers_figure(found: Identified) -> Figure:
    """Draw the differences of single numbers in units of their deviation, at the start and in the end."""
    which = [k for k, one in enumerate(found.observations) if not isinstance(one.of, Curve)]
    figure, (axes,) = empty_figure(height=1.6 + 0.35 * len(which))
    rows = np.arange(len(which))[::-1]
    points = [found.parts[k].start for k in which]
    measured, noise = found.fit.data.values[points], found.fit.noise[which]
    axes.axvspan(-BAND, BAND, color=COLOURS[0], alpha=0.15, lw=0)
    axes.plot((measured - found.first[points]) / noise, rows, "s", color=COLOURS[1], mfc="none", label="at the start")
    axes.plot((measured - found.fit.predicted[points]) / noise, rows, "o", color=COLOURS[0], label="in the end")
    axes.set_yticks(rows, [found.observations[k].text for k in which])
    axes.set_ylim(-0.6, len(which) - 0.4)
    axes.set_xlabel("measured less predicted value, in standard deviations of the measurement")
    finish(axes, "Prediction and measurement", "")
    return figure
