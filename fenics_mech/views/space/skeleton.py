"""A linkage in space seen along an axis or obliquely: flat places of its lines, and the drawing in axes of a figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from fenics_mech._arrays import Array
from fenics_mech._constants import MILLI
from fenics_mech.views.figures import STYLE, empty_figure

TURNED, RAISED = np.radians(-52.0), np.radians(24.0)  # of the oblique view, about Z and above the XY plane
EYES = {  # of each view: the direction to the right, and the one upwards
    "XY": np.eye(3)[[0, 1]],
    "XZ": np.eye(3)[[0, 2]],
    "YZ": np.eye(3)[[1, 2]],
    "oblique": np.array(
        [
            [-np.sin(TURNED), np.cos(TURNED), 0.0],
            [-np.cos(TURNED) * np.sin(RAISED), -np.sin(TURNED) * np.sin(RAISED), np.cos(RAISED)],
        ]
    ),
}
INK, SHADE = "#222222", "#9aa2ab"
MARKS = {"ball": "o", "universal": "P", "revolute": "o", "cylinder": "s", "slider": "s", "plane": "D", "weld": "X"}
CROSS = 0.1  # of the oblique view, for the directions X, Y and Z
NEAR = 0.04  # of the width, within which joints cover one another
MARGIN, LEAST = 0.13, 0.4  # of the width, about a drawing; and the least of a view, of the largest


def seen(view: str, places: Array) -> Array:
    """Flat places in mm, as a view shows them ``(..., 2)``."""
    return np.asarray(MILLI * places @ EYES[view].T)


def four_views(title: str, places: Array) -> dict[str, Axes]:
    """Make a figure of the views along Z, Y and X, and an oblique one, that hold places on one scale."""
    flat = {view: seen(view, places).reshape(-1, 2) for view in EYES}
    spans = {view: (1 + 2 * MARGIN) * np.maximum(np.ptp(one, axis=0), 1e-6) for view, one in flat.items()}
    (x, y), z = spans["XY"], spans["XZ"][1]
    least = LEAST * max(x, y, z)
    columns = [max(x, least), max(y, float(spans["oblique"][0]), least)]
    rows = [max(y, float(spans["oblique"][1]), least), max(z, least)]
    height = 1.7 + min(6.0 * sum(rows) / sum(columns), 9.0)
    grid = {"width_ratios": columns, "height_ratios": rows}
    figure, panels = empty_figure(2, height, columns=2, grid=grid, shared=False)
    found = dict(zip(("XY", "oblique", "XZ", "YZ"), (axes for row in panels for axes in row)))
    with mpl.rc_context(STYLE):
        figure.suptitle(title, x=0.01, ha="left", fontsize=11, fontweight="bold")
        for n, (view, axes) in enumerate(found.items()):
            middle = (flat[view].min(axis=0) + flat[view].max(axis=0)) / 2
            (left, low), (right, high) = (
                middle + sign * np.array([columns[n % 2], rows[n // 2]]) / 2 for sign in (-1, 1)
            )
            axes.set(xlim=(left, right), ylim=(low, high), aspect="equal", anchor="NW")
            if view == "oblique":
                axes.set_axis_off()
            else:
                axes.set(xlabel=f"{view[0].lower()} (mm)", ylabel=f"{view[1].lower()} (mm)")
                axes.locator_params(nbins=6)
    return found


def draw_path(axes: Axes, view: str, path: Array, **look: Any) -> None:
    """Draw a line through places ``(points, 3)`` (m)."""
    axes.plot(*seen(view, path).T, **{"color": INK, "solid_capstyle": "round", "marker": "", "linestyle": "-"} | look)


def draw_coloured(axes: Axes, view: str, path: Array, values: Array, most: float, palette: str) -> LineCollection:
    """Draw a line in the colours of values at its stations, up to the largest of all."""
    flat = seen(view, path)
    axes.plot(*flat.T, color=INK, linewidth=5.4, solid_capstyle="round", linestyle="-", marker="")
    pieces = np.stack([flat[:-1], flat[1:]], axis=1)
    lines = LineCollection(list(pieces), cmap=palette, linewidths=3.8, capstyle="round", zorder=2.5)
    lines.set_array((values[:-1] + values[1:]) / 2)
    lines.set_clim(0, most or 1.0)
    axes.add_collection(lines)
    return lines


def draw_joints(axes: Axes, view: str, places: Array, kinds: Sequence[str], names: Sequence[str]) -> None:
    """Draw joints ``(joints, 3)`` by the marks of their kinds; names of those that cover one another stand together."""
    flat = seen(view, places).reshape(-1, 2)
    near = NEAR * float(np.ptp(axes.get_xlim()))
    for n, (place, kind) in enumerate(zip(flat, kinds)):
        fill = INK if kind == "ball" else "white"
        axes.plot(*place, linestyle="", marker=MARKS[kind], ms=7, mec=INK, mfc=fill, mew=1.4, zorder=3)
        here = [k for k, other in enumerate(flat) if np.linalg.norm(other - place) < near]
        if names and here[0] == n:
            look: dict[str, Any] = {"xytext": (6, 6), "textcoords": "offset points", "weight": "bold", "fontsize": 9}
            axes.annotate(", ".join(names[k] for k in here), place, zorder=4, **look)


def draw_axes_cross(axes: Axes) -> None:
    """Draw directions X, Y and Z into the lower left corner of an oblique view."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    size = CROSS * max(right - left, high - low)
    first = np.array([left, low]) + size
    for name, way in zip("XYZ", EYES["oblique"].T):
        last = first + size * way
        axes.annotate("", tuple(last), tuple(first), arrowprops={"arrowstyle": "-|>", "color": SHADE, "linewidth": 1.2})
        x, y = last + 0.3 * size * way
        axes.text(float(x), float(y), name, color="#555555", fontsize=9, ha="center", va="center")
