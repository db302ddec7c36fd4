"""Figures of a result, one a question, and their files."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path
from types import FunctionType
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import Affine2D

from fenics_mech._plugins import Plugin, plugins
from fenics_mech.errors import ViewError
from fenics_mech.recovery import Result
from fenics_mech.recovery.spatial_result import SpatialResult
from fenics_mech.views.figures import COLOURS, ENDINGS, SIZE, STYLE, empty_figure, figure_in, new_axes, save, save_all
from fenics_mech.views.frequency_views import plot_frequencies
from fenics_mech.views.motion_figures import (
    freedom_figure,
    freedom_spectrum_figure,
    growth_figure,
    law_figure,
    open_pins,
    orbit_figure,
    poincare_figure,
)
from fenics_mech.views.plots import (
    force_path_figure,
    path_points,
    plot_deflection,
    plot_drive,
    plot_joint_forces,
    plot_spectrum,
    plot_strain,
    plot_strain_map,
    point_path_figure,
    section_force_figure,
)
from fenics_mech.views.prefixes import labelled
from fenics_mech.views.reading import SECTION_FORCES, Peak, Reading, reading_of, reading_of_a_file, reading_of_members
from fenics_mech.views.space.plots import SPATIAL_FIGURES, spatial_plots

MOST_ROWS = 6  # of a figure, one a member: more do not fit a page
MOST_SPECTRA = 3
BESIDE = Affine2D().scale(0.18, 0.5).translate(1.07, 0.5)  # a member of length 1, in shares of the axes at its left
LEAST_ROW = 0.35  # of the longest member, as tall as the row of a short one is drawn


def plot_all(
    result: Result | SpatialResult, folder: str | Path, only: Collection[str] = (), ending: str = ".png"
) -> list[Path]:
    """Write all plots of a result into `folder`, which is made when it is not there.

    Parameters
    ----------
    result
        The result.
    folder
        Where to write.
    only
        Names of the plots that are made; without them all that the result has.
    ending
        Kind of the files: ".png", ".pdf" or ".svg".

    Returns
    -------
    list of Path
        The files, none where there is only one position: strains where they are largest, strains by angle and place,
        deflections, section forces along members, joint forces by size and by direction, paths of points, freedoms
        with their section, spectrum and disturbances where a scene asks for these. A periodic motion has the spectrum
        of the strains, and modes have their frequencies. Of a result in space: von Mises stress, section moments,
        deflections, joint forces, drive torque, frequencies, and views along Z, Y and X. Each place that was
        measured has a plot of its own.

    Raises
    ------
    SceneError
        When a file of measurements cannot be read.
    ViewError, ResultError
        When a name or an ending is not known, the folder cannot be made or a file cannot be written.

    Examples
    --------
    >>> result = fm.Result.load("out/result.nc")
    >>> [path.name for path in fm.plot_all(result, "out")][:2]
    ['strain.png', 'strain_map.png']
    """
    folder = Path(folder)
    of_packages = {plugin.name: (lambda result: True, _drawing(plugin)) for plugin in plugins("views")}
    own = {} if isinstance(result, SpatialResult) else FIGURES | of_packages
    known = own or SPATIAL_FIGURES
    if unknown := sorted(set(only) - set(known)):
        raise ViewError(f"there is no plot {unknown[0]!r}; there are {', '.join(known)}")
    if ending not in ENDINGS:
        raise ViewError(f"a plot's file must end in one of {', '.join(ENDINGS)}, not in {ending!r}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ViewError(f"{folder}: cannot make the folder: {error.strerror}") from error
    if isinstance(result, SpatialResult):
        with reading_of_a_file():
            return spatial_plots(result, folder, only, ending)
    if result.data.sizes["theta"] == 1:
        return []
    with reading_of_a_file():
        chosen = {name: build for name, (has, build) in own.items() if has(result) and (not only or name in only)}
        drawn = {name: figure for name, build in chosen.items() if (figure := build(result)) is not None}
        if result.case:
            text = f"load case {result.case}" + (", which governs" if result.cases else "")
            for figure in drawn.values():
                figure.text(0.995, 0.003, text, ha="right", va="bottom", fontsize=8, color="#555555")
        paths = save_all(drawn, folder, ending=ending)
    for member, s, fibre in sorted({(m.member, m.s, m.fibre) for m in result.scene.measurements} if not only else ()):
        name = f"strain_{member}_s{s:g}_{'plus' if fibre == '+' else 'minus'}"
        paths.append(save(figure_in(plot_strain(result, member, s=s, fibre=fibre)), folder / f"{name}{ending}"))
    return paths


def strain_figure(result: Result) -> Figure:
    """Draw the strain of each member where its stress is largest, the most strained on top, and where on it that is."""
    reading = reading_of_members(result)
    size = np.abs([reading.strain[peak] for peak in reading.peaks])
    ranked = [int(i) for i in np.argsort(-size, kind="stable")][:MOST_ROWS]
    with mpl.rc_context(STYLE):
        figure, rows = empty_figure(len(ranked), 0.9 + 1.75 * len(ranked))
    for axes, i in zip(rows, ranked):
        plot_strain(result, reading.members[i], axes)
        if axes is not rows[-1]:
            axes.set_xlabel("")
        if axes is not rows[0] and (legend := axes.get_legend()):
            legend.remove()
            with mpl.rc_context(STYLE):
                axes.set_title(axes.get_title("left"), pad=8)
        axes.margins(y=0.18)
        _draw_place(axes, reading, reading.peaks[i], float(size[i] / (size.max() or 1.0)))
    _tell_left_out(figure, reading)
    return figure


def _tell_left_out(figure: Figure, reading: Reading) -> None:
    """Say how many members are not drawn."""
    if (more := len(reading.members) - MOST_ROWS) > 0:
        text = f"The {MOST_ROWS} members with the largest values; {more} more have smaller ones."
        figure.supxlabel(text, x=0.01, ha="left", fontsize=8, color="#555555")


def _draw_place(axes: Axes, reading: Reading, peak: Peak, share: float) -> None:
    """Draw a member beside axes with its ends' names, and the place and side of its peak."""
    beside: dict[str, Any] = {"transform": BESIDE + axes.transAxes, "clip_on": False}
    axes.fill_between([0, 1], -0.13, 0.13, color="#e4e8ec", edgecolor="#777777", linewidth=1, **beside)
    look: dict[str, Any] = {"linestyle": "none", "marker": "o", "markeredgecolor": "black", **beside}
    axes.plot([0, 1], [0, 0], markersize=6, markerfacecolor="white", **look)
    for at, name in zip((0, 1), reading.ends[peak.i]):
        axes.text(at, -0.4, name, ha="center", va="top", weight="bold", fontsize=9, **beside)
    side = 0.13 if reading.fibres[peak.f] == "+" else -0.13
    ring: dict[str, Any] = {"markersize": 10, "markerfacecolor": "none", "markeredgewidth": 2}
    axes.plot(reading.s[peak.j], side, **look | ring | {"markeredgecolor": COLOURS[1]})
    axes.text(0.5, 0.4, f"{share:.0%} of the largest", ha="center", fontsize=8, color="#555555", **beside)


def map_figure(result: Result) -> Figure:
    """Draw the strain by drive angle and place, a row for each member, as tall as it is long, on one scale."""
    reading = reading_of_members(result)
    shown = sorted(reading.ranked[:MOST_ROWS])
    tall = np.maximum(reading.lengths, LEAST_ROW * reading.lengths.max())[shown]
    height = 1.0 + 0.35 * len(shown) + 1.5 * float(tall.sum() / tall.max())
    figure, panels = empty_figure(len(shown), height, grid={"height_ratios": tall})
    for axes, i in zip(panels, shown):
        plot_strain_map(result, reading.members[i], axes)
        if axes is not panels[-1]:
            axes.set_xlabel("")
    label = f"{labelled(reading.units, 'strain')}: blue compression, red tension"
    bar = figure.colorbar(panels[0].images[0], ax=panels, label=label, shrink=0.9, aspect=34, pad=0.02)
    bar.outline.set_visible(False)
    _tell_left_out(figure, reading)
    return figure


def force_figure(result: Result) -> Figure:
    """Draw the joint forces, and below them the torque or force of the first drive where there is one."""
    driven = reading_of(result).effort is not None
    figure, panels = empty_figure(rows=1 + driven, height=5.8 if driven else SIZE[1])
    plot_joint_forces(result, panels[0])
    if driven:
        plot_drive(result, panels[1])
        panels[0].set_xlabel("")
    return figure


def spectrum_figure(result: Result) -> Figure:
    """Draw the harmonics of the members that are strained most."""
    reading = reading_of_members(result)
    size = np.abs(reading.strain).max(axis=(0, 2, 3))
    shown = sorted(int(i) for i in np.argsort(-size, kind="stable")[:MOST_SPECTRA])
    figure, panels = empty_figure(rows=len(shown), height=1.2 + 2.1 * len(shown))
    limits = np.zeros(len(shown))
    for n, (axes, i) in enumerate(zip(panels, shown)):
        limits[n] = plot_spectrum(result, reading.members[i], axes).get_xlim()[1]
        if axes is not panels[-1]:
            axes.set_xlabel("")
    panels[0].set_xlim(0.4, limits.max())  # shared by all
    return figure


def _bends(result: Result) -> bool:
    """Whether a link bends."""
    return bool(result.scene.members())


def _drawing(plugin: Plugin) -> Callable[[Result], Figure | None]:
    """Give what draws a plot of another package, whose errors name it."""
    draw: Callable[[Result], Figure | None] = plugin.load(FunctionType)
    if plugin.name in FIGURES:
        raise plugin.refused("has the name of a plot of the program itself")

    def drawn(result: Result) -> Figure | None:
        with mpl.rc_context(STYLE):
            figure = plugin.blamed(draw)(result)
        if not isinstance(figure, Figure | None):
            raise plugin.refused(f"gives {type(figure).__name__} where a Figure of matplotlib or None is expected")
        if figure is not None:
            FigureCanvasAgg(figure)
        return figure

    return drawn


Build = tuple[Callable[[Result], bool], Callable[[Result], Figure | None]]
FIGURES: dict[str, Build] = {
    "strain": (_bends, strain_figure),
    "strain_map": (_bends, map_figure),
    "deflection": (_bends, lambda result: figure_in(plot_deflection(result))),
    "section_forces": (lambda result: _bends(result) and set(SECTION_FORCES) <= set(result.data), section_force_figure),
    "joint_forces": (lambda result: bool(result.data.sizes["joint"]), force_figure),
    "force_paths": (lambda result: bool(result.data.sizes["joint"]), force_path_figure),
    "point_paths": (lambda result: bool(path_points(result)), point_path_figure),
    "joint_laws": (lambda result: "law_effort" in result.data, law_figure),
    "pin_orbits": (lambda result: bool(open_pins(result)), orbit_figure),
    "freedoms": (lambda result: "freedom_place" in result.data, freedom_figure),
    "freedom_spectrum": (
        lambda result: "lyapunov_exponent" in result.data or "section_place" in result.data,
        freedom_spectrum_figure,
    ),
    "poincare": (lambda result: bool(result.data.sizes.get("section_point")), poincare_figure),
    "disturbances": (lambda result: "disturbance_growth" in result.data, growth_figure),
    "spectrum": (lambda result: "strain_amplitude" in result.data, spectrum_figure),
    "frequencies": (
        lambda result: "frequency" in result.data,
        lambda result: figure_in(plot_frequencies(result, new_axes(height=4.8))),
    ),
}
