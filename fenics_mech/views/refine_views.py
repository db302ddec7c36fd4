"""What a refinement shows: a table of values and orders, a file, and errors over the number of elements and steps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from rich.console import Group
from rich.markup import escape
from rich.table import Table

from fenics_mech._files import write_frame
from fenics_mech.errors import percent
from fenics_mech.studies.refine import RATIO, Refinement
from fenics_mech.views.figures import empty_figure, finish, save
from fenics_mech.views.prefixes import fitted
from fenics_mech.views.tables import number, table_of

WORDS = {"elements": "elements in all", "sub_intervals": "sub-intervals"}
MEANING = (
    "order: with which the last three levels converge; extrapolated: with no step at all, by Richardson; error: of the "
    "scene's own answer, *. Where the differences do not fall, or are rounding, the largest stands in brackets"
)
LEAST = 1e-12  # error that is still drawn


def refinement_table(found: Refinement) -> Group:
    """Tabulate values, observed orders and extrapolated answers."""
    tables = [_table(found.data, str(name), found) for name in found.data["refinement"].to_numpy()]
    tables[-1].caption = MEANING
    return Group(*tables)


def _table(data: xr.Dataset, refinement: str, found: Refinement) -> Table:
    kinds = [str(name).split(" ")[0] for name in data["quantity"].to_numpy()]
    most = np.nan_to_num(abs(data["value"]).max([dim for dim in data["value"].dims if dim != "quantity"]).to_numpy())
    largest = {kind: float(max(size for one, size in zip(kinds, most) if one == kind)) for kind in kinds}
    data, units = data.sel(refinement=refinement), fitted(largest, found.scene.answer_units)
    own = 1 if refinement == "sub_intervals" else 0
    counts = [f"{int(count)}{'*' * (i == own)}" for i, count in enumerate(data["count"].to_numpy())]
    table = table_of(f"By {WORDS[refinement]}", "quantity", *counts, "order", "extra-\npolated", "error")
    for name in data["quantity"].to_numpy():
        row = data.sel(quantity=name)
        values = row["value"].to_numpy()
        if np.isnan(values).all():
            continue
        kind = str(name).split(" ")[0]
        unit = units.label(kind) if kind != "frequency" else "Hz"

        def shown(value: float, kind: str = kind) -> str:
            return "-" if np.isnan(value) else number(value if kind == "frequency" else units.number(value, kind))

        order, error = float(row["order"]), float(row["error"])
        table.add_row(
            escape(f"{name} ({unit})"),
            *map(shown, values),
            "-" if np.isnan(order) else f"{order:.1f}",
            shown(float(row["extrapolated"])),
            f"({percent(np.abs(values / values[-1] - 1).max())})" if np.isnan(error) else percent(error),
        )
    return table


def write_refinement(found: Refinement, path: Path) -> Path:
    """Write a CSV, one quantity of one refinement a line, in SI."""
    values = found.data["value"].to_dataframe()["value"].unstack("level")
    values.columns = [f"level {level}" for level in values.columns]
    table = found.data[["order", "extrapolated", "error"]].to_dataframe()
    table = values.join(table).dropna(subset=["level 1"]).reset_index()
    write_frame(path, table)
    return path


def plot_refinement(found: Refinement, folder: Path) -> list[Path]:
    """Draw the difference from the extrapolated answers over the number of elements, and of sub-intervals."""
    return [
        save(_figure(found.data.sel(refinement=name), str(name)), folder / f"refine_{name}.png")
        for name in found.data["refinement"].to_numpy()
    ]


def _figure(data: xr.Dataset, refinement: str) -> Figure:
    """Draw the errors of one refinement."""
    figure, (axes,) = empty_figure(height=4.8)
    axes.set_xscale("log", base=RATIO)
    axes.set_yscale("log")
    counts = data["count"].to_numpy()
    for name in data["quantity"].to_numpy():
        row = data.sel(quantity=name)
        off = np.abs(row["value"].to_numpy() / float(row["extrapolated"]) - 1)
        if np.isfinite(off).all() and (off > LEAST).all():
            axes.plot(counts, off, marker="o", markersize=4, label=str(name))
    axes.set_xticks(counts, [f"{int(count)}" for count in counts])
    axes.set_xlabel(WORDS[refinement])
    finish(axes, f"Error by {WORDS[refinement]}", "share of the extrapolated answer", columns=3)
    return figure
