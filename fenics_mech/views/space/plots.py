"""Plots of a result in space: stresses, section moments, deflections, forces, torque, frequencies, and views."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fenics_mech._arrays import Array
from fenics_mech.recovery.spatial_result import SpatialResult
from fenics_mech.views.figures import (
    COLOURS,
    STYLE,
    angle_axis,
    curve,
    empty_figure,
    figure_in,
    finish,
    save_all,
)
from fenics_mech.views.space.reading import SpatialReading
from fenics_mech.views.space.skeleton import (
    SHADE,
    draw_axes_cross,
    draw_coloured,
    draw_joints,
    draw_path,
    four_views,
)
from fenics_mech.views.words import short

MOST_ROWS, MOST_JOINTS, MOST_MODES = 4, 12, 12  # that a figure shows
MOMENTS = ("torsion", "bending about the first axis", "bending about the second axis")
PALETTE = "YlOrRd"


def spatial_plots(result: SpatialResult, folder: Path, only: Collection[str], ending: str) -> list[Path]:
    """Write the plots of a result in space into a folder, all or those that are named."""
    reading = SpatialReading(result)
    chosen = {n: draw for n, (has, draw) in SPATIAL_FIGURES.items() if (not only or n in only) and has(reading)}
    return save_all({name: draw(reading) for name, draw in chosen.items()}, folder, ending=ending)


def _abscissa(reading: SpatialReading, axes: Axes, length: float = 0.0) -> None:
    if reading.in_time:
        axes.set_xlabel("time (s)")
        axes.set_xlim(reading.time[0], reading.time[-1])
    elif reading.moves:
        angle_axis(axes)
    else:
        axes.set_xlabel(f"place along the member ({reading.units.label('length')} from its first end)")
        axes.set_xlim(0, reading.units.number(length, "length"))


def _history(reading: SpatialReading, values: Array) -> tuple[Array, Array]:
    """Abscissa and ordinate of values over the whole turn (degrees), or over a motion in time (s)."""
    return (reading.time, values) if reading.in_time else curve(reading.theta, values)


def _over(reading: SpatialReading, values: Array, i: int, length: bool = True) -> tuple[Array, Array]:
    """Abscissa and ordinate of ``(T, S)`` of a member: its largest over the cycle, or at rest along it."""
    if reading.moves:
        return _history(reading, np.abs(values).max(axis=1))
    return reading.s * reading.units.number(reading.lengths[i], "length"), values[0]


def _by_member(reading: SpatialReading, values: Array, title: str, unit: str) -> Figure:
    """Draw the largest on each member over the cycle ``(T, M, S)``, or at rest along it, with a ring at the peak."""
    figure, (axes,) = empty_figure()
    _abscissa(reading, axes, max(reading.lengths))
    ranked = np.argsort(-values.max(axis=(0, 2)), kind="stable")[: len(COLOURS)]
    with mpl.rc_context(STYLE):
        for i in map(int, ranked):
            axes.plot(*_over(reading, values[:, i], i), label=reading.members[i])
        k, i, j = peak = reading.peak(values)
        x = reading.time[k] if reading.in_time else np.degrees(reading.theta[k]) % 360
        x = x if reading.moves else reading.units.number(reading.s[j] * reading.lengths[i], "length")
        axes.plot(x, values[peak], marker="o", ms=9, mfc="none", mec="black", mew=1.6, linestyle="")
        axes.set_ylim(0, 1.12 * float(values[peak]) or 1.0)
        finish(axes, f"{title}, at most {short(values[peak])} {unit} in {reading.words(peak)}", f"{unit}")
    return figure


def stress_figure(reading: SpatialReading) -> Figure:
    """Draw the largest von Mises stress of each member over the cycle."""
    return _by_member(reading, reading.stress, "Von Mises stress", reading.units.label("stress"))


def deflection_figure(reading: SpatialReading) -> Figure:
    """Draw the largest deflection of each member over the cycle."""
    return _by_member(reading, reading.bent, "Deflection", reading.units.label("length"))


def moment_figure(reading: SpatialReading) -> Figure:
    """Draw torsion and both bendings in the section of each member's largest stress, or at rest along the member."""
    ranked = [int(i) for i in np.argsort(-reading.stress.max(axis=(0, 2)), kind="stable")][:MOST_ROWS]
    figure, rows = empty_figure(len(ranked), 1.2 + 1.9 * len(ranked), shared=reading.moves)
    with mpl.rc_context(STYLE):
        for axes, i in zip(rows, ranked):
            j = reading.peak(reading.stress, i)[2]
            for n, name in enumerate(MOMENTS):
                if reading.moves:
                    axes.plot(*_history(reading, reading.moments[:, i, j, n]), label=name)
                else:
                    axes.plot(*_over(reading, reading.moments[:, i, :, n], i), label=name)
            where = f", {reading.place(i, j)}" if reading.moves else ""
            label = f"section moments ({reading.units.label('moment')})" if len(rows) == 1 else None
            title = f"{reading.members[i]}{where}"
            if axes is rows[0]:
                finish(axes, title, label or reading.units.label("moment"))
            else:
                axes.set_title(title)
                axes.set_ylabel(reading.units.label("moment"))
            if axes is rows[-1] or not reading.moves:
                _abscissa(reading, axes, reading.lengths[i])
        title = "Moments in the section of the largest stress" if reading.moves else "Moments along the members"
        figure.suptitle(title, x=0.01, ha="left", fontsize=10)
    return figure


def force_figure(reading: SpatialReading) -> Figure:
    """Draw the size of the joint forces over the cycle."""
    figure, (axes,) = empty_figure()
    _abscissa(reading, axes)
    ranked = sorted(np.argsort(-reading.force.max(axis=0), kind="stable")[:MOST_JOINTS])
    with mpl.rc_context(STYLE):
        for n in ranked:
            axes.plot(*_history(reading, reading.force[:, n]), label=reading.joints[n])
        axes.set_ylim(0, None)
        finish(axes, "Joint forces", reading.units.label("force"))
    return figure


def drive_figure(reading: SpatialReading) -> Figure:
    """Draw what each drive exerts over the cycle."""
    figure, rows = empty_figure(len(reading.drives), 1.0 + 2.6 * len(reading.drives))
    with mpl.rc_context(STYLE):
        for n, axes in enumerate(rows):
            kind = reading.effort_kinds[n]
            axes.plot(*_history(reading, reading.efforts[:, n]))
            axes.axhline(0, color="#555555", linewidth=0.8, linestyle="-")
            what = "Drive force" if kind == "force" else "Drive torque"
            finish(axes, f"{what} at {reading.drives[n]}", reading.units.label(kind))
    _abscissa(reading, rows[-1])
    return figure


def frequency_figure(reading: SpatialReading) -> Figure:
    """Draw the natural frequencies over the cycle, held in place by the drives."""
    figure, (axes,) = empty_figure(height=4.8)
    _abscissa(reading, axes)
    with mpl.rc_context(STYLE):
        frequency = reading.values("frequency", "mode")[:, :MOST_MODES]
        for n, values in enumerate(frequency.T, 1):
            axes.plot(*_history(reading, values), label=f"mode {n}")
        axes.set_ylim(0, 1.05 * float(frequency.max()))
        finish(axes, "Natural frequencies, held in place by the drives", "Hz")
    return figure


def view_figure(reading: SpatialReading) -> Figure:
    """Draw the bent linkage where its stress is largest, along Z, Y and X and obliquely, dashed where it is rigid."""
    k, times = reading.peak_position, reading.magnify
    peak = reading.peak(reading.stress) if reading.members else None
    said = f"{reading.scene.name} {reading.when(k)}"
    said += f", deflection \N{MULTIPLICATION SIGN} {times:g}" if reading.members else ""
    paths, rigid, pins = reading.paths(times)[k], reading.paths(0.0)[k], reading.joint_points(times)[k]
    ground = np.array([*reading.scene.ground.points.values()]).reshape(-1, 3)
    places = np.concatenate([part.reshape(-1, 3) for part in (paths, rigid, pins, ground)])
    views = four_views(said, places)
    most, lines = float(reading.stress.max(initial=0.0)), None
    with mpl.rc_context(STYLE):
        for view, axes in views.items():
            for i in range(len(paths)):
                draw_path(axes, view, rigid[i, [0, -1]], color=SHADE, linewidth=1.0, linestyle="--")
                lines = draw_coloured(axes, view, paths[i], reading.stress[k, i], most, PALETTE)
            for bar in reading.bars:
                draw_path(axes, view, pins.reshape(-1, 3)[bar], color=SHADE, linewidth=4)
            for pair in pins:
                draw_path(axes, view, pair, color=SHADE, linewidth=1.2)
            kinds = [reading.scene.joints[name].kind for name in reading.joints]
            draw_joints(axes, view, pins[:, 1], kinds, reading.joints)
            if peak is not None:
                draw_path(
                    axes, view, paths[peak[1], peak[2]][None], marker="o", ms=13, mfc="none", mec="#0072B2", mew=2
                )
        draw_axes_cross(views["oblique"])
        if lines is not None:
            label = f"von Mises stress ({reading.units.label('stress')})"
            figure_in(views["XY"]).colorbar(lines, ax=[*views.values()], label=label, shrink=0.7, aspect=34, pad=0.02)
    return figure_in(views["XY"])


Has = Callable[[SpatialReading], bool]
SPATIAL_FIGURES: dict[str, tuple[Has, Callable[[SpatialReading], Figure]]] = {
    "stress": (lambda reading: bool(reading.members), stress_figure),
    "section_moments": (lambda reading: bool(reading.members), moment_figure),
    "deflection": (lambda reading: bool(reading.members), deflection_figure),
    "joint_forces": (lambda reading: reading.moves and bool(reading.joints), force_figure),
    "drive_torque": (lambda reading: reading.moves and bool(reading.drives), drive_figure),
    "frequencies": (lambda reading: reading.moves and "frequency" in reading.data, frequency_figure),
    "views": (lambda reading: True, view_figure),
}
