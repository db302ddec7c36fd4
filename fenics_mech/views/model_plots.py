"""The model of a scene at its start: links, joints, supports, and all that acts on them, with their names."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from fenics_mech._constants import MILLI
from fenics_mech.scene import Scene
from fenics_mech.scene.in_space import SpatialScene
from fenics_mech.views.acting_drawings import LOOKS, ActingDrawing
from fenics_mech.views.figures import SIZE, finish, new_axes
from fenics_mech.views.labels import Labels
from fenics_mech.views.skeleton import PIN, PINS, Skeleton, frame, height_for, kinds_of
from fenics_mech.views.space.model import spatial_scene_plot
from fenics_mech.views.symbols import INK
from fenics_mech.views.tables import drive_of

LINK: dict[str, Any] = {"color": "#666666", "fontsize": 9, "style": "italic"}
JOINT: dict[str, Any] = {"color": INK, "fontsize": 10, "weight": "bold"}
ALONG = np.array([0.5, 0.35, 0.65])[:, None]  # of a member, where its link's name may stand
COLUMNS = 4  # of the legend


def plot_scene(scene: Scene | SpatialScene, axes: Axes | None = None) -> Axes:
    """Draw the model at its start, in mm: what is stated, where it is, and what it is called.

    An arrow ends where its force acts, and points as it is stated, whatever its factor is at the start. A scene in
    space is drawn along Z, Y and X and obliquely; the axes that are given, or returned, have the oblique view.

    Parameters
    ----------
    scene
        The scene.
    axes
        Where to draw; without them a figure is made.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    AssemblyError
        When the links cannot be assembled.

    Examples
    --------
    >>> axes = fm.plot_scene(fm.load("demos/four_bar.toml"))
    >>> [text.get_text() for text in axes.texts if text.get_weight() == "bold"]
    ['O', 'A', 'B', 'C']
    """
    if isinstance(scene, SpatialScene):
        return spatial_scene_plot(scene, axes)
    skeleton = Skeleton.at_start(scene)
    axes = axes or new_axes(height_for(skeleton.points, SIZE[0]))
    skeleton.draw(axes)
    acting = ActingDrawing(skeleton, axes)
    acting.add_all()
    frame(axes, np.concatenate([skeleton.points, *acting.lines]))
    if any(scene.gravity):
        acting.add_gravity(np.array(scene.gravity))
    _add_names(skeleton, acting, axes)
    for kind in kinds_of(scene.joints):
        axes.plot([], [], label=f"{kind} joint", **PIN | PINS[kind])
    for kind in acting.present:
        axes.plot([], [], label=kind, **LOOKS[kind])
    axes.set_xlabel("x (mm)")
    finish(axes, f"{scene.name}, {drive_of(scene)}", "y (mm)", columns=COLUMNS)
    return axes


def _add_names(skeleton: Skeleton, acting: ActingDrawing, axes: Axes) -> None:
    """Write the names of joints, links, and all that acts, in this order: the first have most room."""
    lines = [*skeleton.path[:, [0, -1]], *skeleton.bars, *skeleton.beside, *skeleton.strokes, *acting.lines]
    shapes = [*skeleton.blocks, *skeleton.triangles]
    lines += [side for shape in shapes for side in zip(shape, np.roll(shape, 1, axis=0))]
    labels = Labels(axes, MILLI * np.array(lines).reshape(-1, 2, 2))
    for name, pin in zip(skeleton.scene.joints, skeleton.pins):
        labels.add(name, MILLI * pin[None], 6, JOINT)
    for link in skeleton.scene.links:
        first, second = skeleton.side_of(link)
        labels.add(link, MILLI * (first + ALONG * (second - first)), 3, LINK)
    for text, place, look in acting.names:
        labels.add(text, MILLI * place[None], 6, look)
