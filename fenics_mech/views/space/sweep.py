"""A sweep of a scene in space: curves over the swept number, and a table."""

from __future__ import annotations

import json
from pathlib import Path

import matplotlib as mpl
import numpy as np
import xarray as xr
from rich.console import Group
from rich.text import Text

from fenics_mech.views.figures import STYLE, empty_figure, save
from fenics_mech.views.tables import plain_table
from fenics_mech.views.words import short

SHOWN = {  # variable by panel: its label and factor
    "von_mises": ("equivalent stress (MPa)", 1e-6),
    "deflection": ("deflection (mm)", 1e3),
    "joint_force": ("joint force (N)", 1.0),
    "input_torque": ("drive effort (N m; N)", 1.0),
    "lowest_frequency": ("natural frequency (Hz)", 1.0),
    "multiplier": ("largest multiplier", 1.0),
}
HEADS = {  # of the columns of the table
    "von_mises": "stress\nMPa",
    "deflection": "deflection\nmm",
    "joint_force": "force\nN",
    "input_torque": "drive\nN m; N",
    "lowest_frequency": "lowest\nHz",
    "multiplier": "multiplier\n",
}
MOST = 12  # rows of the table


def plot_sweep_in_space(found: xr.Dataset, folder: Path) -> list[Path]:
    """Draw all largest sizes over the one number that varies; nothing of a grid.

    Parameters
    ----------
    found
        What `sweep_in_space` gave.
    folder
        Where sweep.png is written.
    """
    (path, *more) = json.loads(found.attrs["paths"])
    if more:
        return []
    names = [name for name in SHOWN if name in found]
    with mpl.rc_context(STYLE):
        figure, panels = empty_figure(rows=len(names), height=1.0 + 2.1 * len(names))
        for axes, name in zip(panels, names):
            label, factor = SHOWN[name]
            values = factor * found[name].to_numpy()
            others = [dim for dim in found[name].dims if dim != path]
            labels = found[others[0]].to_numpy() if others and others[0] in found.coords else [None] * values[0].size
            for column, one in zip(values.reshape(len(values), -1).T, labels):
                axes.plot(found[path], column, marker=".", label=None if one is None else str(one))
            axes.set_ylabel(label)
            if others and labels[0] is not None and len(labels) > 1:
                axes.legend(fontsize=8, ncols=4)
        panels[0].set_title(f"Largest sizes over {path}")
        panels[-1].set_xlabel(f"{path} (SI)")
        for failed in np.flatnonzero(found["error"].to_numpy() != ""):
            for axes in panels:
                axes.axvline(found[path].to_numpy()[failed], color="#D55E00", alpha=0.4, lw=1)
    return [save(figure, folder / "sweep.png")]


def sweep_table(found: xr.Dataset) -> Group:
    """Tabulate the largest sizes of each point and its lowest frequency, and tell why points failed."""
    paths, names = json.loads(found.attrs["paths"]), [name for name in SHOWN if name in found]
    table, said = (
        plain_table(*(path.replace(".", ".\n", 1) for path in paths), *(HEADS[name] for name in names)),
        list[Text](),
    )
    flat = found.stack(point=paths)
    count = flat.sizes["point"]
    for k in np.unique(np.linspace(0, count - 1, min(count, MOST)).astype(int)):
        here = flat.isel(point=int(k))
        at = [f"{float(here[path]):.5g}" for path in paths]
        if failed := str(here["error"].item()):
            said.append(Text(f"{', '.join(at)}: {failed}"))
            continue
        sizes = {name: SHOWN[name][1] * np.abs(here[name].to_numpy()) for name in names}
        told = [np.nanmin(size) if name == "lowest_frequency" else np.nanmax(size) for name, size in sizes.items()]
        table.add_row(*at, *map(short, told))
    if count > MOST:
        said.append(Text(f"{MOST} of {count} points; sweep.nc holds all"))
    return Group(table, *said)
