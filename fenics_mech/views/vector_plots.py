"""Plots of vectors over the motion: forces as the path of the arrow's tip, and the paths of points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fenics_mech._arrays import Array
from fenics_mech._constants import ROUNDING
from fenics_mech.errors import ViewError
from fenics_mech.recovery import Result
from fenics_mech.recovery.peaks import smoothed
from fenics_mech.views.figures import COLOURS, SIZE, empty_figure, figure_in, finish, new_axes
from fenics_mech.views.plot_marks import RING
from fenics_mech.views.reading import ForceReading, reading_of
from fenics_mech.views.words import DEGREE, short

TICKS = 45  # degrees of the drive between two dots
COLUMNS, MOST_JOINTS = 3, 9  # of a figure
MOST_PATHS = 7  # as many as there are colours
HEIGHT = 5.4  # inches
SEEN = 0.002  # of the largest path, by which two curves must be apart to be seen


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
    axes, reading = axes or new_axes(HEIGHT), reading_of(result)
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
    axes, reading = axes or new_axes(HEIGHT), reading_of(result)
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
    rows = -(-len(joints) // COLUMNS)
    columns = min(COLUMNS, len(joints))
    figure, panels = empty_figure(rows, 0.4 + SIZE[0] / columns * rows, columns, shared=False)
    flat = [axes for row in panels for axes in row] if columns > 1 else list(panels)
    for axes in flat[len(joints) :]:
        axes.set_axis_off()
    for n, (axes, joint) in enumerate(zip(flat, joints)):
        plot_force_path(result, joint, axes)
        title = axes.get_title("left").replace(", at most", "\nat most")
        title = "\nat ".join(title.rsplit(" at ", 1)) if reading.in_time else title
        axes.set_title(title, fontsize=9, loc="left")
        if n % columns:
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
