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
from fenics_mech.views.campbell import campbell_figure
from fenics_mech.views.figures import COLOURS, SIZE, STYLE, empty_figure, logarithmic, save_all
from fenics_mech.views.sweep_curves import along, dot_beyond, draw, look_of, mark_between, mark_unresolved, settle
from fenics_mech.views.sweep_data import BEYOND, beyond_theory, edges, labelled, named, units_of, written

if TYPE_CHECKING:
    from fenics_mech.studies.sweep import Sweep

WIDE = 30  # ratio of largest to smallest from which a map's colours are logarithmic
# with a step at the limit of stability
SHADES = ((0.0, "#8fb0d3"), (0.5, "#eaf1f8"), (0.5, "#fee0c4"), (1.0, "#a63603"))
GROWTH = LinearSegmentedColormap.from_list("growth", SHADES)
FAILED = "#d9d9d9"
HATCHES = {"unstable": "////", BEYOND: ".."}
RESPONSES = {"stress": "stress", "strain": "strain", "deflection": "length"}  # and the kinds of their units
LEAST_WAVE, FEWEST_WAVES = 0.03, 5  # of the largest, up to which higher harmonics are left out; those that are kept
HIGHEST = 0.9  # wave of a waterfall, in steps between its base lines


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
        mark_unresolved(axes, sweep)
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
    _scale_bar(axes, HIGHEST, largest, units.label("strain"))
    return figure


def _scale_bar(axes: Axes, height: float, largest: float, unit: str) -> None:
    """Draw what a round amplitude is long, right of the axes."""
    decade = 10.0 ** math.floor(math.log10(largest))
    amount = max(step * decade for step in (1, 2, 5) if step * decade <= largest)
    foot = 1.0
    head = foot + height * amount / largest
    beside = axes.get_yaxis_transform()
    axes.plot([1.02, 1.02], [foot, head], color="black", linewidth=2, linestyle="-", transform=beside, clip_on=False)
    text = f"{amount:g} {unit}"
    axes.text(1.035, (foot + head) / 2, text, transform=beside, va="center", fontsize=9)


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
