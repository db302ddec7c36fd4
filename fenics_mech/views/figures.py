"""What all figures share: colours and style, axes over the drive angle, legends, and how a file is written."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullFormatter
from PIL import Image

from fenics_mech._arrays import Array
from fenics_mech._files import write_whole
from fenics_mech.errors import ViewError
from fenics_mech.views.drawn_parts import one_turn

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")  # Okabe and Ito
STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 10,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titley": 1.0,  # no search for a place above the axes, at every draw
    "axes.edgecolor": "#555555",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.prop_cycle": cycler(linestyle=["-", ":", "-."]) * cycler(color=COLOURS),
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "xtick.labelcolor": "black",
    "ytick.labelcolor": "black",
    "svg.fonttype": "none",
    "text.hinting": "none",  # letters at their true places, in two thirds of the time
}
SIZE = (7.2, 4.0)  # inches
RESOLUTION = 160  # dots per inch
ENDINGS = (".png", ".pdf", ".svg")
LEGEND_COLUMNS = 5
LETTER, HANDLE = 10.0, 86.0  # widths in a legend (pixels), of a letter and of what stands about a name


def empty_figure(
    rows: int = 1, height: float = SIZE[1], columns: int = 1, grid: dict[str, Any] | None = None, shared: bool = True
) -> tuple[Figure, Any]:
    """Make a figure with axes below one another, on a canvas that needs no display."""
    # The axes are a list, or where there are more columns a list of each row. Those of a column may share their
    # abscissa.
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(SIZE[0], height), layout="constrained", dpi=RESOLUTION)
        FigureCanvasAgg(figure)
        panels = figure.subplots(rows, columns, sharex="col" if shared else False, squeeze=False, gridspec_kw=grid)
        for axes in panels.flat:
            axes.spines["left"].set_in_layout(False)  # it would ask for all ticks again, and labels reach farther
        for axes in panels[-1]:
            axes.spines["bottom"].set_in_layout(False)
        return figure, panels.tolist() if columns > 1 else list(panels[:, 0])


def figure_of(count: int, most: int, above: float, ratio: float = 1.0, least: float = 0.0) -> tuple[Figure, list[Axes]]:
    """Make a figure of panels, as tall as a share of their width, or at least so tall, and room above (inches)."""
    columns = min(most, count)
    rows = -(-count // columns)
    figure, panels = empty_figure(rows, above + max(SIZE[0] / columns * rows * ratio, least), columns, shared=False)
    flat = [axes for row in panels for axes in row] if columns > 1 else list(panels)
    for axes in flat[count:]:
        axes.set_axis_off()
    return figure, flat[:count]


def new_figure(rows: int = 1, height: float = SIZE[1]) -> tuple[Figure, Sequence[Axes]]:
    """Make a figure with axes over the drive angle."""
    figure, axes = empty_figure(rows, height)
    angle_axis(axes[-1])
    return figure, axes


def angle_axis(axes: Axes) -> None:
    """Name the axis of the drive angle, from 0 to 360 degrees."""
    axes.set_xlabel("drive angle (deg)")
    axes.set_xlim(0, 360)
    axes.xaxis.set_major_locator(FixedLocator(range(0, 361, 45)))


def figure_in(axes: Axes) -> Figure:
    """Give the figure of axes."""
    figure = axes.figure
    assert isinstance(figure, Figure)
    return figure


def new_axes(height: float = SIZE[1]) -> Axes:
    """Make axes in a figure of their own, which is ``axes.figure``."""
    return empty_figure(height=height)[1][0]


@contextmanager
def panels_of(rows: int, columns: int, size: tuple[float, float], title: str) -> Iterator[tuple[Figure, Any]]:
    """Make a figure of panels that share their axes; when they are drawn, it gets a title and one legend below."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=size, layout="constrained", dpi=RESOLUTION)
        FigureCanvasAgg(figure)
        panels = figure.subplots(rows, columns, sharey="row", sharex="col", squeeze=False)
        yield figure, panels
        handles = {label: handle for axes in panels[0] for handle, label in zip(*axes.get_legend_handles_labels())}
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3, fontsize=8)
        figure.suptitle(title, x=0.01, ha="left", fontsize=11, fontweight="bold")


def curve(theta: Array, values: Array) -> tuple[Array, Array]:
    """Drive angle in degrees and values, over the whole turn."""
    angle, values = one_turn(theta, values)
    return np.degrees(angle), values


def with_unit(data: xr.Dataset, name: str) -> str:
    """Name of a coordinate with its unit, if it has one."""
    unit = data[name].attrs["units"]
    return name if unit == "1" else f"{name} ({unit})"


def finish(axes: Axes, title: str, ylabel: str, columns: int = LEGEND_COLUMNS) -> None:
    """Set title and label, and the legend as rows between the title and the axes, in as many columns as fit."""
    with mpl.rc_context(STYLE):
        names = axes.get_legend_handles_labels()[1]
        columns = min(columns, max(1, int(axes.bbox.width / (LETTER * max(map(len, names), default=0) + HANDLE))))
        rows = -(-len(names) // columns) if len(names) > 1 or title.startswith("Strain") else 0
        axes.set_title(title, pad=8 + 15 * rows)
        axes.set_ylabel(ylabel)
        if rows:
            axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=columns, borderaxespad=0.2)


def refuse_ending(path: Path) -> None:
    """Raise `ViewError` where a file is not of a kind that figures are written to."""
    if path.suffix.lower() not in ENDINGS:
        raise ViewError(f"{path}: a plot's file must end in one of {', '.join(ENDINGS)}, not in {path.suffix!r}")


def save(figure: Figure, path: str | Path) -> Path:
    """Write a figure; the file appears whole or not at all."""
    refuse_ending(path := Path(path))
    try:
        _laid_out_and_written(figure, path)
    except RuntimeError as error:
        raise ViewError(f"{path}: Matplotlib cannot draw it: {error}") from error
    return path


def _laid_out_and_written(figure: Figure, path: Path) -> None:
    with mpl.rc_context(STYLE):
        for axes in figure.axes:
            for axis in (axes.xaxis, axes.yaxis):
                if not axis.get_label_text():  # Matplotlib asks for all ticks to place a label without text
                    axis.set_label_coords(0.5, 0.0)
        if engine := figure.get_layout_engine():
            engine.execute(figure)
            figure.set_layout_engine(None)
        write_whole(path, lambda temporary: _write(figure, temporary))


def save_all(figures: Mapping[str, Figure], folder: str | Path, begin: str = "", ending: str = ".png") -> list[Path]:
    """Write figures into a folder, each by its name, which may have a common beginning."""
    return [save(figure, Path(folder) / f"{begin}{name}{ending}") for name, figure in figures.items()]


def _write(figure: Figure, path: Path) -> None:
    """Write a figure; as PNG without transparency and quickly compressed, which takes half the time of `savefig`."""
    if path.suffix.lower() != ".png":
        figure.savefig(path)
        return
    canvas = figure.canvas
    assert isinstance(canvas, FigureCanvasAgg)  # that of the layout, which has measured the texts
    canvas.draw()
    picture = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    picture.save(path, dpi=(RESOLUTION, RESOLUTION), compress_level=3, compress_type=zlib.Z_RLE)


def logarithmic(axes: Axes, low: float, high: float) -> None:
    """Let the ordinate go by powers between two values, with plain numbers beside it."""
    axes.set_yscale("log")
    axes.set_ylim(low, high)
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 1.5, 2, 3, 4, 5, 7) if high / low < 30 else (1, 2, 5)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
