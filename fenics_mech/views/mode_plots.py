"""Mode shapes of a mechanism at a drive angle: how it bends in each, with the natural frequency."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from fenics_mech._constants import MILLI, TURN
from fenics_mech._files import write_whole
from fenics_mech.errors import ViewError
from fenics_mech.kinematics import solve_motion
from fenics_mech.recovery.rigid_places import ends_in
from fenics_mech.studies.natural_frequencies import NaturalFrequencies
from fenics_mech.views.drawn_parts import RIGID
from fenics_mech.views.figures import COLOURS, SIZE, empty_figure, finish
from fenics_mech.views.skeleton import Skeleton, frame, height_for
from fenics_mech.views.words import short

LARGEST = 0.1  # of the linkage's size, as the largest displacement of a mode is drawn
MOST = 6  # modes in one figure
COLUMNS = 2
MOVING, PERIOD = 100, 1200  # dots per inch of moving pictures, and milliseconds of a period


def animate_modes(found: NaturalFrequencies, path: str | Path, angle: float = 0.0, frames: int = 24) -> Path:
    """Draw the mechanism as it swings in each of its lowest modes at a drive angle, all in the same time.

    Parameters
    ----------
    found
        Natural frequencies and mode shapes.
    path
        File to write, ending in .gif.
    angle
        Drive angle (rad); the nearest position is drawn.
    frames
        Number of pictures in a period.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ViewError
        When the file's ending is not .gif, or there are no mode shapes of members.
    ResultError
        When the file cannot be written.

    Examples
    --------
    >>> found = fm.modes(fm.load("demos/four_bar.toml").changed({"analysis.sub_intervals": 12}))
    >>> fm.animate_modes(found, "modes.gif", frames=2).name
    'modes.gif'
    """
    path = Path(path)
    if path.suffix.lower() != ".gif":
        raise ViewError(f"{path}: moving mode shapes are a .gif, not a {path.suffix!r}")
    swings = np.cos(TURN * np.arange(frames) / frames)
    first, *rest = (_picture(plot_mode_shapes(found, angle, float(swing))) for swing in swings)
    options: dict[str, Any] = {"save_all": True, "append_images": rest, "duration": PERIOD / frames, "loop": 0}
    write_whole(path, lambda temporary: first.save(temporary, format="GIF", **options))
    return path


def _picture(figure: Figure) -> Image.Image:
    """Give a figure as a picture of 256 colours."""
    canvas = figure.canvas
    assert isinstance(canvas, FigureCanvasAgg)
    figure.set_dpi(MOVING)
    canvas.draw()
    return Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB").quantize(256)


def plot_mode_shapes(found: NaturalFrequencies, angle: float = 0.0, swing: float = 1.0) -> Figure:
    """Draw the bent mechanism in each of its lowest modes at a drive angle, with the natural frequency.

    Displacements are drawn on one side of the rest; half a period later they are on the other.

    Parameters
    ----------
    found
        Natural frequencies and mode shapes.
    angle
        Drive angle (rad); the nearest position is drawn.
    swing
        Displacement over its largest in a period, -1 to 1.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, a panel for each mode, at most six.

    Raises
    ------
    ViewError
        When the natural frequencies are of an older version, without shapes, or no link bends.

    Examples
    --------
    >>> found = fm.modes(fm.load("demos/four_bar.toml").changed({"analysis.sub_intervals": 12}))
    >>> figure = fm.plot_mode_shapes(found, angle=0.5)
    >>> figure.axes[0].get_title("left")
    'Mode 1, 50.5 Hz'
    """
    data = found.data
    if "shape" not in data or not data.sizes["member"]:
        raise ViewError("there are no mode shapes of members to draw: solve for the modes of a scene whose links bend")
    away = np.remainder(data["theta"].to_numpy() - angle + TURN / 2, TURN) - TURN / 2
    here = data.isel(theta=int(np.abs(away).argmin()))
    shapes = here["shape"].transpose("mode", "member", "s", "component").to_numpy()[:MOST]
    rest = skeleton_at(found, float(here["theta"]))
    drawn, most, other = (
        [replace(rest, path=rest.path + share * LARGEST * rest.extent * shape) for shape in shapes]
        for share in (swing, 1.0, -1.0)
    )
    points = np.concatenate([rest.points, *(bent.points for bent in (*most, *other))])
    rows = -(-len(drawn) // COLUMNS)
    figure, panels = empty_figure(rows, 0.4 + rows * height_for(points, SIZE[0] / COLUMNS), columns=COLUMNS)
    every = [axes for row in panels for axes in row]
    for axes in every:
        axes.set_axis_off()
    for axes, bent, mode, frequency in zip(every, drawn, here["mode"].to_numpy(), here["frequency"].to_numpy()):
        for line in rest.path:
            axes.plot(*(MILLI * line).T, color=RIGID, linewidth=1.0, linestyle="--")
        bent.draw(axes, COLOURS[0])
        frame(axes, points)
        said = f"{short(float(frequency))} Hz" if frequency else "0 Hz, rigid body"
        finish(axes, f"Mode {mode}, {said}", "")
    degrees = np.degrees(float(here["theta"])) % 360
    title = f"{found.scene.name}: mode shapes at drive angle {degrees:.4g}\N{DEGREE SIGN}"
    figure.suptitle(title, x=0.01, ha="left", fontsize=11, fontweight="bold")
    return figure


def skeleton_at(found: NaturalFrequencies, theta: float) -> Skeleton:
    """Give the mechanism at a drive angle (rad), its members straight, with the places of the mode shapes."""
    scene = found.scene
    motion, s = solve_motion(scene, np.array([theta])), found.data["s"].to_numpy()[:, None]
    first, second = np.moveaxis(ends_in(scene, motion)[0], 1, 0)[:, :, None]
    path = (1 - s) * first + s * second
    return Skeleton(scene, motion, path, float(np.linalg.norm(np.ptp(path.reshape(-1, 2), axis=0))))
