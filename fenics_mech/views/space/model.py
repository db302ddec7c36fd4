"""The drawing of a scene in space as it is stated: links, joints with their axes, ups, loads, and their names."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from fenics_mech._arrays import Array
from fenics_mech._constants import MILLI
from fenics_mech.scene.in_space import SpatialForce, SpatialScene
from fenics_mech.views.figures import COLOURS, STYLE, figure_in
from fenics_mech.views.labels import Labels
from fenics_mech.views.space.skeleton import SHADE, draw_axes_cross, draw_joints, draw_path, four_views, seen
from fenics_mech.views.tables import drive_of
from fenics_mech.views.words import short

AXIS, UP, ARROW = 0.09, 0.07, 0.2  # lengths over the scene's size: half an axis, an up, a load
LOOKS: dict[str, dict[str, Any]] = {
    "member": {"color": "#56606b", "linewidth": 4},
    "rigid link": {"color": "#b4bbc3", "linewidth": 4},
    "joint's axis": {"color": "#222222", "linewidth": 1.0, "linestyle": "-."},
    "up of a section": {"color": COLOURS[2], "linewidth": 1.6},
    "load": {"color": COLOURS[1], "linewidth": 1.8},
    "spring": {"color": COLOURS[5], "linewidth": 1.8, "linestyle": "--"},
    "damper": {"color": COLOURS[3], "linewidth": 1.8, "linestyle": ":"},
    "gravity": {"color": "#777777", "linewidth": 1.8},
    "mass": {"color": COLOURS[4], "marker": "o", "markersize": 9},
    "ground": {"color": SHADE, "marker": "^", "markersize": 13},
}
LINKS = {"member": "italic", "rigid link": "italic"}  # styles of their names
JOINT: dict[str, Any] = {"color": "#222222", "fontsize": 10, "weight": "bold"}
ALONG = np.array([0.5, 0.35, 0.65])[:, None]  # of a link, where its name may stand
POINTED = "load", "up of a section", "gravity"  # kinds that are arrows


@dataclass(frozen=True)
class Stroke:
    """A line or a point of the drawing ``(points, 3)`` (m), and what is written at its end."""

    kind: str
    path: Array
    name: str = ""


def spatial_scene_plot(scene: SpatialScene, axes: Axes | None = None) -> Axes:
    """Draw the model as stated, in mm: along Z, Y and X and obliquely, or in given axes obliquely alone."""
    strokes = list(_strokes(scene))
    places = np.concatenate([stroke.path for stroke in strokes])
    title = f"{scene.name}, {drive_of(scene)}" if scene.drives else f"{scene.name}, as drawn"
    views = four_views(title, places) if axes is None else {"oblique": axes}
    with mpl.rc_context(STYLE):
        for view, panel in views.items():
            for stroke in strokes:
                _draw(panel, view, stroke)
            places = np.array([scene.point(joint.connect[1])[1] for joint in scene.joints.values()])
            kinds = [joint.kind for joint in scene.joints.values()]
            draw_joints(panel, view, places, kinds, () if view == "oblique" else [*scene.joints])
        _write_names(scene, strokes, views["oblique"])
        draw_axes_cross(views["oblique"])
        shown = dict.fromkeys(stroke.kind for stroke in strokes)
        marks: dict[str, Any] = {"linestyle": "", "markeredgecolor": "#222222"}
        looks = {kind: LOOKS[kind] | (marks if "marker" in LOOKS[kind] else {}) for kind in shown}
        handles = [Line2D([], [], label=kind, **look) for kind, look in looks.items()]
        if axes is None:
            figure_in(views["XY"]).legend(handles=handles, loc="outside lower left", ncols=5)
        else:
            axes.legend(handles=handles)
            axes.set_aspect("equal")
            axes.set_title(title)
    return views["oblique"]


def _draw(axes: Axes, view: str, stroke: Stroke) -> None:
    """Draw a line, an arrow or a mark, and in the oblique view its name."""
    look, flat = LOOKS[stroke.kind], seen(view, stroke.path)
    if stroke.kind in POINTED:
        style = {
            "arrowstyle": "-|>",
            "color": look["color"],
            "linewidth": look["linewidth"],
            "shrinkA": 0,
            "shrinkB": 0,
        }
        axes.annotate("", flat[-1], flat[0], arrowprops=style)
    else:
        draw_path(axes, view, stroke.path, zorder=1.5 if stroke.kind == "ground" else 2, **look)


def _write_names(scene: SpatialScene, strokes: list[Stroke], axes: Axes) -> None:
    """Write the names of joints, links and what acts into the oblique view, the first where most room is."""
    flat = {id(stroke): seen("oblique", stroke.path) for stroke in strokes}
    labels = Labels(axes, np.concatenate([np.stack([one[:-1], one[1:]], axis=1) for one in flat.values()]))
    for name, joint in scene.joints.items():
        labels.add(name, seen("oblique", np.array([scene.point(joint.connect[1])[1]])), 7, JOINT)
    for stroke in sorted(strokes, key=lambda one: one.kind in LINKS, reverse=True):
        ends = flat[id(stroke)][[0, -1]]
        places = ends[0] + ALONG * (ends[1] - ends[0]) if stroke.kind in LINKS else ends[:1]
        look = {"color": LOOKS[stroke.kind]["color"], "fontsize": 9, "style": LINKS.get(stroke.kind, "normal")}
        if stroke.name:
            labels.add(stroke.name, places, 4, look)


def _strokes(scene: SpatialScene) -> Iterator[Stroke]:
    """All that is drawn: the ground, links with their ups, axes, and what acts."""
    size = scene.size
    for place in scene.ground.points.values():
        yield Stroke("ground", np.array([place]))
    for name, link in scene.links.items():
        if link.rigid is not None:
            points = np.array([*link.points.values(), *([link.rigid.centre] if len(link.points) == 1 else [])])
            yield Stroke("rigid link", points if len(points) < 3 else np.concatenate([points, points[:1]]), name)
    for label, (name, member) in scene.members().items():
        first, last = (np.array(scene.links[name].points[end]) for end in member.ends)
        yield Stroke("member", np.array([first, last]), label)
        if member.up is not None:
            along = (last - first) / np.linalg.norm(last - first)
            up = np.array(member.up) - along * (along @ member.up)
            middle = (first + last) / 2
            yield Stroke("up of a section", np.array([middle, middle + UP * size * up / np.linalg.norm(up)]))
    for joint in scene.joints.values():
        both = [np.array(scene.point(point)[1]) for point in joint.connect]
        for way in filter(None, (joint.axis, *(joint.axes or ()))):
            half = AXIS * size * np.array(way) / np.linalg.norm(way)
            yield Stroke("joint's axis", np.array([both[0] - half, both[0], both[1], both[1] + half]))
    yield from _acting(scene, size)


def _acting(scene: SpatialScene, size: float) -> Iterator[Stroke]:
    """Loads, springs, dampers, masses and gravity, with their names."""
    for name, mass in scene.masses.items():
        yield Stroke("mass", _at(scene, mass.at)[None], f"{name} {short(MILLI * mass.mass)} g")
    for name, load in scene.loads.items():
        if isinstance(load, SpatialForce):
            way, tip, said = np.array(load.force), _at(scene, load.at), f"{short(float(np.linalg.norm(load.force)))} N"
        else:
            joint = scene.joints[load.joint]
            way, tip = (load.push or load.torque) * np.array(joint.axis), np.array(scene.point(joint.connect[1])[1])
            said = f"{short(load.push)} N" if load.push else f"{short(load.torque)} N m"
        if any(way):
            yield Stroke("load", np.array([tip - ARROW * size * way / np.linalg.norm(way), tip]), f"{name} {said}")
    for kind, parts in (("spring", scene.springs), ("damper", scene.dampers)):
        for name, part in parts.items():
            if hasattr(part, "between"):
                yield Stroke(kind, np.array([_at(scene, point) for point in part.between]), name)
            else:
                at = scene.joints[part.joint].connect[1] if hasattr(part, "joint") else part.at
                yield Stroke(kind, _at(scene, at) - [[0, 0, 0], [0, 0, UP * size]], name)
    if any(scene.gravity):
        places = [scene.ground.points, *(link.points for link in scene.links.values())]
        corner = np.max([place for points in places for place in points.values()], axis=0)
        way = np.array(scene.gravity) / np.linalg.norm(scene.gravity)
        yield Stroke("gravity", np.array([corner, corner + ARROW * size * way]), "gravity")


def _at(scene: SpatialScene, at: str) -> Array:
    """Place of a point "link.point", or of one along a member "member@s", in the drawn position (m)."""
    if "@" not in at:
        return np.array(scene.point(at)[1])
    label, s = at.split("@")
    link, member = scene.members()[label]
    first, last = (np.array(scene.links[link].points[end]) for end in member.ends)
    return np.asarray(first + float(s) * (last - first))
