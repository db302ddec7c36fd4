"""A spread for people: the yield first, numbers with their quantiles, what makes them scatter, and pictures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from fenics_mech._constants import ROUNDING
from fenics_mech.errors import percent
from fenics_mech.studies.design.problem import bounds_of
from fenics_mech.studies.design.spread import statistics
from fenics_mech.views.figures import COLOURS, angle_axis, curve, empty_figure, finish, save_all
from fenics_mech.views.study_units import Told, cost_of, failures_of, number_unit
from fenics_mech.views.tables import table_of

if TYPE_CHECKING:
    from fenics_mech.studies.design.spread import Spread

UNLIKE = 0.2  # difference of the linear estimate from the deviation of the samples, relative, that is told
FEW = 0.1  # half the width of a 95 % interval, from which samples are too few for indices
BANDS = ((0.05, 0.95, 0.2), (0.25, 0.75, 0.35))  # quantiles, and how dense the band is
MOST_ROWS = 6  # numbers in a picture


def spread_summary(found: Spread) -> Group:
    """Tell how the numbers of a result scatter."""
    parts: list[RenderableType] = [Text(headline(found), style="bold")]
    parts += [_numbers(found), _shares(found)] if found.names else []
    cost = cost_of([*found.samples, *found.explorer.history], found.seconds)
    return Group(*parts, *map(Text, (*_notes(found), cost)))


def headline(found: Spread) -> str:
    """Say how many of the samples keep all limits, or how much the first number scatters."""
    if found.passed and found.samples:
        share, low, high = found.kept()
        interval = f"95 % interval: {percent(low, 3)} to {percent(high, 3)}"
        return f"{percent(share, 3)} of the samples keep all limits ({interval})."
    if not found.names:
        return f"The scatter of {len(found.curves)} curve{'s' * (len(found.curves) > 1)} is drawn."
    name = found.names[0]
    nominal, _, deviation, linear, *_ = statistics(found, name)
    size = linear if np.isnan(deviation) else deviation
    return f"{name} scatters with a standard deviation of {percent(size / (abs(nominal) or 1.0))} of its nominal value."


def unit_of(found: Spread, name: str) -> Told:
    """Give the unit of a number of a spread, which fits it at the means."""
    shown = found.explorer.first.numbers[name]
    return number_unit(found.explorer.trials.quantity(name), found.scattered.design, shown)


def _numbers(found: Spread) -> Table:
    table = table_of("Numbers of the result", "number", "nominal", "deviation", "linear", "5 %", "95 %", "unit")
    for name in found.names:
        told = unit_of(found, name)
        nominal, _, deviation, linear, low, _, high = statistics(found, name)
        cells = [told.text(value, 4) for value in (nominal, deviation, linear, low, high)]
        table.add_row(escape(name), *cells, told.unit)
    return table


def _shares(found: Spread) -> Table:
    variables = [variable.name for variable in found.scattered.design.variables]
    table = table_of("Shares of the variance", "number", "estimate", *map(escape, variables))
    for name in found.names:
        rows = {"linear": ["-" if np.isnan(share) else f"{share:.2f}" for share in found.linear_shares(name)]}
        if (chaos := found.told_by_polynomials(name)) is not None:
            rows["polynomials, alone"] = [f"{share:.2f}" for share in chaos.first]
            rows["with others"] = [f"{share:.2f}" for share in chaos.total]
        if (known := found.indices.get(name)) is not None:
            kinds = "samples, alone", "samples, with others"
            for kind, shares, doubt in zip(kinds, (known.first, known.total), known.doubt):
                pairs = zip(shares, doubt)
                rows[kind] = ["-" if np.isnan(share) else f"{share:.2f} ± {wide:.2f}" for share, wide in pairs]
        for kind, cells in rows.items():
            table.add_row(escape(name) if kind == "linear" else "", kind, *cells)
    return table


def _notes(found: Spread) -> list[str]:
    """Say which limits are broken, where the linear estimate misleads, what failed, and where samples are too few."""
    said = []
    if len(found.passed) > 1 and found.samples:
        for one, good in found.passed.items():
            limit = f"{one.of} {one.words} {unit_of(found, one.of).whole(one.limit)}"
            said.append(f"{percent(float(good.mean()), 3)} keep {limit}.")
    for name in found.names if len(found.independent) > 1 else ():
        nominal, _, deviation, linear, *_ = statistics(found, name)
        scatters = deviation > ROUNDING * abs(nominal)
        if scatters and abs(linear - deviation) > UNLIKE * deviation:
            part = f"{linear / deviation:.2f}"
            said.append(f"{name} is not linear in what scatters: the linear estimate is {part} of it.")
    if rough := [name for name in found.chaos if found.told_by_polynomials(name) is None]:
        left = percent(found.chaos[rough[0]].left)
        said.append(f"Polynomials leave {left} of the variance of {rough[0]}: take more samples.")
    unknown = {
        variable.name
        for name in found.names
        for variable, part in zip(found.scattered.design.variables, found.contributions[name])
        if np.isnan(part)
    }
    if unknown:
        said.append(f"Derivatives by {', '.join(sorted(unknown))} are not known: the trials on both sides failed.")
    if any(one.doubt.max() > FEW for one in found.indices.values()):
        said.append("Some indices are uncertain by more than 0.1: take more samples.")
    if kinds := failures_of(found.samples):
        said.append(f"Samples that failed, and keep no limit: {kinds}.")
    return said


def plot_spread(found: Spread, folder: str | Path) -> list[Path]:
    """Make the plots of a spread as PNG files in a folder."""
    figures = {}
    if found.names and found.samples:
        figures["distributions"] = distributions_figure(found)
    if found.samples:
        figures |= {f"band_{k}": band_figure(found, k - 1) for k in range(1, len(found.curves) + 1)}
    if found.names:
        figures["shares"] = shares_figure(found)
    return save_all(figures, folder)


def distributions_figure(found: Spread) -> Figure:
    """Draw how often each number has which value, with its quantiles and limits."""
    names = found.names[:MOST_ROWS]
    figure, rows = empty_figure(rows=len(names), height=0.6 + 2.3 * len(names), shared=False)
    for axes, name in zip(rows, names):
        told = unit_of(found, name)
        values = found.data["result"].sel(name=name).dropna("sample").to_numpy() / told.size
        axes.hist(values, bins="auto", color=COLOURS[5], edgecolor="white", lw=0.4)
        for share in np.quantile(values, (0.05, 0.95)) if len(values) else ():
            axes.axvline(share, color=COLOURS[0], ls="--", lw=1.1, label="5 % and 95 %")
        axes.axvline(found.explorer.first.numbers[name] / told.size, color="black", lw=1.2, label="at the means")
        for bound in bounds_of(found.scattered.design.study):
            if bound.of == name:
                axes.axvline(bound.limit / told.size, color=COLOURS[1], lw=1.6, label="limit")
        handles = dict(zip(*reversed(axes.get_legend_handles_labels())))
        axes.legend(handles.values(), handles.keys(), loc="best", fontsize=8)
        axes.set_xlabel(told.label(name))
        axes.set_ylabel("samples")
    return figure


def band_figure(found: Spread, which: int) -> Figure:
    """Draw the bands in which a curve lies in half and in 90 % of the samples."""
    one = found.curves[which]
    at_means, theta = one.values(found.explorer.first.numbers), np.array(one.angles)
    told = number_unit(one, found.scattered.design, at_means)
    values = found.data["curve"].isel(of=which).dropna("sample", how="all").to_numpy() / told.size
    figure, (axes,) = empty_figure()
    for low, high, dense in BANDS:
        ends = [curve(theta, row) for row in np.quantile(values, (low, high), axis=0)]
        said = f"{100 * (high - low):.0f} % of the samples at each angle"
        axes.fill_between(ends[0][0], ends[0][1], ends[1][1], color=COLOURS[0], alpha=dense, lw=0, label=said)
    axes.plot(*curve(theta, at_means / told.size), color="black", label="at the means")
    angle_axis(axes)
    finish(axes, "Scatter of a curve", told.label(one.text), columns=3)
    return figure


def shares_figure(found: Spread) -> Figure:
    """Draw which share of each number's variance comes from which variable."""
    names, variables = found.names[:MOST_ROWS], found.scattered.design.variables
    figure, rows = empty_figure(rows=len(names), height=0.9 + len(names) * (0.7 + 0.32 * len(variables)))
    for axes, name in zip(rows, names):
        at, known = np.arange(len(variables))[::-1], found.indices.get(name)
        linear, shares = found.linear_shares(name), known or found.told_by_polynomials(name)
        if shares is not None:
            doubt = (None, None) if known is None else known.doubt
            axes.barh(at + 0.2, shares.first, 0.36, color=COLOURS[0], label="alone", xerr=doubt[0])
            axes.barh(at - 0.2, shares.total, 0.36, color=COLOURS[5], label="with others", xerr=doubt[1])
            axes.plot(linear, at, "|", color="black", ms=14, label="linear estimate")
        else:
            axes.barh(at, linear, 0.6, color=COLOURS[0])
        axes.set_yticks(at, [variable.name for variable in variables])
        finish(axes, name, "")
    linear_alone = not found.indices and not any(found.told_by_polynomials(name) for name in names)
    rows[-1].set_xlabel("share of the variance, by the linear estimate" if linear_alone else "share of the variance")
    rows[-1].set_xlim(left=0)
    return figure
