"""What accuracy costs, as figure, table and advice."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from fenics_mech._arrays import Array, Index
from fenics_mech.errors import percent
from fenics_mech.views.figures import COLOURS, panels_of, save
from fenics_mech.views.tables import number, table_of

if TYPE_CHECKING:
    from benchmarks.cost import Cost

LEVELS = (0.1, 0.01, 1e-3, 1e-4)  # of error, for the advice
LINES, MARKS = ("-", "--", ":", "-."), ("o", "s", "^", "D", "v", "P", "X", "*", "h")
WIDTH, COST_HEIGHT = 11.0, 5.4  # inches
LARGEST, SMALLEST = 3.0, 3e-5  # errors that are drawn; smaller ones stand on the lower edge
NAMED = {"elements": "elements", "sub_intervals": "sub-intervals", "modes": "modes", "stages": "points",
         "harmonics": "harmonics", "cycles": "cycles", "tolerance": "tolerance"}  # fmt: skip


def front(seconds: Array, error: Array) -> Index:
    """Numbers of the Pareto-optimal runs, the fastest first; NaN is no run."""
    order = [i for i in np.lexsort((error, seconds)) if np.isfinite(seconds[i]) and np.isfinite(error[i])]
    kept: list[int] = []
    for i in order:
        if not kept or error[i] < error[kept[-1]]:
            kept.append(int(i))
    return np.array(kept, dtype=np.int64)


def write_cost(cost: Cost, folder: Path, name: str) -> list[Path]:
    """Write the table as CSV and NetCDF, and the figure, each whole or not at all.

    Raises
    ------
    ResultError
        When a file cannot be written.
    """
    return [
        cost.to_csv(folder / f"{name}.csv"),
        cost.save(folder / f"{name}.nc"),
        save(cost_figure(cost), folder / f"{name}.png"),
    ]


def cost_figure(cost: Cost) -> Figure:
    """Draw error over time: relative to the run's own converged solution on the left, to another one on the right."""
    data, of_peers = cost.data, "meshes" not in cost.data.attrs
    where = "_mid_span" if of_peers else ""
    other = "the other program" if of_peers else str(data.attrs["equation"])
    panels = {
        f"error{where}": "Relative to the program's own converged solution"
        if of_peers
        else "Relative to the converged solution of the same equation",
        f"error_all{where}": f"Relative to that of {other}",
    }
    return _figure(
        data, panels, f"What accuracy costs: {data.attrs['title']}{', beside other programs' if of_peers else ''}"
    )


def _figure(data: xr.Dataset, panels: dict[str, str], title: str) -> Figure:
    """Draw error over time in panels beside each other, by variable and title."""
    with panels_of(1, len(panels), (WIDTH, COST_HEIGHT), title) as (figure, ((*all_axes,),)):
        for axes, (variable, name) in zip(all_axes, panels.items()):
            _draw(axes, data, variable)
            axes.set_title(name, fontsize=10)
            axes.set_xlabel("processor time (s)")
        all_axes[0].set_ylabel("largest error of a strain curve / largest strain")
    return figure


def _draw(axes: Axes, data: xr.Dataset, variable: str) -> None:
    """Draw every run, a line through the best of each method, and the front of all."""
    seconds, error = data["seconds"].to_numpy(), data[variable].to_numpy()
    error = np.where(error < LARGEST, np.maximum(error, SMALLEST), np.nan)
    if variable == "error_all":  # the others mix equations
        best = front(seconds, error)
        wide: dict[str, Any] = {"color": "#cccccc", "linewidth": 7, "solid_capstyle": "round", "linestyle": "-"}
        axes.plot(seconds[best], error[best], zorder=0.5, label="Pareto front", **wide)
    for label, runs, look in _methods(data):
        if not np.isfinite(error[runs]).any():
            continue
        axes.plot(seconds[runs], error[runs], alpha=0.4, markersize=4, **look | {"linestyle": "none"})
        kept = runs[front(seconds[runs], error[runs])]
        axes.plot(seconds[kept], error[kept], label=label, markersize=5, linewidth=1.4, clip_on=False, **look)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_locator(NullLocator())
    for level in LEVELS[1:3]:
        axes.axhline(level, color="#888888", linewidth=0.7, zorder=0.4)
        axes.annotate(f" {100 * level:g} %", (0, level), xycoords=("axes fraction", "data"), fontsize=8, va="bottom",
                      color="#555555")  # fmt: skip
    axes.set_ylim(SMALLEST, LARGEST)


def _methods(data: xr.Dataset) -> Iterator[tuple[str, Index, dict[str, Any]]]:
    """Give each method with each equation: its label, its runs and how it is drawn."""
    method, equation = (data[name].to_numpy().astype(str) for name in ("method", "equation"))
    methods, equations = list(dict.fromkeys(method)), list(dict.fromkeys(equation))
    style = {name: i for i, name in enumerate(reversed(equations))}
    for pair in dict.fromkeys(zip(method, equation)):
        runs = np.flatnonzero((method == pair[0]) & (equation == pair[1]))
        i = methods.index(pair[0])
        colour = "black" if pair[0].startswith("fenics_mech") else COLOURS[i % len(COLOURS)]  # among its peers
        look = {"color": colour, "marker": MARKS[i % len(MARKS)]}
        line = LINES[style[pair[1]] % len(LINES)]
        label = pair[0] if pair[0] == pair[1] else f"{pair[0]}: {pair[1]}"
        yield label, runs, look | {"linestyle": line}


def cost_summary(cost: Cost) -> Group:
    """Tell what each accuracy costs, what failed, and how well the converged solutions are known."""
    data, of_peers = cost.data, "meshes" not in cost.data.attrs
    parts: list[RenderableType] = [Text(data.attrs["title"], style="bold")]
    parts.append(levels_table(data, "error_mid_span" if of_peers else "error", _known(cost, of_peers)))
    if of_peers:
        parts += map(Text, (*beside_exudyn(data, _known(cost, of_peers)), *_between(data)))
    else:
        least = _known(cost, of_peers).get(data.attrs["equation"], 0.0)
        parts += [front_table(data, "error_all", least), *map(Text, advice(data, "error_all", least))]
    parts += map(Text, (*_references(cost), *_about(data), *_failures(data)))
    return Group(*parts)


def levels_table(data: xr.Dataset, variable: str, known: Mapping[str, float]) -> Table:
    """Tabulate the shortest time (ms) in which each method comes within an accuracy.

    No error is reported to be smaller than that of the converged solutions, `known` by equation.
    """
    title = "Shortest time (ms) to reach an error relative to the converged solution of the same equation"
    table = table_of(title, "method", *map(percent, LEVELS), "smallest\nerror")
    named = data["equation"].to_numpy().astype(str)
    for equation in dict.fromkeys(named):
        table.add_section()
        of_it = data.isel(run=np.flatnonzero(named == equation))
        methods = of_it["method"].to_numpy().astype(str)
        if set(methods) != {equation}:
            table.add_row(Text(equation, style="bold"))
        for method in dict.fromkeys(methods):
            seconds, error = (of_it[name].to_numpy()[methods == method] for name in ("seconds", variable))
            least = known.get(equation, 0.0)
            cells = [seconds[np.maximum(error, least) <= level].min(initial=np.inf) for level in LEVELS]
            times = (number(1e3 * cell) if np.isfinite(cell) else "" for cell in cells)
            best = _as_known(float(np.nanmin(error)), least) if np.isfinite(error).any() else "none"
            table.add_row(escape(method), *times, best)
    return table


def beside_exudyn(data: xr.Dataset, known: Mapping[str, float]) -> Iterator[str]:
    """Say how long Exudyn takes beside an analysis by this program, and beside its solver alone, for 1 % and 0.1 %."""
    method, equation = (data[name].to_numpy().astype(str) for name in ("method", "equation"))
    for level in LEVELS[1:3]:
        theirs = method == "Exudyn"
        ours = np.char.startswith(method, "fenics_mech") & np.isin(equation, equation[theirs])
        good = np.maximum(data["error_mid_span"].to_numpy(), [known.get(name, 0.0) for name in equation]) <= level
        if (theirs & good).any() and (ours & good).any():
            least = {
                name: [1e3 * float(np.nanmin(data[name].to_numpy()[runs & good])) for runs in (theirs, ours)]
                for name in ("seconds", "solver_seconds")
            }
            (exudyn, whole), (integration, solver) = least.values()
            yield (
                f"Error of {percent(level)}: Exudyn takes {number(exudyn)} ms, {exudyn / whole:.2g} times as long "
                f"as an analysis by fenics_mech ({number(whole)} ms). Its integration takes "
                f"{integration / solver:.2g} times as long as the solver of fenics_mech ({number(solver)} ms)."
            )


def _between(data: xr.Dataset) -> Iterator[str]:
    """Say how far the converged solutions of the programs are from each other."""
    for equation, difference in json.loads(data.attrs["between"]).items():
        yield f"Converged solutions of {equation}: fenics_mech's is {percent(difference)} from the other program's."


def _known(cost: Cost, of_peers: bool) -> dict[str, float]:
    """Error of the converged solutions of each equation, of two the larger."""
    place, known = "mid_span" if of_peers else "everywhere", dict[str, float]()
    for name, found in cost.references.items():
        if not isinstance(found, str):
            equation = name.rpartition(", ")[0] if of_peers else name
            known[equation] = max(found[place], known.get(equation, 0.0))
    return known


def _as_known(error: float, least: float) -> str:
    """Give an error in percent, or that it is below the error of the converged solution."""
    return percent(error) if error > least else f"< {percent(least)}"


def front_table(data: xr.Dataset, variable: str, least: float) -> Table:
    """Tabulate the Pareto-optimal runs, as far as the converged solution is known."""
    columns = "run", "time (ms)", "error", "estimated error\n/ error of its own equation"
    table = table_of("Pareto-optimal runs: none is both faster and more accurate", *columns)
    for i in front(data["seconds"].to_numpy(), np.maximum(data[variable].to_numpy(), least)):
        run = data.isel(run=i)
        ratio = float(run["estimate_ratio"]) if "estimate_ratio" in data else np.nan
        known = number(ratio) if np.isfinite(ratio) else ""
        error = _as_known(float(run[variable]), least)
        table.add_row(escape(said(run)), number(1e3 * float(run["seconds"])), error, known)
    return table


def advice(data: xr.Dataset, variable: str, least: float = 0.0) -> list[str]:
    """Say for each level of accuracy which run reaches it first; no error counts as less than `least`."""
    seconds, error = data["seconds"].to_numpy(), np.maximum(data[variable].to_numpy(), least)
    lines = []
    for level in LEVELS:
        good = np.flatnonzero(error <= level)
        if len(good):
            i = good[np.argmin(seconds[good])]
            lines.append(f"Error of {percent(level)}: {number(1e3 * seconds[i])} ms with {said(data.isel(run=i))}")
            continue
        if np.isfinite(error).any():
            i = min(np.flatnonzero(error == np.nanmin(error)), key=lambda run: seconds[run])
            best = f"{_as_known(float(error[i]), least)} in {number(1e3 * seconds[i])} ms"
            lines.append(f"Error of {percent(level)}: not reached; the best is {best} with {said(data.isel(run=i))}")
        break
    return lines


def said(run: xr.Dataset) -> str:
    """Name a run: its solver, equation and settings."""
    method, equation = str(run["method"].item()), str(run["equation"].item())
    words = [method if method == equation else f"{method}, {equation}"]
    for name, word in NAMED.items():
        value = float(run[name]) if name in run else np.nan
        if np.isfinite(value):
            plain = f"{value:g} {word.removesuffix('s') if value == 1 else word}"
            words.append(f"all {word}" if name == "modes" and value == 0 else plain)
    return ", ".join(words)


def _references(cost: Cost) -> Iterator[str]:
    ways: dict[str, list[str]] = {}
    for name, found in cost.references.items():
        if isinstance(found, str):
            yield f"No converged solution of {name}: {found}"
        else:
            ways.setdefault(found["how"], []).append(
                f"{name} {percent(found['everywhere'])} ({percent(found['mid_span'])} at mid-span)"
            )
    for how, names in ways.items():
        yield f"Converged solutions: {how}. Their difference from an independent check: {'; '.join(names)}."


def _about(data: xr.Dataset) -> Iterator[str]:
    attributes = data.attrs
    yield f"{attributes['machine']}; threads: {attributes['threads']}; {attributes['versions']}."
    if "bare_seconds" in attributes:
        yield (
            f"The times leave out imports ({attributes['import_seconds']:.2g} s) and compiling the forms, or reading "
            f"compiled ones ({attributes['compile_seconds']:.2g} s)."
        )
        whole, bare = attributes["analyse_seconds"], attributes["bare_seconds"]
        yield (
            f"The scene as stated takes {number(1e3 * whole)} ms, of which PETSc, SLEPc and LAPACK take "
            f"{number(1e3 * bare)} ms: the rest adds {100 * (whole / bare - 1):.0f} %."
        )


def _failures(data: xr.Dataset) -> Iterator[str]:
    """Say which runs gave no answer, and why the first of each method did not."""
    failed = np.flatnonzero(data["failure"].to_numpy().astype(str) != "")
    if len(failed):
        yield f"{len(failed)} of {data.sizes['run']} runs failed:"
    by_kind: dict[tuple[str, str], list[int]] = {}
    for i in failed:
        by_kind.setdefault((str(data["method"][i].item()), str(data["failure"][i].item())), []).append(int(i))
    for (method, _), runs in by_kind.items():
        yield f"  {method} ({len(runs)} of them): {data['message'][runs[0]].item()}"
