"""How time and memory of a run grow, as figure and tables."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from benchmarks.scaling import cost_per_position
from fenics_mech.views.figures import COLOURS, panels_of, save
from fenics_mech.views.tables import number, table_of

if TYPE_CHECKING:
    from benchmarks.scaling import Scaling

SERIES = {"elements": "elements per link", "links": "moving links", "positions": "positions in a cycle"}
PANELS = {"seconds": "processor time (s)", "memory": "peak memory (MB)"}
WIDTH, SCALING_HEIGHT = 11.0, 6.2  # inches


def write_scaling(scaling: Scaling, folder: Path) -> list[Path]:
    """Write the table as CSV and NetCDF, and the figure, each whole or not at all.

    Raises
    ------
    ResultError
        When a file cannot be written.
    """
    figure = save(scaling_figure(scaling), folder / "scaling.png")
    return [scaling.to_csv(folder / "scaling.csv"), scaling.save(folder / "scaling.nc"), figure]


def scaling_figure(scaling: Scaling) -> Figure:
    """Draw time and memory against elements, links and positions."""
    title = "Time and memory of a run. Chains of four-bars: 3 links, 3 elements a link, 120 positions unless varied"
    with panels_of(len(PANELS), len(SERIES), (WIDTH, SCALING_HEIGHT), title) as (figure, panels):
        for row, (variable, label) in zip(panels, PANELS.items()):
            row[0].set_ylabel(label)
            for axes, series in zip(row, SERIES):
                _draw(axes, scaling.data, series, variable)
        for axes, label in zip(panels[-1], SERIES.values()):
            axes.set_xlabel(label)
    return figure


def _draw(axes: Axes, data: xr.Dataset, series: str, variable: str) -> None:
    for label, look, runs in _lines(data, series):
        axes.plot(runs[series], runs[variable], label=label, markersize=5, linewidth=1.4, **look)
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1, 3)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,g}"))
        axis.set_minor_locator(NullLocator())


def _lines(data: xr.Dataset, series: str) -> Iterator[tuple[str, dict[str, Any], xr.Dataset]]:
    """Give each line of a series: its label, how it is drawn, its runs."""
    table = data.isel(run=np.flatnonzero((data["series"] == series).to_numpy()))
    solver = table["solver"].to_numpy().astype(str)
    for colour, name in zip(COLOURS, dict.fromkeys(solver)):
        look = {"color": colour, "linestyle": "-", "marker": "o"}
        yield name, look, table.isel(run=np.flatnonzero(solver == name))


def scaling_summary(scaling: Scaling) -> Group:
    """Tell time and memory of each size, the exponents with which they grow, and what a position costs."""
    data = scaling.data
    parts: list[RenderableType] = [_series_table(data, series) for series in SERIES]
    parts.append(_per_position_table(data))
    attributes = data.attrs
    parts.append(Text(f"{attributes['machine']}; threads: {attributes['threads']}; {attributes['versions']}."))
    for message in dict.fromkeys(data["message"].to_numpy().astype(str)):
        runs = int((data["message"] == message).sum())
        parts += [Text(f"{runs} runs failed: {message}")] if message else []
    return Group(*parts)


def _series_table(data: xr.Dataset, series: str) -> Table:
    values = np.unique(data[series].to_numpy()[(data["series"] == series).to_numpy()])
    title = f"Time (s) and peak memory (MB) against {SERIES[series]}; exponent of growth at the end"
    table = table_of(title, "", *(f"{value:,}" for value in values), "exponent")
    for label, _, runs in _lines(data, series):
        for variable in PANELS:
            found = dict(zip(runs[series].to_numpy(), runs[variable].to_numpy()))
            cells = [number(found[value]) if np.isfinite(found.get(value, np.nan)) else "" for value in values]
            name = f"{label} (s)" if variable == "seconds" else "  (MB)"
            table.add_row(name, *cells, f"{last_power(runs[series].to_numpy(), runs[variable].to_numpy()):.2f}")
    return table


def last_power(sizes: Any, numbers: Any) -> float:
    """Power of the size with which a number grows between its last two known values."""
    known = np.flatnonzero(np.isfinite(numbers))[-2:]
    if len(known) < 2:
        return float("nan")
    (a, b), (x, y) = sizes[known], numbers[known]
    return float(np.log(y / x) / np.log(b / a))


def _per_position_table(data: xr.Dataset) -> Table:
    table = table_of(
        "Time per position, without one-off work",
        "solver",
        "elements",
        "time (ms)",
        "relative to\nthe coarsest",
    )
    coarsest: dict[str, float] = {}
    for solver, elements, seconds in cost_per_position(data):
        first = coarsest.setdefault(solver, seconds)
        table.add_row(solver, f"{elements}", number(1e3 * seconds), f"{seconds / first:.2f}")
    return table
