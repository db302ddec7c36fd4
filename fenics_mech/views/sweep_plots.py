"""Pictures of a sweep: peaks over one field, Campbell diagram, waterfall of harmonics, and maps over two fields."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
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
from fenics_mech.errors import ViewError
from fenics_mech.solve.stability_limits import STABILITY
from fenics_mech.views.figures import COLOURS, SIZE, STYLE, empty_figure, finish, logarithmic, save_all
from fenics_mech.views.prefixes import labelled
from fenics_mech.views.sweep_data import (
    BEYOND,
    RESONANCE,
    Resonance,
    beyond_theory,
    distances,
    edges,
    gains,
    named,
    raised,
    ranges,
    resonances_of,
    sizes_at,
    units_of,
    unresolved_at,
    unstable_points,
    whole_points,
    written,
    written_unit,
)
from fenics_mech.views.words import short

if TYPE_CHECKING:
    from fenics_mech.studies.sweep import Sweep

UNSTABLE, BETWEEN = "unstable", "between points"
MOST_ORDERS = 20  # lines of a Campbell diagram
NAME = 0.09  # half the width of a resonance's name, as a share of that of the picture
LABEL = 0.028  # of the picture, that the name of an order takes
LARGEST_DOT = 150  # points squared
BOX: dict[str, Any] = {"facecolor": "white", "edgecolor": "#dddddd", "pad": 2.5}
WIDE = 30  # ratio of largest to smallest from which a map's colours are logarithmic
# with a step at the limit of stability
SHADES = ((0.0, "#8fb0d3"), (0.5, "#eaf1f8"), (0.5, "#fee0c4"), (1.0, "#a63603"))
GROWTH = LinearSegmentedColormap.from_list("growth", SHADES)
FAILED = "#d9d9d9"
HATCHES = {"unstable": "////", BEYOND: ".."}
RESPONSES = {"stress": "stress", "strain": "strain", "deflection": "length"}  # and the kinds of their units
LEAST_WAVE, FEWEST_WAVES = 0.03, 5  # of the largest, up to which higher harmonics are left out; those that are kept
HIGHEST = 0.9  # wave of a waterfall, in steps between its base lines


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
    for mode, (least, most) in enumerate(zip(low.T, high.T)):  # that begin below the upper edge
        if np.nanmin(least) <= top:
            colour = COLOURS[mode % len(COLOURS)]
            axes.fill_between(x, least, most, color=colour, alpha=0.35, linewidth=0, label=f"mode {mode + 1}")
            for edge in (least, most):
                axes.plot(x, edge, color=colour, linewidth=1, linestyle="-")
    lines = lines[lines.min(axis=1) < top]
    axes.plot(places, lines.T, color="#777777", linewidth=0.8, linestyle=(0, (5, 3)), zorder=1.5)
    axes.set_ylim(0, top)
    _name_orders(axes, places, lines, top)
    for i, member in enumerate(data["member"].to_numpy()):
        lower.plot(
            x, data["peak_strain"].sel(member=member) / units.size("strain"), label=str(member), **look_of(i, len(x))
        )
    dot_beyond(lower, sweep)
    if found := resonances_of(data):  # dots where modes raise harmonics of the strain
        rates, least, most, amplitude = sizes_at(data, points := whole_points(data))
        shown = raised(gains(rates, amplitude), amplitude, distances(rates, least, most, amplitude.shape[2]))
        k, order = np.nonzero(shown * (np.arange(shown.shape[1]) * rates[:, None] <= top))
        look: dict[str, Any] = {"color": COLOURS[0], "alpha": 0.6, "zorder": 3, "linewidth": 0, "clip_on": False}
        sizes = LARGEST_DOT * shown[k, order] / shown.max(initial=1e-300)
        axes.scatter(x[points][k], order * rates[k], s=sizes, **look)
    _name_resonances((axes, lower), sweep, [one for one in found if one.order * own[one.point] < top], own)
    title = f"Natural frequencies, multiples of the drive (dashed){', raised strains (dots)' if found else ''}"
    settle(axes, sweep, title, "frequency in the motion (Hz)" if "running_lowest" in data else "frequency (Hz)")
    settle(lower, sweep, "Largest strain in a cycle", labelled(units, "strain"), last=True)
    _mark_scene((axes, lower), x, own, data)
    return figure


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


def plot_sweep(sweep: Sweep, folder: str | Path, member: str | None = None) -> list[Path]:
    """Make the plots of a sweep over one or two fields as PNG files in `folder`."""
    data, folder = sweep.data, Path(folder)
    if "peak_strain" not in data:
        return []
    members, every = [str(label) for label in data["member"].to_numpy()], data["peak_strain"]
    check_member(members, member)
    member = member or members[every.max(sweep.paths).to_numpy().argmax()]
    figures: dict[str, Figure] = {}
    if len(sweep.paths) == 1:
        figures = {"response": response_figure(sweep)}
        if "peak_joint_force" in data:  # a link may turn without joints
            figures["forces"] = force_figure(sweep)
        if "frequency_lowest" in data and "drive_rate" in data:
            figures["campbell"] = campbell_figure(sweep)
        if "strain_harmonic" in data and data.sizes["harmonic"] > 1:
            figures["waterfall"] = waterfall_figure(sweep, member)
        if "multiplier" in data:
            figures["stability"] = stability_figure(sweep)
        if "safety" in data and np.isfinite(data["safety"]).any():
            figures["safety"] = safety_figure(sweep)
    elif len(sweep.paths) == 2:
        figures["map"] = strain_map(sweep, member)
        if "multiplier" in data:
            figures["stability"] = stability_map(sweep)
    return save_all(figures, folder, "sweep_")


def check_member(members: list[str], member: str | None) -> None:
    """Raise a `ViewError` when a member that is asked for is not there."""
    if member is not None and member not in members:
        raise ViewError(f"there is no member {member!r}; the scene has {', '.join(members)}")


def response_figure(sweep: Sweep) -> Figure:
    """Peak stress, strain and deflection of every member over the swept field, below one another."""
    data, units = sweep.data, units_of(sweep.data)
    shown = {name: kind for name, kind in RESPONSES.items() if f"peak_{name}" in data}  # older sweeps have no stress
    figure, panels = empty_figure(rows=len(shown), height=3.2 * len(shown))
    for axes, (name, kind) in zip(panels, shown.items()):
        for i, member in enumerate(data["member"].to_numpy()):
            curve = data[f"peak_{name}"].sel(member=member) / units.size(kind)
            draw(axes, sweep, curve, i, str(member))
            mark_between(axes, sweep, name, str(member), i, units.size(kind))
        dot_beyond(axes, sweep)
        if len(places := unresolved_at(data, sweep.paths)):
            look: dict[str, Any] = {"linestyle": "none", "marker": "v", "markersize": 5, "color": "#777777"}
            edge = axes.get_xaxis_transform()
            axes.plot(places, 0 * places + 1, transform=edge, clip_on=False, label="not resolved", **look)
        settle(axes, sweep, f"Largest {name} in a cycle", labelled(units, kind, name), last=axes is panels[-1])
    return figure


def force_figure(sweep: Sweep) -> Figure:
    """Peak joint forces over the swept field, and below them the peak input torque where there is one."""
    data, units = sweep.data, units_of(sweep.data)
    torque = "peak_input_torque" in data
    figure, panels = empty_figure(rows=1 + torque, height=6.4 if torque else SIZE[1])
    for i, joint in enumerate(data["joint"].to_numpy()):
        forces = data["peak_joint_force"].sel(joint=joint) / units.size("force")
        draw(panels[0], sweep, forces, i, f"joint {joint}")
    dot_beyond(panels[0], sweep)
    settle(panels[0], sweep, "Largest joint forces in a cycle", labelled(units, "force"), last=not torque)
    if torque:
        slides = data["peak_input_torque"].attrs["units"] == "N"
        kind, name, what = ("force", "force", "drive force") if slides else ("moment", "torque", "input torque")
        draw(panels[1], sweep, data["peak_input_torque"] / units.size(kind), 0)
        dot_beyond(panels[1], sweep)
        settle(panels[1], sweep, f"Largest {what} in a cycle", labelled(units, kind, name), last=True)
    return figure


def waterfall_figure(sweep: Sweep, member: str) -> Figure:
    """Amplitude of every harmonic of a strain over the swept field, one above the other."""
    x, data, gauge = along(sweep), sweep.data, json.loads(sweep.data.attrs["gauge"])
    units, waves = units_of(data), data["strain_harmonic"].sel(member=member).transpose("harmonic", ...).to_numpy()
    amplitude = waves[1:] / units.size("strain")
    largest = float(np.nanmax(amplitude)) or 1.0
    seen = np.flatnonzero(np.nanmax(amplitude, axis=1) > LEAST_WAVE * largest)
    amplitude = amplitude[: max(int(seen.max(initial=0)) + 1, FEWEST_WAVES)]
    figure, (axes,) = empty_figure(height=max(4.0, 1.6 + 0.24 * len(amplitude)))
    waves = np.arange(1, len(amplitude) + 1)[:, None] + HIGHEST * amplitude / largest
    for order, wave in enumerate(waves, 1):
        axes.fill_between(x, order, wave, color=COLOURS[5], alpha=0.6, linewidth=0, zorder=3 - order / 100)
        axes.plot(x, wave, color=COLOURS[0], linewidth=1, linestyle="-", zorder=3 - order / 100)
    axes.set_ylim(0.5, float(np.nanmax(waves)) + 0.3)
    axes.set_yticks([order for order in range(1, len(amplitude) + 1) if order == 1 or order % 2 == 0])
    dot_beyond(axes, sweep)
    place = "mid-span" if gauge["s"] == 0.5 else f"s = {gauge['s']:g}"
    sign = gauge["fibre"].replace("-", "\N{MINUS SIGN}")
    title = f"Strain of {member} at {place}, {sign} side: harmonics"
    settle(axes, sweep, title, "harmonic of the drive", last=True)
    decade = 10.0 ** math.floor(math.log10(largest))
    amount = max(step * decade for step in (1, 2, 5) if step * decade <= largest)
    ends, beside = np.array([1.0, 1.0 + HIGHEST * amount / largest]), axes.get_yaxis_transform()
    axes.plot([1.02, 1.02], ends, color="black", linewidth=2, linestyle="-", transform=beside, clip_on=False)
    text = f"{amount:g} {units.label('strain')}"
    axes.text(1.035, float(ends.mean()), text, transform=beside, va="center", fontsize=9)
    return figure


def safety_figure(sweep: Sweep) -> Figure:
    """Least factor of safety over the wanted one of every member, over the swept field."""
    figure, (axes,) = empty_figure()
    data = sweep.data
    for i, member in enumerate(data["member"].to_numpy()):
        curve = data["safety"].sel(member=member)
        if np.isfinite(curve).any():
            draw(axes, sweep, curve.where(np.isfinite(curve)), i, str(member))
    axes.axhline(1, color=COLOURS[1], linewidth=1, linestyle="--", zorder=1.5)
    found = data["safety"].where(np.isfinite(data["safety"]))
    logarithmic(axes, min(1, found.min().item()) / 1.1, max(1, found.max().item()) * 1.1)
    dot_beyond(axes, sweep)
    title = "Safety: too small below the dashed line"
    settle(axes, sweep, title, "least factor of safety over the wanted one", last=True)
    return figure


def stability_figure(sweep: Sweep) -> Figure:
    """Largest Floquet multiplier over the swept field."""
    figure, (axes,) = empty_figure()
    x, largest = along(sweep), sweep.data["multiplier"].max("disturbance")
    axes.plot(x, largest, **look_of(0, len(x)))
    dot_beyond(axes, sweep)
    axes.axhline(1, color=COLOURS[1], linewidth=1, linestyle="--", zorder=1.5)
    settle(axes, sweep, "Stability: disturbances grow above the dashed line", "largest Floquet multiplier", last=True)
    return figure
