"""Comparisons for people: a table of differences, curves above one another, and a file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from rich.console import Group
from rich.markup import escape
from rich.table import Table

from fenics_mech._constants import TINY
from fenics_mech._files import write_whole
from fenics_mech.errors import ViewError, percent
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.studies.compare import Curves, Quantity
from fenics_mech.views.figures import COLOURS, curve, finish, new_figure, save
from fenics_mech.views.plot_marks import MEASURED
from fenics_mech.views.tables import number, table_of

KINDS = {"deflection": "length", "joint_force": "force", "shaking_force": "force"}  # of units, by kind of quantity
POINTS: dict[str, Any] = MEASURED | {"color": "#000000"}
MOST_PANELS = 8  # in one figure
MEANING = (
    "strains: at mid-span, + side, unless a place is named; rms: root mean square of the difference, over the "
    "reference's peak; shift: angle by which the curve is later than the reference"
)


def comparison_table(sources: Sequence[Curves], data: xr.Dataset, units: AnswerUnits) -> Group:
    """Tabulate what `compare` found, one table for each source beside the reference, and how strains vibrate.

    Parameters
    ----------
    sources
        The reference and the others.
    data
        From `studies.compare.compare`.
    units
        Units of the numbers.
    """
    tables, kinds = [], {quantity.label: quantity.kind for source in sources for quantity in source.known}
    for label in data["other"].to_numpy():
        columns = "peak of\nreference", "peak", "largest\ndifference", "rms", "shift"
        table = table_of(f"{label} against {data.attrs['reference']}", "quantity", *columns)
        _fill(table, data.sel(other=label), kinds, units)
        tables.append(table)
    tables[-1].caption, tables[-1].caption_justify = f"{MEANING}\n", "left"
    vibrating = [source for source in sources if source.vibration]
    if len(vibrating) > 1:
        table = table_of(
            "Vibration of the strain at mid-span, or at a gauge (Hz)", "member", *(source.label for source in vibrating)
        )
        for member in vibrating[0].vibration:
            rates = [source.vibration.get(member, np.nan) for source in vibrating]
            table.add_row(escape(member), *("-" if np.isnan(rate) else number(rate) for rate in rates))
        tables.append(table)
    return Group(*tables)


def _scale(kind: str, unit: str, units: AnswerUnits) -> tuple[float, str]:
    """Size of a unit in SI and its name, for a kind of quantity with a unit in SI."""
    of = KINDS.get(kind, kind)
    if kind == "input_torque":
        of = "force" if unit == "N" else "moment"
    return units.size(of), units.label(of)


def _fill(table: Table, data: xr.Dataset, kinds: dict[str, str], units: AnswerUnits) -> None:
    """Fill in a line for each quantity that both have."""
    for i, quantity in enumerate(data["quantity"].to_numpy()):
        row = {name: float(data[name][i]) for name in data}
        if np.isnan(row["peak"]):
            continue
        size, unit = _scale(kinds[str(quantity)], str(data["unit"].to_numpy()[i]), units)
        sizes = [number(row[name] / size) for name in ("peak_reference", "peak", "difference")]
        measure = float(max(abs(row["peak_reference"]), TINY))
        shift = f"{np.degrees(row['shift']):.2f}\N{DEGREE SIGN}"
        table.add_row(escape(f"{quantity} ({unit})"), *sizes, percent(row["rms"] / measure), shift)


def write_comparison(data: xr.Dataset, path: Path) -> Path:
    """Write the comparison as a CSV, one quantity and source a line, in SI.

    Raises
    ------
    ResultError
        When the file cannot be written.
    """
    table = data.to_dataframe().dropna(subset=["peak"]).reset_index()
    write_whole(path, lambda temporary: table.to_csv(temporary, index=False))
    return path


def plot_comparison(sources: Sequence[Curves], data: xr.Dataset, folder: Path, units: AnswerUnits) -> list[Path]:
    """Draw the curves of all sources above one another, a figure for each kind of quantity and a panel for each part.

    Of many parts those are drawn that differ most.

    Parameters
    ----------
    sources
        The reference and the others.
    data
        From `studies.compare.compare`.
    folder
        Where to write.
    units
        Units of the curves.

    Returns
    -------
    list of Path
        The files, "compare_strain.png" and so on.

    Raises
    ------
    ViewError, ResultError
        When a file cannot be written.
    """
    asked = dict.fromkeys(quantity for source in sources for quantity in source.known)
    order = {str(label): i for i, label in enumerate(data["quantity"].to_numpy())}
    rms = np.nan_to_num(data["rms"].to_numpy()).max(axis=0)
    drawn = [q for q in asked if q.label in order and any(q in other.known for other in sources[1:])]
    if not drawn:
        raise ViewError("these sources have no quantity in common: there is nothing to draw")
    paths = []
    for kind in dict.fromkeys(quantity.kind for quantity in drawn):
        of_kind = sorted((q for q in drawn if q.kind == kind), key=lambda q: -rms[order[q.label]])[:MOST_PANELS]
        of_kind.sort(key=lambda q: order[q.label])
        paths.append(_figure(sources, of_kind, folder / f"compare_{kind}.png", units))
    return paths


def _figure(sources: Sequence[Curves], quantities: Sequence[Quantity], path: Path, units: AnswerUnits) -> Path:
    """Draw one panel a quantity."""
    figure, panels = new_figure(rows=len(quantities), height=1.0 + 2.6 * len(quantities))
    for axes, quantity in zip(panels, quantities):
        known = next(source for source in sources if quantity in source.known)
        size, unit = _scale(quantity.kind, known.unit(quantity), units)
        for i, source in enumerate(sources):
            if quantity not in source.known and len(source.known) == 1:  # measured elsewhere
                continue
            theta, values = source.curve(quantity)
            if len(source.known) == 1:
                axes.plot(np.degrees(theta) % 360, values / size, label=source.label, **POINTS)
            else:
                colour = COLOURS[i % len(COLOURS)]
                axes.plot(*curve(theta, values / size), label=source.label, color=colour, linestyle="-")
        finish(axes, quantity.title, f"{quantity.kind.replace('_', ' ')} ({unit})", columns=3)
    return save(figure, path)
