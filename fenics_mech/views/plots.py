"""Plots of a result over one turn of the drive, or over time: functions that take and give axes."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from fenics_mech.errors import ViewError
from fenics_mech.recovery import Result
from fenics_mech.recovery.signal import PEAK as AT_PEAK
from fenics_mech.views.figures import COLOURS, finish, new_axes
from fenics_mech.views.plot_marks import (
    abscissa,
    draw_measured,
    mark,
    mark_modes,
    mark_peak,
    method_of,
    named,
    number_of,
    over,
    still_at,
    strains_at,
)
from fenics_mech.views.reading import Peak, reading_of, reading_of_members
from fenics_mech.views.words import MINUS, sentence, short

STILL: dict[str, Any] = {"color": "#777777", "linestyle": "--", "linewidth": 1.2, "label": "without vibration"}
BAR = 0.7  # of the distance of two bars, that a bar is wide
MOST_CURVES = 8  # in one plot
MOST_RINGS = 4  # with values: more overlap
LEAST_BAR = 0.01  # of the largest harmonic: smaller bars cannot be seen
FEWEST_BARS = 12  # so that the natural frequencies beside them are shown too


def plot_strain(
    result: Result, member: str, axes: Axes | None = None, *, s: float | None = None, fibre: str = "+"
) -> Axes:
    """Plot the strain of a member where its stress is largest, with its value there and the curve without vibration.

    The summary and the report name the same place, drive angle and strain.

    Parameters
    ----------
    result
        The result.
    member
        Label of the member.
    axes
        Where to draw; without them a figure is made.
    s
        Another place along the member, 0..1. Points that were measured there are drawn too.
    fibre
        Side at that place, "+" or "-".

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    SceneError
        When a file of measurements cannot be read.
    ViewError
        When there is no such member, fibre or place.
    ResultError
        When the result lacks what is drawn.

    Examples
    --------
    >>> axes = fm.plot_strain(fm.Result.load("out/result.nc"), "follower")
    >>> axes.get_title("left")
    'Strain of follower, 149 mm from C, + side'
    """
    axes, reading = axes or new_axes(), reading_of_members(result)
    peak = reading.peaks[number_of(reading, member)]
    if s is None:
        values, where = reading.strain[:, peak.i, peak.j, peak.f], f"{reading.place(peak)}, {reading.side(peak)}"
        without = still_at(reading, peak)
    else:
        values, without = strains_at(reading, member, s, fibre)
        where = f"{'mid-span' if s == 0.5 else f's = {s:g}'}, {fibre.replace('-', MINUS)} side"
    if without is not None:
        axes.plot(*over(reading, without), **STILL)
    axes.plot(*over(reading, values), color=COLOURS[0], linestyle="-", label=method_of(result))
    if s is None:
        mark_peak(axes, reading, peak.k, float(values[peak.k]))
    else:
        draw_measured(axes, result, member, (s, fibre))
    abscissa(axes, reading)
    finish(axes, f"Strain of {member}, {where}", named("strain", reading))
    return axes


def plot_strain_map(result: Result, member: str, axes: Axes | None = None) -> Axes:
    """Plot the strain of a member by place and drive angle, on the side of its largest stress, which has a ring.

    The colours end at the largest strain of all members.

    Parameters
    ----------
    result
        The result.
    member
        Label of the member.
    axes
        Where to draw; without them a figure is made.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; the coloured picture is ``axes.images[0]``.

    Raises
    ------
    ViewError
        When there is no such member.
    ResultError
        When the result lacks what is drawn.

    Examples
    --------
    >>> axes = fm.plot_strain_map(fm.Result.load("out/result.nc"), "crank")
    >>> axes.images[0].get_clim()[1] == -axes.images[0].get_clim()[0]
    True
    """
    axes, reading = axes or new_axes(), reading_of_members(result)
    peak = reading.peaks[number_of(reading, member)]
    x, values = over(reading, reading.strain[:, peak.i, :, peak.f])
    limit, length = float(np.abs(reading.strain).max()) or 1.0, reading.lengths[peak.i] / reading.units.size("length")
    step = (x[-1] - x[0]) / max(len(x) - 1, 1) / 2
    extent = (x[0] - step, x[-1] + step, -length / (len(reading.s) - 1) / 2, length * (1 + 0.5 / (len(reading.s) - 1)))
    look: dict[str, Any] = {"cmap": "RdBu_r", "vmin": -limit, "vmax": limit, "aspect": "auto", "origin": "lower"}
    even = np.linspace(x[0], x[-1], len(x))  # as an image is, where positions are not
    rows = [np.interp(even, x, along) for along in values.T]
    axes.imshow(rows, extent=extent, interpolation="bilinear", **look)
    value = reading.strain[peak]
    height = reading.s[peak.j] * length
    mark(axes, reading, peak.k, height, f"{short(value)} {reading.units.label('strain')}")
    first, second = reading.ends[peak.i]
    axes.grid(visible=False)
    axes.set_ylim(0, length)
    axes.set_yticks([0, length], [f"{first}  0", f"{second}  {short(length)} {reading.units.label('length')}"])
    abscissa(axes, reading)
    finish(axes, f"{member}, {reading.side(peak)}", "")
    return axes


def plot_deflection(result: Result, axes: Axes | None = None) -> Axes:
    """Plot the deflection of each member from the rigid linkage at the place where it is largest, with a ring there.

    The summary and the report name the same places and values. Of many members those are drawn that deflect most.

    Parameters
    ----------
    result
        The result.
    axes
        Where to draw; without them a figure is made.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Examples
    --------
    >>> axes = fm.plot_deflection(fm.Result.load("out/result.nc"))
    >>> axes.get_ylabel()
    'deflection (mm)'
    """
    axes, reading = axes or new_axes(), reading_of_members(result)
    ranked = np.argsort(-reading.bent.max(axis=(0, 2, 3)), kind="stable")[:MOST_CURVES]
    for i in sorted(ranked.tolist()):
        peak = reading.peak(reading.bent, i)
        (line,) = axes.plot(*over(reading, reading.bent[:, i, peak.j, 0]))
        line.set_label(f"{reading.members[i]}, {reading.place(peak)}")
        if len(ranked) <= MOST_RINGS or i == ranked[0]:
            mark_peak(axes, reading, peak.k, float(reading.bent[peak]))
    abscissa(axes, reading)
    some = f", the {len(ranked)} largest of {len(reading.members)}" if len(ranked) < len(reading.members) else ""
    finish(
        axes, f"Deflection of each member where it is largest{some}", named("length", reading, "deflection"), columns=3
    )
    axes.set_ylim(bottom=0)
    return axes


def plot_joint_forces(result: Result, axes: Axes | None = None) -> Axes:
    """Plot the magnitude of each joint's force, and mark the largest. Of many joints those with the largest are drawn.

    Parameters
    ----------
    result
        The result.
    axes
        Where to draw; without them a figure is made.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Examples
    --------
    >>> axes = fm.plot_joint_forces(fm.Result.load("out/result.nc"))
    >>> axes.get_ylabel()
    'force (N)'
    """
    axes, reading = axes or new_axes(), reading_of(result)
    ranked = np.argsort(-reading.force.max(axis=0), kind="stable")[:MOST_CURVES]
    for n in sorted(ranked.tolist()):
        axes.plot(*over(reading, reading.force[:, n]), label=f"joint {reading.joints[n]}")
    if reading.joints:
        k, n = (int(i) for i in np.unravel_index(reading.force.argmax(), reading.force.shape))
        mark_peak(axes, reading, k, float(reading.force[k, n]))
    abscissa(axes, reading)
    some = f", the {len(ranked)} largest of {len(reading.joints)}" if len(ranked) < len(reading.joints) else ""
    finish(axes, f"Magnitude of the joint forces{some}", named("force", reading))
    axes.set_ylim(bottom=0)
    return axes


def plot_drive(result: Result, axes: Axes | None = None) -> Axes:
    """Plot the torque of the first drive, or its force where it slides, and mark the largest.

    Parameters
    ----------
    result
        The result.
    axes
        Where to draw; without them a figure is made.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    ViewError
        When nothing is driven.

    Examples
    --------
    >>> fm.plot_drive(fm.Result.load("out/result.nc")).get_ylabel()
    'torque (N m)'
    """
    axes, reading = axes or new_axes(), reading_of(result)
    if reading.effort is None:
        raise ViewError("the result has no torque or force of a drive")
    axes.plot(*over(reading, reading.effort))
    axes.axhline(0, color="#888888", linewidth=0.8, zorder=1.5)
    k = int(np.abs(reading.effort).argmax())
    mark_peak(axes, reading, k, float(reading.effort[k]))
    abscissa(axes, reading)
    name, unit = reading.effort_name
    finish(axes, sentence(name), f"{name.removeprefix('drive ')} ({unit})")
    return axes


def plot_spectrum(result: Result, member: str, axes: Axes | None = None) -> Axes:
    """Plot the harmonics of a member's strain where it is largest, and the range of every natural frequency.

    Parameters
    ----------
    result
        The result of a periodic motion.
    member
        Label of the member.
    axes
        Where to draw; without them a figure is made.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    ViewError
        When there is no such member, or the result has no harmonics.

    Examples
    --------
    >>> axes = fm.plot_spectrum(fm.Result.load("out/result.nc"), "coupler")
    >>> axes.get_title("left").startswith("Harmonics of the strain of coupler")
    True
    """
    axes, reading = axes or new_axes(), reading_of_members(result)
    i = number_of(reading, member)
    if "strain_amplitude" not in result.data:
        raise ViewError("the result has no harmonics: its motion is not periodic")
    gauge = result.data["strain_amplitude"].sel(gauge=AT_PEAK)
    amplitude = gauge.transpose("member", "harmonic").to_numpy() / reading.units.size("strain")
    heard = np.flatnonzero(amplitude[i] > LEAST_BAR * amplitude[i, 1:].max(initial=0.0))
    last = min(max(int(heard.max(initial=0)) + 1, FEWEST_BARS), amplitude.shape[1] - 1)
    axes.bar(np.arange(1, last + 1), amplitude[i, 1 : last + 1], BAR, color=COLOURS[0], zorder=2)  # apart on any axis
    j = int(np.abs(reading.s - float(gauge["gauge_s"][i])).argmin())
    side = str(gauge["gauge_fibre"].to_numpy()[i]).replace("-", MINUS)
    axes.set_xlim(0.4, last + 0.6)
    axes.set_ylim(0, 1.2 * max(amplitude[i, 1 : last + 1].max(initial=0.0), np.finfo(float).tiny))
    said = mark_modes(axes, result, last + 0.6)
    axes.set_xlabel("; ".join(filter(None, [f"harmonic of the drive ({1 / result.scene.period:.4g} Hz)", said])))
    where = f"{reading.place(Peak(0, i, j))}, {side} side"
    finish(axes, f"Harmonics of the strain of {member}, {where}", named("strain", reading))
    return axes
