"""What plots of a result have in common: abscissae, rings at peaks, curves without vibration, measured points."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from fenics_mech._arrays import Array
from fenics_mech.errors import ResultError, ViewError
from fenics_mech.recovery import Result
from fenics_mech.recovery.measured import read_measurement
from fenics_mech.recovery.peaks import smoothed
from fenics_mech.views.figures import COLOURS, angle_axis, curve
from fenics_mech.views.reading import ForceReading, Peak, Reading
from fenics_mech.views.words import short

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


def named(kind: str, reading: ForceReading, name: str = "") -> str:
    """Name what an axis shows, with its unit."""
    return f"{name or kind} ({reading.units.label(kind)})"


def number_of(reading: Reading, member: str) -> int:
    """Give the number of a member."""
    if member not in reading.members:
        raise ViewError(f"the result has no member {member!r}; it has {', '.join(reading.members)}")
    return reading.members.index(member)


def method_of(result: Result) -> str:
    """Say what a curve of a result holds."""
    still = result.scene.analysis.method in ("quasi-static", "static")
    return "with deflection, quasi-static" if still else "with vibration"


def still_at(reading: Reading, peak: Peak) -> Array | None:
    """Give the strain without vibration at the place of a peak, where the result has it."""
    if "strain_quasi_static" not in reading.result.data:
        return None
    curves = reading.result.data["strain_quasi_static"].transpose("theta", "member", "s", "fibre").to_numpy()
    return smoothed(reading.result, curves[:, peak.i, peak.j, peak.f], "strain")[1] / reading.units.size("strain")


def strains_at(reading: Reading, member: str, s: float, fibre: str) -> tuple[Array, Array | None]:
    """Strain at a place of a member, and that without vibration where the result has it."""
    still, result, size = "strain_quasi_static", reading.result, reading.units.size("strain")
    sources = [result.data] + ([result.data.assign(strain=result.data[still])] if still in result.data else [])
    try:
        curves = [smoothed(result, Result(data).strain_at(member, s, fibre), "strain")[1] / size for data in sources]
    except ResultError as error:
        raise ViewError(str(error)) from error
    return curves[0], (curves[1] if len(curves) > 1 else None)


def draw_measured(axes: Axes, result: Result, member: str, place: tuple[float, str]) -> None:
    """Draw the points that were measured at a place and side of a member."""
    s, fibre = place
    for measurement in result.scene.measurements if result.scene.analysis.method != "transient" else ():
        if measurement.member == member and measurement.fibre == fibre and np.isclose(measurement.s, s):
            angle, strain = read_measurement(measurement.file)
            size = result.scene.answer_units.size("strain")
            axes.plot(np.degrees(angle) % 360, strain / size, label="measured", **MEASURED)


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
