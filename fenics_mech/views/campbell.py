"""Campbell diagram of a sweep over the drive's rate, with the strains in it and named resonances."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fenics_mech._arrays import Array
from fenics_mech.views.figures import COLOURS, empty_figure
from fenics_mech.views.resonances import (
    RESONANCE,
    Resonance,
    distances,
    gains,
    raised,
    ranges,
    resonances_of,
    sizes_at,
    whole_points,
)
from fenics_mech.views.sweep_curves import along, dot_beyond, look_of, settle
from fenics_mech.views.sweep_data import labelled, units_of, written_unit
from fenics_mech.views.words import short

if TYPE_CHECKING:
    from fenics_mech.studies.sweep import Sweep

MOST_ORDERS = 20  # lines of a Campbell diagram
NAME = 0.09  # half the width of a resonance's name, as a share of that of the picture
LABEL = 0.028  # of the picture, that the name of an order takes
LARGEST_DOT = 150  # points squared
BOX: dict[str, Any] = {"facecolor": "white", "edgecolor": "#dddddd", "pad": 2.5}


def campbell_figure(sweep: Sweep) -> Figure:
    """Draw each mode's range of frequencies, multiples of the drive's rate as lines, and below it the peak strain."""
    # Frequencies are those about the motion, where they are known. Dots, as large as the strain, show where a mode
    # raises a harmonic. The largest maxima are named with multiple, mode and speed. The diagram ends not far above the
    # lines, and shows the first mode.
    figure, (axes, lower) = empty_figure(rows=2, height=7.4, grid={"height_ratios": [1.9, 1]})
    x, data, units = along(sweep), sweep.data, units_of(sweep.data)
    low, high = ranges(data)
    own = np.abs(data["drive_rate"].to_numpy()) / (2 * math.pi)  # Hz
    places, rate = _rates(x, own)
    lines = np.arange(1, MOST_ORDERS + 1)[:, None] * rate
    top = min(1.08 * float(np.nanmax(high)), 1.3 * max(float(lines.max()), float(np.nanmax(high[:, 0]))))
    _draw_modes(axes, x, (low, high), top)
    lines = lines[lines.min(axis=1) < top]
    axes.plot(places, lines.T, color="#777777", linewidth=0.8, linestyle=(0, (5, 3)), zorder=1.5)
    axes.set_ylim(0, top)
    _name_orders(axes, places, lines, top)
    for i, member in enumerate(data["member"].to_numpy()):
        lower.plot(
            x, data["peak_strain"].sel(member=member) / units.size("strain"), label=str(member), **look_of(i, len(x))
        )
    dot_beyond(lower, sweep)
    if found := resonances_of(data):
        _draw_strains(axes, sweep)
    _name_resonances((axes, lower), sweep, [one for one in found if one.order * own[one.point] < top], own)
    title = f"Natural frequencies, multiples of the drive (dashed){', raised strains (dots)' if found else ''}"
    settle(axes, sweep, title, "frequency in the motion (Hz)" if "running_lowest" in data else "frequency (Hz)")
    settle(lower, sweep, "Largest strain in a cycle", labelled(units, "strain"), last=True)
    _mark_scene((axes, lower), x, own, data)
    return figure


def _draw_modes(axes: Axes, x: Array, modes: tuple[Array, Array], top: float) -> None:
    """Shade the range of each mode that begins below the upper edge."""
    for mode, (least, most) in enumerate(zip(modes[0].T, modes[1].T)):
        if np.nanmin(least) > top:
            continue
        colour = COLOURS[mode % len(COLOURS)]
        axes.fill_between(x, least, most, color=colour, alpha=0.35, linewidth=0, label=f"mode {mode + 1}")
        axes.plot(x, least, color=colour, linewidth=1, linestyle="-")
        axes.plot(x, most, color=colour, linewidth=1, linestyle="-")


def _draw_strains(axes: Axes, sweep: Sweep) -> None:
    """Draw dots where modes raise harmonics of the strain."""
    if not len(points := whole_points(sweep.data)):
        return
    rate, low, high, amplitude = sizes_at(sweep.data, points)
    shown = raised(gains(rate, amplitude), amplitude, distances(rate, low, high, amplitude.shape[2]))
    size = LARGEST_DOT * shown / (shown.max() or 1.0)
    k, order = np.nonzero(size)
    inside = order * rate[k] <= axes.get_ylim()[1]
    k, order = k[inside], order[inside]
    look: dict[str, Any] = {"color": COLOURS[0], "alpha": 0.6, "zorder": 3, "linewidth": 0, "clip_on": False}
    axes.scatter(along(sweep)[points][k], order * rate[k], s=size[k, order], **look)


def _name_resonances(panels: tuple[Axes, Axes], sweep: Sweep, found: list[Resonance], rate: Array) -> None:
    """Put a ring about the largest resonances, and write multiple, mode and speed below the upper edge."""
    upper, lower = panels
    x, unit = along(sweep), written_unit(sweep.data, sweep.paths[0])
    chosen = sorted(found[: RESONANCE.most], key=lambda one: one.point)
    low, high = float(x.min()), float(x.max())
    for place, one in zip(_apart([(x[one.point] - low) / (high - low) for one in chosen]), chosen):
        at = (x[one.point], one.order * rate[one.point])
        ring: dict[str, Any] = {"markersize": 13, "markerfacecolor": "none", "markeredgewidth": 1.4, "clip_on": False}
        upper.plot(*at, "o", markeredgecolor="black", zorder=4, **ring)
        value = f"{short(x[one.point])} {unit}".strip()
        turns = "" if unit == "rpm" else f"\n{short(60 * rate[one.point])} rpm"
        text = f"{one.order}\N{MULTIPLICATION SIGN} meets\nmode {one.mode + 1}\n{value}{turns}"
        look: dict[str, Any] = {"ha": "center", "va": "top", "fontsize": 8, "weight": "bold", "bbox": BOX, "zorder": 5}
        arrow = {"arrowstyle": "-", "color": "black", "linewidth": 0.8, "shrinkB": 7}
        where: dict[str, Any] = {"xytext": (place, 0.98), "textcoords": "axes fraction"}
        upper.annotate(text, at, arrowprops=arrow, **where, **look)
        lower.axvline(x[one.point], color="black", linewidth=0.8, linestyle=(0, (2, 3)))


def _apart(places: list[float]) -> list[float]:
    """Move ascending places, in shares of the width, as far apart as names are wide, and into the picture."""
    found = np.clip(places, NAME, 1 - NAME) if places else np.zeros(0)
    for i in range(1, len(found)):
        found[i] = max(found[i], found[i - 1] + 2 * NAME)
    for i in range(len(found) - 1, -1, -1):
        found[i] = min(found[i], 1 - NAME - 2 * NAME * (len(found) - 1 - i))
    return [float(one) for one in found]


def _mark_scene(panels: tuple[Axes, Axes], x: Array, rate: Array, data: xr.Dataset) -> None:
    """Draw the scene's own speed as a line, where the sweep goes over it."""
    if "stated_rate" not in data.attrs:
        return
    own = float(data.attrs["stated_rate"]) / (2 * math.pi)  # Hz
    known = np.isfinite(rate)
    order = np.argsort(rate[known])
    if not rate[known].min() <= own <= rate[known].max():
        return
    place = float(np.interp(own, rate[known][order], x[known][order]))
    for axes in panels:
        axes.axvline(place, color="black", linewidth=1.2, zorder=1.8)
    patch = {"facecolor": "white", "edgecolor": "none", "pad": 1}
    look: dict[str, Any] = {"textcoords": "offset points", "va": "top", "fontsize": 9, "weight": "bold", "bbox": patch}
    top = panels[1].get_ylim()[1]
    panels[1].annotate(f"scene: {short(60 * own)} rpm", (place, top), (4, -3), **look)


def _rates(x: Array, rate: Array) -> tuple[Array, Array]:
    """Give where rates are known, and these: everywhere, where those of the points that did not fail are on a line."""
    known = np.isfinite(rate)
    fitted = np.polynomial.Polynomial.fit(x[known], rate[known], min(1, known.sum() - 1), domain=x[[0, -1]])
    line = np.asarray(fitted(x), dtype=np.float64)
    return (x, line) if np.allclose(line[known], rate[known], rtol=1e-9, atol=0) else (x[known], rate[known])


def _name_orders(axes: Axes, x: Array, lines: Array, top: float) -> None:
    """Write the orders at the ends of their lines, right of the picture or below its upper edge, none upon another."""
    look: dict[str, Any] = {"fontsize": 7, "color": "#555555", "textcoords": "offset points"}
    above, beside = -math.inf, -math.inf
    for order, line in enumerate(lines, 1):
        name = f"{order}\N{MULTIPLICATION SIGN}"
        if line[-1] <= top and line[-1] - beside > LABEL * top:
            beside = line[-1]
            axes.annotate(name, (x[-1], beside), (4, 0), va="center", **look)
        elif line[-1] > top > line[0] and (np.diff(line) > 0).all():
            leaves = float(np.interp(top, line, x))
            if abs(leaves - above) > 1.2 * LABEL * np.ptp(x):
                above = leaves
                patch = {"facecolor": "white", "edgecolor": "none", "pad": 0.5}
                axes.annotate(name, (leaves, top), (0, -2), ha="center", va="top", bbox=patch, **look)
