"""What plots over one swept field have in common: their axis, marks of failed points, and where theory ends."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from fenics_mech._arrays import Array
from fenics_mech.views.figures import COLOURS, finish
from fenics_mech.views.sweep_data import BEYOND, beyond_theory, edges, named, unresolved_at, unstable_points, written

if TYPE_CHECKING:
    from fenics_mech.studies.sweep import Sweep

UNSTABLE, BETWEEN = "unstable", "between points"


def settle(axes: Axes, sweep: Sweep, title: str, ylabel: str, last: bool = False) -> None:
    """Set titles, labels and limits, and mark on the lower edge the points that failed or are too coarse."""
    x = along(sweep)
    if axes.get_ylim()[0] < 0:
        axes.set_ylim(bottom=0)
    for name, label, marker in (("error", "failed", "x"), ("too_coarse", "too coarse", "+")):
        if name in sweep.data and len(there := x[sweep.data[name].to_numpy() != ""]):
            look: dict[str, Any] = {"linestyle": "none", "marker": marker, "markersize": 5, "color": "#777777"}
            floor = axes.get_xaxis_transform()
            axes.plot(there, 0 * there, transform=floor, clip_on=False, label=label, **look)
    axes.set_xlim(x.min(), x.max())
    if last:
        axes.set_xlabel(named(sweep.data, sweep.paths[0]))
    finish(axes, title, ylabel)


def dot_beyond(axes: Axes, sweep: Sweep) -> None:
    """Dot the background about points outside the theory, as far as to the middle between them and the next."""
    x, beyond = along(sweep), beyond_theory(sweep.data).to_numpy()
    around = edges(x)
    runs = np.flatnonzero(np.diff(beyond, prepend=False, append=False)).reshape(-1, 2)
    look: dict[str, Any] = {"facecolor": "none", "edgecolor": "#aaaaaa", "hatch": "..", "linewidth": 0, "zorder": 0.5}
    for k, (first, end) in enumerate(runs):
        axes.axvspan(around[first], around[end], label="" if k else BEYOND, **look)


def mark_unresolved(axes: Axes, sweep: Sweep) -> None:
    """Mark on the upper edge where between its points the peak strain of a sweep is not resolved."""
    if len(places := unresolved_at(sweep.data, sweep.paths)):
        look: dict[str, Any] = {"linestyle": "none", "marker": "v", "markersize": 5, "color": "#777777"}
        edge = axes.get_xaxis_transform()
        axes.plot(places, 0 * places + 1, transform=edge, clip_on=False, label="not resolved", **look)


def draw(axes: Axes, sweep: Sweep, values: xr.DataArray, index: int, label: str = "") -> None:
    """Draw a curve over the swept field: a line where motions are stable, and rings on dashes where they are not."""
    x, unstable = along(sweep), unstable_points(sweep.data).to_numpy()
    look, y = look_of(index, len(x)), values.to_numpy().astype(float)
    axes.plot(x, np.where(unstable, np.nan, y), label=label, **look)
    if not unstable.any():
        return
    beside = unstable | np.append(unstable[1:], False) | np.append(False, unstable[:-1])
    dashes: dict[str, Any] = {"linestyle": (0, (2, 2)), "linewidth": 1, "color": look["color"]}
    rings: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 4, "markerfacecolor": "white"}
    axes.plot(x, np.where(beside, y, np.nan), **dashes)
    told = axes.get_legend_handles_labels()[1]
    said = "" if UNSTABLE in told else UNSTABLE
    axes.plot(x, np.where(unstable, y, np.nan), label=said, markeredgecolor=look["color"], **rings)


def mark_between(axes: Axes, sweep: Sweep, name: str, member: str, index: int, size: float) -> None:
    """Mark the largest stress or strain of a member that was found between the points; `size` is that of its unit."""
    found = json.loads(str(sweep.data.attrs.get("between", "")) or "{}")
    if found.get("member") == member and name in found:
        x = found["value"] / sweep.data[sweep.paths[0]].attrs["written_factor"]
        look: dict[str, Any] = {"linestyle": "none", "marker": "D", "markersize": 5, "label": BETWEEN}
        axes.plot([x], [found[name] / size], color=COLOURS[index % len(COLOURS)], **look)


def look_of(index: int, points: int) -> dict[str, Any]:
    """Colour and marks of a curve; single points are marked where there are few."""
    marks = {"marker": "o", "markersize": 3, "clip_on": False} if points <= 60 else {}
    return {"color": COLOURS[index % len(COLOURS)], "linestyle": ("-", ":", "-.")[index // len(COLOURS) % 3], **marks}


def along(sweep: Sweep) -> Array:
    """Values of the swept field as written."""
    return written(sweep.data, sweep.paths[0])
