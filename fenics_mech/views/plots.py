"""Plots of a result over one turn of the drive (as figures 7.2 to 7.10)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

from fenics_mech._arrays import Array
from fenics_mech._constants import MICRO, MILLI
from fenics_mech.eigenmodes import simply_supported_frequencies
from fenics_mech.errors import ResultError, ViewError
from fenics_mech.forces.joint_forces import effort_units
from fenics_mech.recovery import Result
from fenics_mech.recovery.peaks import smoothed
from fenics_mech.recovery.result import at_place
from fenics_mech.recovery.signal import MID_SPAN
from fenics_mech.views.figures import COLOURS, DEFLECTION, SIZE, STRAIN, curve, empty_figure, finish, new_figure, save
from fenics_mech.views.geometry import member_ends, member_normals
from fenics_mech.views.measured import read_measurement

Curve = tuple[Array, Array, str]
"""Drive angle (rad), strain, and the label of the curve."""

LABEL_HEIGHT = 0.05  # of the axes
MEASURED: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 4,
    "markerfacecolor": "white",
    "color": COLOURS[1],
}


@dataclass(frozen=True)
class SpectrumLimits:
    """What the plot of harmonics shows."""

    most_members: int = 3  # more panels do not fit a page
    least_bar: float = 0.01  # of the largest harmonic: smaller bars cannot be seen
    fewest_bars: int = 12  # so that the natural frequencies beside them are shown too


SPECTRUM = SpectrumLimits()


def plot_strain(
    result: Result, member: str, path: str | Path, *, rigid: Curve | None = None, s: float = 0.5, fibre: str = "+"
) -> Path:
    """Plot the strain at one place of a member: finite elements, rigid bodies, and what was measured there.

    Parameters
    ----------
    result
        The result.
    member
        Label of the member.
    path
        File to write, ending in one of `ENDINGS`.
    rigid
        Drive angle (rad), strain, label of a quasi-static curve of rigid links at the same place.
    s
        Place along the member, 0..1.
    fibre
        "+" or "-".

    Raises
    ------
    SceneError
        When a file of measurements cannot be read.
    ViewError
        When there is no such member or fibre, or the file's ending is not known.
    ResultError
        When the file cannot be written.
    """
    return save(strain_figure(result, member, rigid=rigid, s=s, fibre=fibre), path)


def plot_frequencies(
    modes_frequency: Array, theta: Array, path: str | Path, supported: Mapping[str, float] | None = None
) -> Path:
    """Plot the tracked natural frequencies over the drive angle, the members' supported ones beside them.

    Parameters
    ----------
    modes_frequency
        Frequencies of the tracked modes (Hz), ``(angles, modes)``.
    theta
        Drive angles (rad), ``(angles,)``.
    path
        File to write, ending in one of `ENDINGS`.
    supported
        Frequency of each member as a simply supported beam (Hz), by label; eq. (7.6).

    Raises
    ------
    ViewError
        When the file's ending is not known.
    ResultError
        When the file cannot be written.
    """
    return save(frequency_figure(modes_frequency, theta, supported or {}), path)


def plot_all(result: Result, folder: str | Path, rigid: Mapping[str, Curve] | None = None) -> list[Path]:
    """Make all plots of a result as PNG files in `folder`, which is made when it is not there.

    Parameters
    ----------
    result
        The result.
    folder
        Where to write.
    rigid
        Rigid-body curves of the strain at mid-member, "+" fibre: member -> (drive angle (rad), strain, label).

    Returns
    -------
    list of Path
        The files, none where there is only one position: a strain plot per member at mid-span and per other measured
        place, deflections, and joint forces. A periodic motion has the spectrum of the strains, and modes have their
        frequencies.

    Raises
    ------
    SceneError
        When a file of measurements cannot be read.
    ViewError, ResultError
        When the folder cannot be made or a file cannot be written.

    Examples
    --------
    >>> result = fm.Result.load("out/result.nc")
    >>> [path.name for path in fm.plot_all(result, "out")][:2]
    ['strain_crank.png', 'strain_coupler.png']
    """
    folder, scene, rigid = Path(folder), result.scene, rigid or {}
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ViewError(f"{folder}: cannot make the folder: {error.strerror}") from error
    if result.data.sizes["theta"] == 1:
        return []
    if not scene.members():
        freedoms = [save(freedom_figure(result), folder / "freedoms.png")] if scene.freedoms else []
        return [save(joint_force_figure(result), folder / "joint_forces.png"), *freedoms]
    paths = [plot_strain(result, m, folder / f"strain_{m}.png", rigid=rigid.get(m)) for m in scene.members()]
    elsewhere = {(m.member, m.s, m.fibre) for m in scene.measurements} - {(m, 0.5, "+") for m in scene.members()}
    for member, s, fibre in sorted(elsewhere):
        name = f"strain_{member}_s{s:g}_{'plus' if fibre == '+' else 'minus'}.png"
        paths.append(plot_strain(result, member, folder / name, s=s, fibre=fibre))
    paths.append(save(deflection_figure(result), folder / "deflection.png"))
    paths.append(save(joint_force_figure(result), folder / "joint_forces.png"))
    if "strain_amplitude" in result.data:
        paths.append(save(spectrum_figure(result), folder / "spectrum.png"))
    if "frequency" in result.data:
        supported = {member: float(found[0]) for member, found in simply_supported_frequencies(scene).items()}
        frequency, theta = result.data["frequency"].to_numpy(), result.data["theta"].to_numpy()
        paths.append(plot_frequencies(frequency, theta, folder / "frequencies.png", supported))
    return paths


def strain_figure(
    result: Result, member: str, *, rigid: Curve | None = None, s: float = 0.5, fibre: str = "+"
) -> Figure:
    """Build the figure of `plot_strain`."""
    try:
        strain = MICRO * result.strain_at(member, s, fibre)
    except ResultError as error:
        raise ViewError(str(error)) from error
    scene, in_time = result.scene, _in_time(result)
    figure, (axes,) = figure_of(result)
    if rigid is not None and not in_time:
        axes.plot(*curve(rigid[0], MICRO * rigid[1]), label=rigid[2], color="#777777", linestyle="--", linewidth=1.3)
    still = scene.analysis.method in ("quasi-static", "static")
    method = "with deflection, quasi-static" if still else "with vibration"
    axes.plot(*_curve(result, strain), label=method, color=COLOURS[0], linestyle="-")
    for measurement in scene.measurements if not in_time else ():
        if measurement.member == member and measurement.fibre == fibre and np.isclose(measurement.s, s):
            angle, strain = read_measurement(measurement.file)
            axes.plot(np.degrees(angle) % 360, MICRO * strain, label="measured", **MEASURED)
    place = "mid-span" if s == 0.5 else f"s = {s:g}"
    sign = fibre.replace("-", "\N{MINUS SIGN}")
    finish(axes, f"Strain of {member} at {place}, {sign} side", STRAIN)
    return figure


def frequency_figure(frequency: Array, theta: Array, supported: Mapping[str, float]) -> Figure:
    """Build the figure of `plot_frequencies`: a log axis that holds the modes' range."""
    figure, (axes,) = new_figure(height=4.8)
    bends = frequency.max(axis=0) > 0  # others are of a rigid body
    for mode in np.flatnonzero(bends):
        axes.plot(*curve(theta, frequency[:, mode]), label=f"mode {mode + 1}")
    frequency = frequency[:, bends]
    low, high = frequency.min() / 1.1, frequency.max() * 1.1
    axes.set_yscale("log")
    axes.set_ylim(low, high)
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 1.5, 2, 3, 4, 5, 7) if high / low < 30 else (1, 2, 5)))
    axes.yaxis.set_major_formatter(ScalarFormatter())
    axes.yaxis.set_minor_formatter(NullFormatter())
    _draw_supported(axes, dict(sorted(supported.items(), key=lambda item: item[1])))
    finish(axes, "Natural frequencies. Dashed: each member simply supported", "frequency (Hz)")
    return figure


def joint_force_figure(result: Result) -> Figure:
    """Draw the magnitude of each joint's force, and below it the input torque where there is a drive."""
    driven = "input_torque" in result.data
    figure, panels = figure_of(result, rows=1 + driven, height=5.8 if driven else SIZE[1])
    forces = result.data["joint_force"].transpose("joint", "theta", "component")
    for joint, force in zip(forces["joint"].to_numpy(), forces.to_numpy()):
        panels[0].plot(*_curve(result, np.linalg.norm(force, axis=-1)), label=f"joint {joint}")
    finish(panels[0], "Magnitude of the joint forces", "force (N)")
    panels[0].set_ylim(bottom=0)
    if driven:
        panels[1].plot(*_curve(result, result.data["input_torque"].to_numpy()))
        panels[1].axhline(0, color="#888888", linewidth=0.8, zorder=1.5)
        slides = result.data["input_torque"].attrs["units"] == "N"
        finish(panels[1], *(("Drive force", "force (N)") if slides else ("Input torque", "torque (N m)")))
    return figure


def freedom_figure(result: Result) -> Figure:
    """Draw the angle or stroke of each freedom, and below it their rates."""
    figure, panels = figure_of(result, rows=2, height=5.8)
    units = {"N m": ("deg", 180 / np.pi), "N": ("mm", MILLI)}
    efforts = effort_units(tuple(result.scene.freedoms), result.scene.joints)
    for axes, name, title, per in zip(
        panels, ("freedom_place", "freedom_rate"), ("Freedoms", "Their rates"), ("", "/s")
    ):
        for i, (freedom, effort) in enumerate(zip(result.scene.freedoms, efforts)):
            unit, factor = units[effort]
            axes.plot(*_curve(result, factor * result.data[name].to_numpy()[:, i]), label=f"{freedom} ({unit}{per})")
        shown = sorted({units[effort][0] for effort in efforts})
        finish(axes, title, " or ".join(f"{unit}{per}" for unit in shown))
    return figure


def deflection_figure(result: Result) -> Figure:
    """Draw the mid-member transverse deflection of each member."""
    figure, (axes,) = figure_of(result)
    for member, values in zip(result.scene.members(), transverse_deflection(result).T):
        axes.plot(*_curve(result, MILLI * values), label=member)
    finish(axes, "Transverse deflection at mid-span, relative to the rigid linkage", DEFLECTION)
    return figure


def spectrum_figure(result: Result) -> Figure:
    """Draw harmonics of the mid-span strain of the members that bend most, and the range of every natural frequency."""
    amplitude = MICRO * result.data["strain_amplitude"].sel(gauge=MID_SPAN).transpose("member", "harmonic").to_numpy()
    largest = amplitude[:, 1:].max(axis=1, initial=0.0)
    shown = np.sort(np.argsort(-largest, kind="stable")[: SPECTRUM.most_members])
    heard = np.flatnonzero((amplitude[shown] > SPECTRUM.least_bar * largest.max()).any(axis=0))
    last = min(max(int(heard.max(initial=0)) + 1, SPECTRUM.fewest_bars), amplitude.shape[1] - 1)
    figure, panels = empty_figure(rows=len(shown), height=1.2 + 2.1 * len(shown))
    for axes, i in zip(panels, shown):
        axes.bar(np.arange(1, last + 1), amplitude[i, 1 : last + 1], width=0.7, color=COLOURS[0], zorder=2)
        member = result.data["member"].to_numpy()[i]
        finish(axes, f"Harmonics of the strain at mid-span, + side: {member}", STRAIN)
        axes.set_ylim(0, 1.2 * max(amplitude[i, 1 : last + 1].max(initial=0.0), np.finfo(float).tiny))
        _mark_modes(axes, result, last + 0.6)
    panels[-1].set_xlim(0.4, last + 0.6)
    bands = "; bands: natural frequencies over the cycle" if "frequency" in result.data else ""
    panels[-1].set_xlabel(f"harmonic of the drive ({1 / result.scene.period:.4g} Hz){bands}")
    return figure


def _mark_modes(axes: Axes, result: Result, limit: float) -> None:
    """Shade the range of each natural frequency over the cycle, in harmonics of the drive, and name it on top."""
    if "frequency" not in result.data:
        return
    frequency = result.data["frequency"].transpose("theta", "mode").to_numpy() * result.scene.period
    for mode, (low, high) in enumerate(zip(frequency.min(axis=0), frequency.max(axis=0))):
        if low < limit:
            axes.axvspan(low, high, color=COLOURS[1 + mode % 6], alpha=0.3, zorder=1, linewidth=1)
            at: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "ha": "center", "va": "top", "fontsize": 8}
            axes.text((low + min(high, limit)) / 2, 0.98 - 0.08 * (mode % 2), str(mode + 1), **at)


def transverse_deflection(result: Result) -> Array:
    """Deflection along each member's normal (m) from its rigid position at mid-span, ``(angles, members)``."""
    normal = member_normals(member_ends(result.scene, result.data["theta"].to_numpy()))
    deflection = result.data["deflection"].transpose("theta", "member", "component", "s").to_numpy()
    return np.sum(at_place(deflection, result.data["s"].to_numpy(), 0.5) * normal, axis=-1)


def figure_of(result: Result, rows: int = 1, height: float = SIZE[1]) -> tuple[Figure, Sequence[Axes]]:
    """Make a figure with axes over the drive angle, or over time for a motion in time."""
    if not _in_time(result):
        return new_figure(rows, height)
    figure, axes = empty_figure(rows, height)
    time = result.data["time"].to_numpy()
    axes[-1].set_xlabel("time (s)")
    axes[-1].set_xlim(time[0], time[-1])
    return figure, axes


def _in_time(result: Result) -> bool:
    return result.scene.analysis.method == "transient"


def _curve(result: Result, values: Array) -> tuple[Array, Array]:
    """Abscissae and ordinates of a curve in a figure of `figure_of`, smooth between few positions."""
    if _in_time(result):
        return result.data["time"].to_numpy(), values
    return curve(*smoothed(result, values))


def _draw_supported(axes: Axes, supported: Mapping[str, float]) -> None:
    """Draw a dashed line for each frequency, in rising order, and its label at the right edge, none upon another."""
    low, high = np.log(axes.get_ylim())
    places = (np.log(list(supported.values())) - low) / (high - low)
    labels = _spread(np.clip(places, 0, 1), LABEL_HEIGHT)
    for (name, value), place, label in zip(supported.items(), places, labels):
        grey: dict[str, Any] = {"color": "#555555", "linewidth": 0.9}
        arrow = "\N{UPWARDS ARROW}" if place > 1 else "\N{DOWNWARDS ARROW}" if place < 0 else ""
        if not arrow:
            axes.axhline(value, linestyle=(0, (5, 3)), zorder=1.5, **grey)
            axes.plot([1, 1.015], [place, label], linestyle="-", transform=axes.transAxes, clip_on=False, **grey)
        text = f"{name} {value:.4g} Hz {arrow}".strip()
        axes.text(1.02, label, text, transform=axes.transAxes, va="center", fontsize=9, color="#333333")


def _spread(places: Array, gap: float) -> Array:
    """Push sorted places apart until neighbours are `gap` apart, each as little as its neighbours allow."""
    places = places.copy()
    for _ in range(200):
        missing = np.clip(gap - np.diff(places), 0, None)
        places[:-1] -= missing / 2
        places[1:] += missing / 2
    return places
