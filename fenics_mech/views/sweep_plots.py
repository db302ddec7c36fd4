"""Pictures of a sweep: peaks over the swept field, Campbell diagram, waterfall of harmonics."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fenics_mech._arrays import Array
from fenics_mech._constants import MICRO, MILLI
from fenics_mech.errors import ViewError
from fenics_mech.views.figures import COLOURS, DEFLECTION, SIZE, STRAIN, empty_figure, finish, save
from fenics_mech.views.sweep_data import BEYOND, beyond_theory, edges, named, written
from fenics_mech.views.sweep_maps import stability_map, strain_map

if TYPE_CHECKING:
    from fenics_mech.studies.sweep import Sweep

MOST_ORDERS = 20  # lines of a Campbell diagram
LABEL = 0.028  # of the picture, that the name of an order takes
HIGHEST = 0.9  # wave of a waterfall, in steps between its base lines


def plot_sweep(sweep: Sweep, folder: str | Path, member: str | None = None) -> list[Path]:
    """Make the plots of a sweep over one or two fields as PNG files in `folder`.

    Parameters
    ----------
    sweep
        The sweep; of one over more fields, or without a point that has a result, nothing is drawn.
    folder
        Where to write.
    member
        Member of the waterfall and of the map; without it, the one with the largest strain.

    Raises
    ------
    ViewError
        When there is no such member.
    ResultError
        When a file cannot be written.
    """
    data, folder = sweep.data, Path(folder)
    if "peak_strain" not in data:
        return []
    members, every = [str(label) for label in data["member"].to_numpy()], data["peak_strain"]
    check_member(members, member)
    member = member or members[every.max(sweep.paths).to_numpy().argmax()]
    figures: dict[str, Figure] = {}
    if len(sweep.paths) == 1:
        figures = {"response": response_figure(sweep), "forces": force_figure(sweep)}
        if "frequency_lowest" in data and "drive_rate" in data:
            figures["campbell"] = campbell_figure(sweep)
        if "strain_harmonic" in data and data.sizes["harmonic"] > 1:
            figures["waterfall"] = waterfall_figure(sweep, member)
        if "multiplier" in data:
            figures["stability"] = stability_figure(sweep)
    elif len(sweep.paths) == 2:
        figures["map"] = strain_map(sweep, member)
        if "multiplier" in data:
            figures["stability"] = stability_map(sweep)
    return [save(figure, folder / f"sweep_{name}.png") for name, figure in figures.items()]


def check_member(members: list[str], member: str | None) -> None:
    """Raise a `ViewError` when a member that is asked for is not there."""
    if member is not None and member not in members:
        raise ViewError(f"there is no member {member!r}; the scene has {', '.join(members)}")


def response_figure(sweep: Sweep) -> Figure:
    """Peak strain of every member, and below it the peak deflection, over the swept field."""
    figure, (upper, lower) = empty_figure(rows=2, height=6.4)
    x, data = _along(sweep), sweep.data
    for i, member in enumerate(data["member"].to_numpy()):
        look = _look(i, len(x))
        upper.plot(x, MICRO * data["peak_strain"].sel(member=member), label=str(member), **look)
        lower.plot(x, MILLI * data["peak_deflection"].sel(member=member), label=str(member), **look)
    for axes in (upper, lower):
        _dot_beyond(axes, sweep)
    _settle(upper, sweep, "Largest strain in a cycle", STRAIN)
    _settle(lower, sweep, "Largest deflection in a cycle", DEFLECTION, last=True)
    return figure


def force_figure(sweep: Sweep) -> Figure:
    """Peak joint forces over the swept field, and below them the peak input torque where there is one."""
    x, data = _along(sweep), sweep.data
    torque = "peak_input_torque" in data
    figure, panels = empty_figure(rows=1 + torque, height=6.4 if torque else SIZE[1])
    for i, joint in enumerate(data["joint"].to_numpy()):
        panels[0].plot(x, data["peak_joint_force"].sel(joint=joint), label=f"joint {joint}", **_look(i, len(x)))
    _dot_beyond(panels[0], sweep)
    _settle(panels[0], sweep, "Largest joint forces in a cycle", "force (N)", last=not torque)
    if torque:
        panels[1].plot(x, data["peak_input_torque"], **_look(0, len(x)))
        _dot_beyond(panels[1], sweep)
        slides = data["peak_input_torque"].attrs["units"] == "N"
        what, label = ("drive force", "force (N)") if slides else ("input torque", "torque (N m)")
        _settle(panels[1], sweep, f"Largest {what} in a cycle", label, last=True)
    return figure


def campbell_figure(sweep: Sweep) -> Figure:
    """Campbell diagram: each mode's range of frequencies, and multiples of the drive's rate as lines from below.

    It ends not far above these lines, and shows the first mode.
    """
    figure, (axes,) = empty_figure(height=5.2)
    x, data = _along(sweep), sweep.data
    low, high = data["frequency_lowest"].to_numpy(), data["frequency_highest"].to_numpy()
    places, rate = _rates(x, np.abs(data["drive_rate"].to_numpy()) / (2 * math.pi))  # Hz
    lines = np.arange(1, MOST_ORDERS + 1)[:, None] * rate
    top = min(1.08 * float(np.nanmax(high)), 1.3 * max(float(lines.max()), float(np.nanmax(high[:, 0]))))
    for mode, (least, most) in enumerate(zip(low.T, high.T)):
        if np.nanmin(least) > top:
            continue
        colour = COLOURS[mode % len(COLOURS)]
        axes.fill_between(x, least, most, color=colour, alpha=0.35, linewidth=0, label=f"mode {mode + 1}")
        axes.plot(x, least, color=colour, linewidth=1, linestyle="-")
        axes.plot(x, most, color=colour, linewidth=1, linestyle="-")
    lines = lines[lines.min(axis=1) < top]
    axes.plot(places, lines.T, color="#777777", linewidth=0.8, linestyle=(0, (5, 3)), zorder=1.5)
    axes.set_ylim(0, top)
    title = "Natural frequencies over the cycle. Dashed: multiples of the drive's rate"
    _settle(axes, sweep, title, "frequency (Hz)", last=True)
    _name_orders(axes, places, lines, top)
    return figure


def _rates(x: Array, rate: Array) -> tuple[Array, Array]:
    """Give where rates are known, and these: everywhere, where those of the points that did not fail are on a line."""
    known = np.isfinite(rate)
    line = np.polynomial.Polynomial.fit(x[known], rate[known], min(1, known.sum() - 1), domain=x[[0, -1]])(x)
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


def waterfall_figure(sweep: Sweep, member: str) -> Figure:
    """Amplitude of every harmonic of a strain over the swept field, one above the other."""
    x, data, gauge = _along(sweep), sweep.data, json.loads(sweep.data.attrs["gauge"])
    amplitude = MICRO * data["strain_harmonic"].sel(member=member).transpose("harmonic", ...).to_numpy()[1:]
    largest = float(np.nanmax(amplitude)) or 1.0
    figure, (axes,) = empty_figure(height=max(4.0, 1.6 + 0.24 * len(amplitude)))
    waves = np.arange(1, len(amplitude) + 1)[:, None] + HIGHEST * amplitude / largest
    for order, wave in enumerate(waves, 1):
        axes.fill_between(x, order, wave, color=COLOURS[5], alpha=0.6, linewidth=0, zorder=3 - order / 100)
        axes.plot(x, wave, color=COLOURS[0], linewidth=1, linestyle="-", zorder=3 - order / 100)
    axes.set_ylim(0.5, float(np.nanmax(waves)) + 0.3)
    axes.set_yticks([order for order in range(1, len(amplitude) + 1) if order == 1 or order % 2 == 0])
    _dot_beyond(axes, sweep)
    place = "mid-span" if gauge["s"] == 0.5 else f"s = {gauge['s']:g}"
    sign = gauge["fibre"].replace("-", "\N{MINUS SIGN}")
    title = f"Strain of {member} at {place}, {sign} side: harmonics"
    _settle(axes, sweep, title, "harmonic of the drive", last=True)
    _scale_bar(axes, HIGHEST, largest)
    return figure


def _scale_bar(axes: Axes, height: float, largest: float) -> None:
    """Draw what a round amplitude is long, right of the axes."""
    decade = 10.0 ** math.floor(math.log10(largest))
    amount = max(step * decade for step in (1, 2, 5) if step * decade <= largest)
    foot = 1.0
    head = foot + height * amount / largest
    beside = axes.get_yaxis_transform()
    axes.plot([1.02, 1.02], [foot, head], color="black", linewidth=2, linestyle="-", transform=beside, clip_on=False)
    text = f"{amount:g} \N{MICRO SIGN}m/m"
    axes.text(1.035, (foot + head) / 2, text, transform=beside, va="center", fontsize=9)


def stability_figure(sweep: Sweep) -> Figure:
    """Largest Floquet multiplier over the swept field."""
    figure, (axes,) = empty_figure()
    x, largest = _along(sweep), sweep.data["multiplier"].max("disturbance")
    axes.plot(x, largest, **_look(0, len(x)))
    _dot_beyond(axes, sweep)
    axes.axhline(1, color=COLOURS[1], linewidth=1, linestyle="--", zorder=1.5)
    _settle(axes, sweep, "Stability: disturbances grow above the dashed line", "largest Floquet multiplier", last=True)
    return figure


def _settle(axes: Axes, sweep: Sweep, title: str, ylabel: str, last: bool = False) -> None:
    """Set titles, labels and limits, and mark on the lower edge the points that failed."""
    x = _along(sweep)
    failed = x[sweep.data["error"].to_numpy() != ""]
    if axes.get_ylim()[0] < 0:
        axes.set_ylim(bottom=0)
    if len(failed):
        look: dict[str, Any] = {"linestyle": "none", "marker": "x", "markersize": 5, "color": "#777777"}
        floor = axes.get_xaxis_transform()
        axes.plot(failed, 0 * failed, transform=floor, clip_on=False, label="failed", **look)
    axes.set_xlim(x.min(), x.max())
    if last:
        axes.set_xlabel(named(sweep.data, sweep.paths[0]))
    finish(axes, title, ylabel)


def _dot_beyond(axes: Axes, sweep: Sweep) -> None:
    """Dot the background about points outside the theory, as far as to the middle between them and the next."""
    x, beyond = _along(sweep), beyond_theory(sweep.data).to_numpy()
    around = edges(x)
    runs = np.flatnonzero(np.diff(beyond, prepend=False, append=False)).reshape(-1, 2)
    look: dict[str, Any] = {"facecolor": "none", "edgecolor": "#aaaaaa", "hatch": "..", "linewidth": 0, "zorder": 0.5}
    for k, (first, end) in enumerate(runs):
        axes.axvspan(around[first], around[end], label="" if k else BEYOND, **look)


def _look(index: int, points: int) -> dict[str, Any]:
    """Colour and marks of a curve; single points are marked where there are few."""
    marks = {"marker": "o", "markersize": 3, "clip_on": False} if points <= 60 else {}
    return {"color": COLOURS[index % len(COLOURS)], "linestyle": ("-", ":", "-.")[index // len(COLOURS) % 3], **marks}


def _along(sweep: Sweep) -> Array:
    """Values of the swept field as written."""
    return written(sweep.data, sweep.paths[0])
