"""Pictures of a spread: distributions of numbers, bands of curves, and shares of the variance."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fenics_mech.studies.design.problem import bounds_of
from fenics_mech.views.figures import COLOURS, angle_axis, curve, empty_figure, finish, save_all
from fenics_mech.views.spread_summary import unit_of
from fenics_mech.views.study_units import number_unit

if TYPE_CHECKING:
    from fenics_mech.studies.design.spread import Spread

BANDS = ((0.05, 0.95, 0.2), (0.25, 0.75, 0.35))  # quantiles, and how dense the band is
MOST_ROWS = 6  # numbers in a picture


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
        _draw_distribution(axes, found, name)
    return figure


def _draw_distribution(axes: Axes, found: Spread, name: str) -> None:
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
