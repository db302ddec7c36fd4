"""Pictures and words of a branch: amplitudes through folds, stable motions solid and unstable ones dashed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from fenics_mech._arrays import Array
from fenics_mech.views.figures import COLOURS, empty_figure, finish, save_all, with_unit
from fenics_mech.views.prefixes import labelled
from fenics_mech.views.sweep_data import units_of
from fenics_mech.views.tables import number, table_of

if TYPE_CHECKING:
    from fenics_mech.studies.follow import Branch

STABLE, UNSTABLE = "-", (0, (4, 2))


def plot_branch(branch: Branch, folder: str | Path) -> list[Path]:
    """Make the plots of a branch as PNG files in `folder`."""
    figures = {"response": branch_figure(branch)}
    if "multiplier" in branch.data:
        figures["stability"] = multiplier_figure(branch)
    return save_all(figures, folder, "branch_")


def branch_figure(branch: Branch) -> Figure:
    """Peak strain of every member, and below it the peak deflection, along the branch."""
    figure, panels = empty_figure(rows=2, height=6.8)
    data, units = branch.data, units_of(branch.data)
    kinds = (
        ("peak_strain", 1 / units.size("strain"), "Largest strain", labelled(units, "strain")),
        ("peak_deflection", 1 / units.size("length"), "Largest deflection", labelled(units, "length", "deflection")),
    )
    for axes, (name, scale, title, label) in zip(panels, kinds):
        for i, member in enumerate(data["member"].to_numpy()):
            heights = scale * data[name].sel(member=member).to_numpy()
            _draw(axes, branch, heights, COLOURS[i % len(COLOURS)], str(member))
        axes.set_ylim(bottom=0)
        axes.set_xlim(branch.values.min(), branch.values.max())
        finish(axes, f"{title} in a cycle. Dashed: unstable; circles: folds", label)
    panels[-1].set_xlabel(with_unit(branch.data, branch.path))
    return figure


def multiplier_figure(branch: Branch) -> Figure:
    """Magnitude of the largest Floquet multiplier along the branch."""
    figure, (axes,) = empty_figure()
    largest = np.hypot(*np.moveaxis(branch.data["multiplier"].transpose(..., "part").to_numpy()[:, 0], -1, 0))
    _draw(axes, branch, largest, COLOURS[0], "")
    axes.axhline(1, color="#777777", linewidth=0.8, linestyle="-", zorder=1.5)
    axes.set_xlim(branch.values.min(), branch.values.max())
    finish(axes, "Stability: disturbances grow above 1. Circles: folds", "largest Floquet multiplier")
    axes.set_xlabel(with_unit(branch.data, branch.path))
    return figure


def branch_summary(branch: Branch) -> Group:
    """Tell where the branch folds, to which motions the machine may jump there, and where else stability changes."""
    data = branch.data
    low, high = number(float(branch.values.min())), number(float(branch.values.max()))
    shares, unit = (
        f"{int(data['stable'].sum())} of {data.sizes['point']} points are stable",
        data[branch.path].attrs["units"],
    )
    parts: list[RenderableType] = [Text(data.attrs["title"], style="bold")]
    parts.append(Text(f"{branch.path} from {low} to {high} {unit}: {shares}"))
    if (data["fold"] == 1).any():
        parts.append(_folds(branch))
    for start, end, kind in branch.changes():
        if kind != "fold":
            low, high = (f"{value:.6g}" for value in sorted((start, end)))
            parts.append(Text(f"Stability changes between {low} and {high} {unit} ({kind})"))
    if not branch.whole:
        parts.append(Text(data.attrs["ended"], style="bold red"))
    return Group(*parts)


def _folds(branch: Branch) -> Table:
    """Tabulate the folds, with the largest strain there and that of other stable motions at the same value."""
    units = units_of(branch.data)
    peak = branch.data["peak_strain"].max("member").to_numpy() / units.size("strain")
    points = np.arange(len(peak))
    strain = labelled(units, "strain", "largest strain")
    table = table_of("Folds", with_unit(branch.data, branch.path), strain, "of other stable\nmotions there")
    for fold in np.flatnonzero(branch.data["fold"].to_numpy() == 1):
        value = float(branch.values[fold])
        others = [place for place, stable in branch.motions(value) if stable and abs(place - fold) > 1]
        jumps = ", ".join(number(float(np.interp(place, points, peak))) for place in others)
        table.add_row(f"{value:.6g}", number(peak[fold]), jumps or "none")
    return table


def _draw(axes: Axes, branch: Branch, heights: Array, colour: str, label: str) -> None:
    """Draw a curve along the branch: solid between stable points, dashed elsewhere, with circles at its folds."""
    stable, fold = (branch.data[name].to_numpy() == 1 for name in ("stable", "fold"))
    solid = (stable | fold)[1:] & (stable | fold)[:-1] & (stable[1:] | stable[:-1])
    parts = np.split(np.arange(len(solid)), np.flatnonzero(np.diff(solid)) + 1)
    for part in parts if len(solid) else []:  # a branch of one point has no line
        run = np.append(part, part[-1] + 1)
        axes.plot(branch.values[run], heights[run], color=colour, linestyle=STABLE if solid[part[0]] else UNSTABLE)
    axes.plot([], [], color=colour, linestyle=STABLE, label=label)
    look: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 5, "markerfacecolor": "white"}
    axes.plot(branch.values[fold], heights[fold], color=colour, zorder=3, **look)
