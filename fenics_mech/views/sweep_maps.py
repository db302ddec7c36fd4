"""Maps of a sweep over two fields: the largest strain, and stability (Strutt's diagram)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import Colormap, LinearSegmentedColormap, LogNorm, Normalize, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from fenics_mech._arrays import Array
from fenics_mech.solve.stability_limits import STABILITY
from fenics_mech.views.figures import STYLE, empty_figure
from fenics_mech.views.sweep_data import BEYOND, beyond_theory, edges, labelled, named, units_of, written

if TYPE_CHECKING:
    from fenics_mech.studies.sweep import Sweep

WIDE = 30  # ratio of largest to smallest from which a map's colours are logarithmic
# with a step at the limit of stability
SHADES = ((0.0, "#8fb0d3"), (0.5, "#eaf1f8"), (0.5, "#fee0c4"), (1.0, "#a63603"))
GROWTH = LinearSegmentedColormap.from_list("growth", SHADES)
FAILED = "#d9d9d9"
HATCHES = {"unstable": "////", BEYOND: ".."}


def strain_map(sweep: Sweep, member: str) -> Figure:
    """Map of a member's peak strain over two swept fields."""
    units = units_of(sweep.data)
    values = sweep.data["peak_strain"].sel(member=member) / units.size("strain")
    low, high = float(values.min()), float(values.max())
    norm = LogNorm(low, high) if low > 0 and high / low > WIDE else Normalize(0, high)
    title = f"Largest strain of {member} in a cycle"
    return _map(sweep, values, norm, "viridis", title, labelled(units, "strain"), ("unstable", BEYOND))


def stability_map(sweep: Sweep) -> Figure:
    """Map of the largest Floquet multiplier over two swept fields, with the limit of stability (Strutt's diagram)."""
    values = sweep.data["multiplier"].max("disturbance")
    low, high = float(values.min()), float(values.max())
    norm = TwoSlopeNorm(1, min(low, 1 - 1e-3), max(high, 1 + 1e-3))
    title = "Stability: unstable where orange, stable where blue"
    figure = _map(sweep, values, norm, GROWTH, title, "largest Floquet multiplier", (BEYOND,))
    if low < 1 < high:
        figure.axes[0].contour(*_grid(sweep, values), levels=[1], colors="black", linewidths=1.2)
    return figure


def _map(
    sweep: Sweep,
    values: xr.DataArray,
    norm: Normalize,
    colours: str | Colormap,
    title: str,
    label: str,
    marks: Sequence[str],
) -> Figure:
    """Colour the cells about the points of a grid as far as they are in the range, and explain hatches and grey."""
    figure, (axes,) = empty_figure(height=5.0)
    across, up, field = _grid(sweep, values)
    with mpl.rc_context(STYLE):
        axes.set_facecolor(FAILED)
        axes.grid(visible=False)
        mesh = axes.pcolormesh(across, up, field, norm=norm, cmap=colours, shading="nearest")
        figure.colorbar(mesh, ax=axes, label=label)
        legend = [mark for name in marks if (mark := _hatched(axes, sweep, name))]
        if bool((sweep.data["error"] != "").any()):
            legend.append(Patch(label="failed", facecolor=FAILED))
        if legend:
            axes.legend(handles=legend, loc="lower left", bbox_to_anchor=(0, 1), ncols=3, borderaxespad=0.2)
        axes.set_title(title, pad=8 + 15 * bool(legend))
        axes.set(xlim=(across.min(), across.max()), ylim=(up.min(), up.max()))
        axes.set(xlabel=named(sweep.data, sweep.paths[0]), ylabel=named(sweep.data, sweep.paths[1]))
    return figure


def _hatched(axes: Axes, sweep: Sweep, name: str) -> Patch | None:
    """Hatch a map where points are unstable or outside the theory, and give what explains it, if there are any."""
    if name == BEYOND:
        marked = beyond_theory(sweep.data)
    elif "multiplier" in sweep.data:
        marked = sweep.data["multiplier"].max("disturbance") > 1 + STABILITY.tolerance
    else:
        return None
    if not bool(marked.any()):
        return None
    across, up, field = _grid(sweep, marked)
    x, y = edges(across), edges(up)
    cells = [[(x[i], y[j]), (x[i + 1], y[j]), (x[i + 1], y[j + 1]), (x[i], y[j + 1])] for j, i in np.argwhere(field)]
    look: dict[str, Any] = {"facecolor": "none", "edgecolor": "black", "linewidth": 0}
    axes.add_collection(PolyCollection(cells, hatch=HATCHES[name], **look))
    return Patch(label=name, hatch=HATCHES[name], **look)


def _grid(sweep: Sweep, field: xr.DataArray) -> tuple[Array, Array, Array]:
    """Give the values of both fields as written, and another field over them, with the second one as rows."""
    across, up = sweep.paths
    return written(sweep.data, across), written(sweep.data, up), field.transpose(up, across).to_numpy()
