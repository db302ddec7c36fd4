"""Plots of a result over one turn of the drive, over time or in the plane: functions that take and give axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fenics_mech._arrays import Array
from fenics_mech._constants import ROUNDING
from fenics_mech.errors import ResultError, ViewError
from fenics_mech.recovery import Result
from fenics_mech.recovery.measured import read_measurement
from fenics_mech.recovery.peaks import smoothed
from fenics_mech.recovery.signal import PEAK as AT_PEAK
from fenics_mech.views.drawn_parts import at_angles
from fenics_mech.views.figures import (
    COLOURS,
    angle_axis,
    curve,
    empty_figure,
    figure_in,
    figure_of,
    finish,
    new_axes,
)
from fenics_mech.views.prefixes import labelled
from fenics_mech.views.reading import SECTION_FORCES, ForceReading, Peak, Reading, reading_of, reading_of_members
from fenics_mech.views.words import DEGREE, MINUS, in_degrees, sentence, short

ROOM = 0.14  # of the axes above and below curves, for a peak's value
LEFT = 0.66  # of the axes: beyond it a peak's value stands before its ring
RING: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 9,
    "markerfacecolor": "none",
    "clip_on": False,
    "zorder": 5,
}
PATCH = {"facecolor": "white", "edgecolor": "none", "pad": 1, "alpha": 0.85}
MEASURED: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 4,
    "markerfacecolor": "white",
    "color": COLOURS[1],
}
STILL: dict[str, Any] = {"color": "#777777", "linestyle": "--", "linewidth": 1.2, "label": "without vibration"}
BAR = 0.7  # of the distance of two bars, that a bar is wide
MOST_CURVES = 8  # in one plot
MOST_RINGS = 4  # with values: more overlap
LEAST_BAR = 0.01  # of the largest harmonic: smaller bars cannot be seen
FEWEST_BARS = 12  # so that the natural frequencies beside them are shown too
MOST_MEMBERS = 3  # side by side in a figure
SECTIONS_HEIGHT = 6.6  # inches, of the figure
TITLE: dict[str, Any] = {"x": 0.01, "ha": "left", "fontsize": 11, "fontweight": "bold"}
ENVELOPE: dict[str, Any] = {"color": COLOURS[0], "alpha": 0.15, "linewidth": 0, "label": "all that the motion reaches"}
TICKS = 45  # degrees of the drive between two dots
COLUMNS, MOST_JOINTS = 3, 9  # of a figure
MOST_PATHS = 7  # as many as there are colours
PATH_HEIGHT = 5.4  # inches
SEEN = 0.002  # of the largest path, by which two curves must be apart to be seen


def over(reading: ForceReading, values: Array) -> tuple[Array, Array]:
    """Abscissae and ordinates of a curve: drive angle (degrees) over the whole turn, or time (s)."""
    # values: at its positions, ``(angles, ...)``
    return (reading.data["time"].to_numpy(), values) if reading.in_time else curve(reading.theta, values)


def abscissa(axes: Axes, reading: ForceReading) -> None:
    """Name and limit the axis of the drive angle, or of time."""
    if not reading.in_time:
        angle_axis(axes)
        return
    time = reading.data["time"].to_numpy()
    axes.set_xlabel("time (s)")
    axes.set_xlim(time[0], time[-1])


def mark(axes: Axes, reading: ForceReading, k: int, height: float, text: str, beyond: int = 0) -> None:
    """Draw the ring of a peak, and its value beside it."""
    (x,) = [reading.data["time"].to_numpy()[k]] if reading.in_time else [np.degrees(reading.theta[k]) % 360]
    start, end = (reading.data["time"].to_numpy()[[0, -1]]) if reading.in_time else (0, 360)
    right = (x - start) / (end - start) < LEFT
    axes.plot(x, height, color="black", **RING)
    look: dict[str, Any] = {"textcoords": "offset points", "ha": "left" if right else "right", "va": "center"}
    axes.annotate(
        text,
        (x, height),
        (7 if right else -7, 8 * beyond) if beyond else (9 if right else -9, 0),
        fontsize=9,
        weight="bold",
        bbox=PATCH,
        zorder=6,
        **look,
    )


def mark_peak(axes: Axes, reading: ForceReading, k: int, value: float) -> None:
    """Mark a peak with its value and where it occurs, on the side where the curve is not; see `mark`."""
    mark(axes, reading, k, value, f"{short(value)} at {reading.at(k)}", beyond=1 if value >= 0 else -1)
    axes.margins(y=ROOM)


def number_of(reading: Reading, member: str) -> int:
    """Give the number of a member."""
    if member not in reading.members:
        raise ViewError(f"the result has no member {member!r}; it has {', '.join(reading.members)}")
    return reading.members.index(member)


def strains_at(reading: Reading, member: str, s: float, fibre: str) -> tuple[Array, Array | None]:
    """Strain at a place of a member, and that without vibration where the result has it."""
    still, result, size = "strain_quasi_static", reading.result, reading.units.size("strain")
    sources = [result.data] + ([result.data.assign(strain=result.data[still])] if still in result.data else [])
    try:
        curves = [smoothed(result, Result(data).strain_at(member, s, fibre), "strain")[1] / size for data in sources]
    except ResultError as error:
        raise ViewError(str(error)) from error
    return curves[0], (curves[1] if len(curves) > 1 else None)


def mark_modes(axes: Axes, result: Result, limit: float) -> str:
    """Shade the range of each natural frequency over the cycle, in harmonics of the drive, and name it on top."""
    if "frequency" not in result.data:
        return ""
    frequency = result.data["frequency"].transpose("theta", "mode").to_numpy() * result.scene.period
    for mode, (low, high) in enumerate(zip(frequency.min(axis=0), frequency.max(axis=0))):
        if low < limit:
            axes.axvspan(low, high, color=COLOURS[1 + mode % 6], alpha=0.3, zorder=1, linewidth=1)
            at: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "ha": "center", "va": "top", "fontsize": 8}
            axes.text((low + min(high, limit)) / 2, 0.98 - 0.08 * (mode % 2), str(mode + 1), **at)
    if (lowest := float(frequency.min())) < limit:
        return "bands: natural frequencies over the cycle, by mode"
    return f"natural frequencies lie beyond, from {short(lowest)} times the drive on"


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
    peak, without = reading.peaks[number_of(reading, member)], None
    if s is None:
        values, where = reading.strain[:, peak.i, peak.j, peak.f], f"{reading.place(peak)}, {reading.side(peak)}"
        if (name := "strain_quasi_static") in result.data:
            curves = result.data[name].transpose("theta", "member", "s", "fibre").to_numpy()
            without = smoothed(result, curves[:, peak.i, peak.j, peak.f], "strain")[1] / reading.units.size("strain")
    else:
        values, without = strains_at(reading, member, s, fibre)
        where = f"{'mid-span' if s == 0.5 else f's = {s:g}'}, {fibre.replace('-', MINUS)} side"
    if without is not None:
        axes.plot(*over(reading, without), **STILL)
    still = result.scene.analysis.method in ("quasi-static", "static")
    label = "with deflection, quasi-static" if still else "with vibration"
    axes.plot(*over(reading, values), color=COLOURS[0], linestyle="-", label=label)
    if s is None:
        mark_peak(axes, reading, peak.k, float(values[peak.k]))
    elif not reading.in_time:
        for one in result.scene.measurements:
            if (one.member, one.fibre) == (member, fibre) and np.isclose(one.s, s):
                angle, strain = read_measurement(one.file)
                measured = strain / result.scene.answer_units.size("strain")
                axes.plot(np.degrees(angle) % 360, measured, label="measured", **MEASURED)
    abscissa(axes, reading)
    finish(axes, f"Strain of {member}, {where}", labelled(reading.units, "strain"))
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
        axes,
        f"Deflection of each member where it is largest{some}",
        labelled(reading.units, "length", "deflection"),
        columns=3,
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
    finish(axes, f"Magnitude of the joint forces{some}", labelled(reading.units, "force"))
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
    finish(axes, f"Harmonics of the strain of {member}, {where}", labelled(reading.units, "strain"))
    return axes


def plot_section_forces(
    result: Result, member: str, axes: Axes | None = None, *, force: str = "moment", at: float | None = None
) -> Axes:
    """Plot a section force along a member at one place of the motion. Shaded is all that the motion reaches.

    Parameters
    ----------
    result
        The result.
    member
        Label of the member.
    axes
        Where to draw; without them a figure is made.
    force
        What is drawn: "axial_force" (tension positive), "shear_force" (dM/ds) or "moment".
    at
        Drive angle (rad), or time (s) of a motion in time; without it that of the member's largest stress.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    ViewError
        When there is no such member or force.
    ResultError
        When the result lacks what is drawn.

    Examples
    --------
    >>> axes = fm.plot_section_forces(fm.Result.load("out/result.nc"), "coupler", force="shear_force")
    >>> axes.get_ylabel()
    'shear force (N)'
    """
    axes, reading = axes or new_axes(), reading_of_members(result)
    if force not in SECTION_FORCES:
        raise ViewError(f"there is no section force {force!r}; there are {', '.join(SECTION_FORCES)}")
    i = number_of(reading, member)
    where = _draw(axes, reading, i, force, at)
    axes.set_xlabel(_along(reading, i))
    name, kind = SECTION_FORCES[force]
    finish(axes, f"{sentence(name)} of {member} at {where}", f"{name} ({reading.units.label(kind)})")
    return axes


def _draw(axes: Axes, reading: Reading, i: int, force: str, at: float | None) -> str:
    """Draw a force along a member with all that the motion reaches, and say where in the motion it is."""
    values = reading.section_force(force)[:, i]
    x = reading.s * reading.lengths[i] / reading.units.size("length")
    now, where = _at(reading, values, reading.peaks[i].k, at)
    if len(values) > 1:
        axes.fill_between(x, values.min(axis=0), values.max(axis=0), **ENVELOPE)
    axes.plot(x, now, color=COLOURS[0], label="at this place of the motion")
    axes.axhline(0, color="#888888", linewidth=0.8, zorder=1.5)
    axes.set_xlim(x[0], x[-1])
    return where


def _at(reading: Reading, values: Array, peak: int, at: float | None) -> tuple[Array, str]:
    """Values at a drive angle (rad) or time (s), or at a position, and where that is in words."""
    if at is None:
        return values[peak], reading.at(peak)
    if not reading.in_time:
        return at_angles(reading.theta, values, np.array([at]))[0], in_degrees(at)
    time = reading.data["time"].to_numpy()
    if not time[0] <= at <= time[-1]:
        raise ViewError(f"the motion lasts from {time[0]:.6g} s to {time[-1]:.6g} s, and is asked for at {at:.6g} s")
    return np.array([np.interp(at, time, column) for column in values.T]), f"{short(at)} s"


def section_force_figure(result: Result) -> Figure:
    """Draw axial force, shear force and moment along the most stressed members, at the drive angles of their peaks."""
    reading = reading_of_members(result)
    shown = sorted(reading.ranked[:MOST_MEMBERS])
    figure, panels = empty_figure(len(SECTION_FORCES), SECTIONS_HEIGHT, columns=len(shown))
    rows = [[row] for row in panels] if len(shown) == 1 else panels
    for row, (force, (name, kind)) in zip(rows, SECTION_FORCES.items()):
        row[0].set_ylabel(f"{name} ({reading.units.label(kind)})")
        for axes, i in zip(row, shown):
            where = _draw(axes, reading, i, force, None)
            if force == next(iter(SECTION_FORCES)):
                axes.set_title(f"{reading.members[i]} at {where}", fontweight="bold", loc="left", fontsize=10)
    for axes, i in zip(rows[-1], shown):
        axes.set_xlabel(_along(reading, i))
    handles, names = rows[0][0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=2, fontsize=8, frameon=False)
    few = f"; {len(shown)} of {len(reading.members)} members" * (len(shown) < len(reading.members))
    figure.suptitle(f"Forces in the sections when the stress of each member is largest{few}", **TITLE)
    return figure


def _along(reading: Reading, i: int) -> str:
    """Name the axis of the places along a member."""
    first, second = reading.ends[i]
    return f"{reading.units.label('length')} from {first} to {second}"


def plot_force_path(result: Result, joint: str | None = None, axes: Axes | None = None) -> Axes:
    """Plot a force as the path of its arrow's tip: its direction and size over the motion, the largest with a ring.

    Parameters
    ----------
    result
        The result.
    joint
        Name of the joint, whose first body exerts the force on the second; without it the shaking force on the frame.
    axes
        Where to draw; without them a figure is made.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, with a dot at every 45 degrees of the drive.

    Raises
    ------
    ViewError
        When there is no such joint, or the result has no shaking force.

    Examples
    --------
    >>> fm.plot_force_path(fm.Result.load("out/result.nc"), "A").get_title("left").startswith("Force of joint A")
    True
    """
    axes, reading = axes or new_axes(PATH_HEIGHT), reading_of(result)
    if joint is not None and joint not in reading.joints:
        raise ViewError(f"the result has no joint {joint!r}; it has {', '.join(reading.joints)}")
    if joint is None and "shaking_force" not in reading.data:
        raise ViewError("the result has no shaking force")
    if joint is None:
        vectors = reading.of("shaking_force", "component")
    else:
        vectors = reading.of("joint_force", "joint", "component")[:, reading.joints.index(joint)]
    vectors = vectors / reading.units.size("force")
    _draw_path(axes, reading, vectors, COLOURS[0])
    axes.plot(0, 0, color="#555555", marker="+", markersize=12, linestyle="none")
    size = np.linalg.norm(vectors, axis=-1)
    k, unit = int(size.argmax()), reading.units.label("force")
    axes.plot(*vectors[k], color="black", **RING)
    axes.plot(*np.stack([np.zeros(2), vectors[k]], axis=-1), color="#777777", linewidth=0.8)
    name = "Shaking force" if joint is None else f"Force of joint {joint}"
    _finish(
        axes,
        f"{name}, at most {short(float(size[k]))} {unit} at {reading.at(k)}",
        f"force along y ({unit})",
        f"force along x ({unit})",
    )
    return axes


def plot_point_path(result: Result, points: Sequence[str] = (), axes: Axes | None = None) -> Axes:
    """Plot the paths of points, such as a coupler curve: of links that bend, and dashed of links that do not.

    Parameters
    ----------
    result
        The result.
    points
        Names as in the result: "traced" points of the scene, or "link.point". Without them those of the scene's
        `[points]`, or where it has none those that move on no circle about the ground.
    axes
        Where to draw; without them a figure is made.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, with a dot at every 45 degrees of the drive.

    Raises
    ------
    ViewError
        When there is no such point.

    Examples
    --------
    >>> fm.plot_point_path(fm.Result.load("out/result.nc"), ["coupler.B"]).get_xlabel()
    'x (mm)'
    """
    axes, reading = axes or new_axes(PATH_HEIGHT), reading_of(result)
    known = [str(name) for name in result.data["point"].to_numpy()] if "point" in result.data.coords else []
    if unknown := [name for name in points if name not in known]:
        raise ViewError(f"the result has no point {unknown[0]!r}; it has {', '.join(known)}")
    size, unit = reading.units.size("length"), reading.units.label("length")
    bends, apart, spans = "point_position_bent" in result.data, 0.0, 0.0
    names = list(points or path_points(result))[:MOST_PATHS]
    for name, colour in zip(names, COLOURS):
        rigid, path = (
            smoothed(result, result.data[kind].sel(point=name).transpose("theta", "component").to_numpy())[1] / size
            for kind in ("point_position", "point_position_bent" if bends else "point_position")
        )
        if bends:
            _draw_path(axes, reading, rigid, "#777777", dots=False, linestyle="--", linewidth=1.0)
            apart, spans = max(apart, float(np.abs(path - rigid).max())), max(spans, float(np.ptp(path, axis=0).max()))
        _draw_path(axes, reading, path, colour, label=name)
    title = f"Path of {names[0]}" if len(names) == 1 else "Paths of points"
    title += ". Dashed: links that do not bend" if apart > SEEN * spans else ""
    _finish(axes, title, f"y ({unit})", f"x ({unit})")
    return axes


def path_points(result: Result) -> list[str]:
    """Names of the points whose paths are drawn by themselves."""
    if "point" not in result.data.coords:
        return []
    traced = set(result.scene.points)
    names = [str(name) for name in result.data["point"].to_numpy()]
    if found := [name for name in names if name in traced]:
        return found
    place = result.data["point_position"].transpose("point", "theta", "component").to_numpy()
    span = np.ptp(place, axis=1).max(axis=-1)
    kept, seen = [], list[Array]()
    for i, name in enumerate(names):
        if span[i] > 1e-6 * span.max(initial=0.0) and not any(np.allclose(place[i], other) for other in seen):
            kept.append(name)
            seen.append(place[i])
    return kept


def force_path_figure(result: Result) -> Figure:
    """Draw the shaking force where there is one, and the forces of the most loaded joints, as paths of their tips."""
    reading = reading_of(result)
    shaking: list[str | None] = [None] if "shaking_force" in result.data else []
    size = reading.force.max(axis=0)
    ranked = [n for n in np.argsort(-size, kind="stable") if size[n] > ROUNDING * size.max()]
    joints = shaking + [reading.joints[n] for n in sorted(ranked[: MOST_JOINTS - len(shaking)])]
    figure, panels = figure_of(len(joints), COLUMNS, 0.4)
    for n, (axes, joint) in enumerate(zip(panels, joints)):
        plot_force_path(result, joint, axes)
        title = axes.get_title("left").replace(", at most", "\nat most")
        title = "\nat ".join(title.rsplit(" at ", 1)) if reading.in_time else title
        axes.set_title(title, fontsize=9, loc="left")
        if n % COLUMNS:
            axes.set_ylabel("")
        axes.tick_params(labelsize=8)
    _explain_dots(figure, reading)
    return figure


def point_path_figure(result: Result) -> Figure:
    """Draw the paths of the points that `plot_point_path` takes by itself, and say what the dots are."""
    figure = figure_in(plot_point_path(result))
    _explain_dots(figure, reading_of(result))
    return figure


def _explain_dots(figure: Figure, reading: ForceReading) -> None:
    """Say below a figure what the dots on its paths are."""
    if not reading.in_time:
        text = f"full dot: drive angle {reading.at(0)}; open dots: every {TICKS}{DEGREE} from there"
        figure.supxlabel(text, x=0.01, ha="left", fontsize=8, color="#555555")


def _draw_path(axes: Axes, reading: ForceReading, places: Array, colour: str, dots: bool = True, **look: Any) -> None:
    """Draw a closed path, or an open one of a motion in time, with dots at equal angles and the first one filled."""
    path = places if reading.in_time else np.concatenate([places, places[:1]])
    axes.plot(*path.T, **{"color": colour, "linestyle": "-"} | look)
    if reading.in_time or not dots:
        return
    angle = np.degrees(reading.theta - reading.theta[0])
    at = [int(np.abs(np.abs(angle) - degrees).argmin()) for degrees in range(0, 360, TICKS)]
    axes.plot(*places[at].T, linestyle="none", marker="o", markersize=3.5, color=colour, markerfacecolor="white")
    axes.plot(*places[0], linestyle="none", marker="o", markersize=5, color=colour)


def _finish(axes: Axes, title: str, ylabel: str, xlabel: str) -> None:
    axes.set_aspect("equal", adjustable="datalim")
    finish(axes, title, ylabel)
    axes.set_xlabel(xlabel)
