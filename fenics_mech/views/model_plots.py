"""The mechanism as Matplotlib draws it: the model of a scene with all that acts on it, and its mode shapes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from PIL import Image

from fenics_mech._arrays import Array, turned
from fenics_mech._constants import MILLI, TURN
from fenics_mech._files import write_whole
from fenics_mech.errors import ViewError
from fenics_mech.kinematics import Motion
from fenics_mech.machine.linkage import solve_motion, start_motion
from fenics_mech.recovery.rigid_places import ends_in
from fenics_mech.scene import Ground, LineLoad, Link, Prismatic, Scene, Slot
from fenics_mech.scene.in_space import SpatialScene
from fenics_mech.scene.joints import Joint
from fenics_mech.scene.springs_dampers import Line
from fenics_mech.studies.natural_frequencies import NaturalFrequencies
from fenics_mech.views.drawn_parts import (
    ARROWS,
    BLOCK_CORNERS,
    DRAWN,
    INK,
    RIGID,
    SHADE,
    TRIANGLE,
    arc,
    coil,
    dashpot,
    ground_points,
    guide_strokes,
    guides_of,
    pin_places,
    rigid_bars,
    slider_angles,
    support_strokes,
)
from fenics_mech.views.figures import COLOURS, SIZE, empty_figure, finish, new_axes
from fenics_mech.views.labels import Labels
from fenics_mech.views.space.model import spatial_scene_plot
from fenics_mech.views.tables import drive_of
from fenics_mech.views.words import short

PINS: dict[str, dict[str, Any]] = {  # look of a joint of each kind
    "revolute": {"marker": "o", "markersize": 6, "markerfacecolor": "white"},
    "weld": {"marker": "s", "markersize": 6, "markerfacecolor": INK},
    "slot": {"marker": "o", "markersize": 4, "markerfacecolor": "white"},
    "prismatic": {"marker": "s", "markersize": 3.5, "markerfacecolor": "white"},
}
PIN: dict[str, Any] = {"linestyle": "none", "markeredgecolor": INK, "markeredgewidth": 1.2, "zorder": 4}
THICK: dict[str, Any] = {"linewidth": 3.0, "capstyle": "round"}
TEXT, HEIGHTS = 0.9, (2.8, 5.4)  # inches: above and below a drawing, and of a figure
GUIDE = 0.12  # of the extent, that a guide is longer on both sides than its slider's travel at least
LOOKS: dict[str, dict[str, Any]] = {  # of what acts, by its kind, which the legend names
    "point mass": {"linestyle": "none", "marker": "o", "markersize": 10, "color": INK, "alpha": 0.6},
    "load": {"linestyle": "-", "color": COLOURS[1]},
    "impulse": {"linestyle": ":", "color": COLOURS[1]},
    "spring": {"linestyle": "-", "color": COLOURS[2]},
    "damper": {"linestyle": "-", "color": COLOURS[3]},
    "drive": {"linestyle": "-", "color": COLOURS[0]},
    "freedom": {"linestyle": ":", "color": COLOURS[0]},
    "traced point": {"linestyle": "none", "marker": "x", "markersize": 6, "color": COLOURS[4]},
    "sense of gravity": {"linestyle": "-", "color": "#777777"},
}
FORCE, TURNING, SPREAD, SPRING, HINGE = 0.16, 0.07, 0.09, 0.018, 0.045  # sizes of symbols over the extent
FROM, TO = -0.35 * np.pi, 0.85 * np.pi  # rad, of the arc of an arrow that turns
LINK: dict[str, Any] = {"color": "#666666", "fontsize": 9, "style": "italic"}
JOINT: dict[str, Any] = {"color": INK, "fontsize": 10, "weight": "bold"}
ALONG = np.array([0.5, 0.35, 0.65])[:, None]  # of a member, where its link's name may stand
COLUMNS = 4  # of the legend
LARGEST = 0.1  # of the linkage's size, as the largest displacement of a mode is drawn
MOST_MODES = 6  # modes in one figure
MODE_COLUMNS = 2
MOVING, PERIOD = 100, 1200  # dots per inch of moving pictures, and milliseconds of a period


@dataclass(frozen=True)
class Skeleton:
    """A mechanism at one position."""

    scene: Scene  # the linkage
    motion: Motion  # the rigid position of its links, one angle
    path: Array  # centre lines of the members as drawn (m), ``(members, stations, 2)``
    extent: float  # size of the drawing (m), to which that of all symbols is in proportion

    @classmethod
    def at_start(cls, scene: Scene) -> Skeleton:
        """Give the mechanism at its start, its links straight."""
        motion = start_motion(scene)
        bodies: dict[str, Ground | Link] = {"ground": scene.ground, **scene.links}
        places = [scene.point(f"{body}.{point}") for body, part in bodies.items() for point in part.points]
        points = np.array([motion.of_point(*place)[0][0] for place in places])
        extent = float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0
        return cls(scene, motion, ends_in(scene, motion)[0], extent)

    def angle_of(self, body: str) -> float:
        """Angle of a link or the ground (rad)."""
        return 0.0 if body == "ground" else float(self.motion.angle[0, self.motion.links.index(body)])

    def side_of(self, link: str) -> tuple[Array, Array]:
        """Ends of a link's longest member, or of the line between its first two points (m), ``(2,)`` each."""
        paths = [path[[0, -1]] for path, (of, _) in zip(self.path, self.scene.members().values()) if of == link]
        if not paths:
            corners = list(self.scene.links[link].points.values())
            paths = [np.array([self.motion.of_point(link, corners[i])[0][0] for i in (0, min(1, len(corners) - 1))])]
        first, second = max(paths, key=lambda ends: float(np.linalg.norm(ends[1] - ends[0])))
        return first, second

    @cached_property
    def beside(self) -> Array:
        """Lines of the sections that are beside their members' axes, with arms at both ends (m), ``(lines, 2, 2)``."""
        lines = []
        for path, (_, member) in zip(self.path, self.scene.members().values()):
            along = path[-1] - path[0]
            normal = np.array([-along[1], along[0]]) / np.linalg.norm(along)
            moved = path + member.offset * normal
            if member.offset:
                lines += [moved[[0, -1]], *zip(path[[0, -1]], moved[[0, -1]])]
        return np.array(lines, dtype=float).reshape(-1, 2, 2)

    @cached_property
    def pins(self) -> Array:
        """Places of the joints (m), ``(joints, 2)``."""
        return pin_places(self.scene, self.motion, self.path[None])[0]

    @cached_property
    def bars(self) -> Array:
        """Sides of the rigid links (m), ``(sides, 2, 2)``."""
        return rigid_bars(self.scene, self.motion, self.pins[None])[0]

    @cached_property
    def rails(self) -> Array:
        """Guides on links that move (m), ``(guides, 2, 2)``; those along members are drawn as these."""
        lines = []
        for joint in self.scene.joints.values():
            if not isinstance(joint, Slot | Prismatic) or joint.member:
                continue
            body, pin = (self.motion.of_point(*self.scene.point(point))[0][0] for point in joint.connect)
            link = joint.connect[0].split(".")[0]
            if link != "ground":
                angle = self.angle_of(link) + self.scene.guide_angle(joint)
                along, more = np.array([np.cos(angle), np.sin(angle)]), GUIDE * self.extent
                travel = float((pin - body) @ along)
                lines.append([body + (min(travel, 0.0) - more) * along, body + (max(travel, 0.0) + more) * along])
        return np.array(lines, dtype=float).reshape(-1, 2, 2)

    @cached_property
    def supports(self) -> Array:
        """Points of the ground that pins go through (m), ``(points, 1, 2)``."""
        return ground_points(self.scene)[:, None]

    @property
    def triangles(self) -> Array:
        """Corners of the supports' triangles (m), ``(supports, 3, 2)``."""
        return np.asarray(self.supports + DRAWN.support * self.extent * TRIANGLE)

    @cached_property
    def strokes(self) -> Array:
        """Lines and hatches under supports and guides (m), ``(strokes, 2, 2)``."""
        guides = guides_of(self.scene, self.motion, GUIDE * self.extent)
        under = self.supports + DRAWN.support * self.extent * support_strokes().reshape(-1, 2)
        return np.concatenate([under.reshape(-1, 2, 2), *(guide_strokes(guide, self.extent) for guide in guides)])

    @cached_property
    def blocks(self) -> Array:
        """Corners of the sliders' blocks (m), ``(sliders, 4, 2)``."""
        where, angle = slider_angles(self.scene, self.motion)
        return self.pins[where][:, None] + DRAWN.block * self.extent * turned(BLOCK_CORNERS, angle[0][:, None])

    @property
    def points(self) -> Array:
        """Points that the drawing must show (m), ``(points, 2)``."""
        parts = (self.path, self.pins, self.bars, self.strokes, self.rails, self.beside)
        return np.concatenate([part.reshape(-1, 2) for part in parts])

    def draw(self, axes: Axes, colour: str = INK) -> None:
        """Draw it, in mm, with its members in a colour."""
        _lines(axes, self.strokes, color=INK, linewidth=0.8)
        _polygons(axes, self.triangles, zorder=0.5)
        _lines(axes, self.rails, color=INK, linewidth=1.2)
        _lines(axes, self.beside, color=colour, linewidth=1.2, linestyle="dashed")
        _lines(axes, self.bars, color=RIGID, zorder=2.5, **THICK)
        _lines(axes, self.path, color=colour, zorder=3, **THICK)
        _polygons(axes, self.blocks, zorder=3.5)
        for joint, (x, y) in zip(self.scene.joints.values(), MILLI * self.pins):
            axes.plot(x, y, **PIN | PINS[joint.kind])


def frame(axes: Axes, points: Array) -> None:
    """Let axes in mm show points (m) with a margin, on one scale in both directions."""
    # points: the points, ``(points, 2)``
    low, high = MILLI * points.min(axis=0), MILLI * points.max(axis=0)
    margin = DRAWN.margin * float(np.linalg.norm(high - low))
    low, high = low - margin, high + margin
    box = np.array([axes.bbox.width, axes.bbox.height])
    half = np.max((high - low) / box) * box / 2  # as much as the axes have room for
    axes.set_xlim(*((low[0] + high[0]) / 2 + half[0] * np.array([-1, 1])))
    axes.set_ylim(*((low[1] + high[1]) / 2 + half[1] * np.array([-1, 1])))
    axes.set_aspect("equal")
    axes.grid(visible=False)


def height_for(points: Array, width: float) -> float:
    """Height of a figure of some width that shows points with little left empty (inches)."""
    # points: the points, ``(points, 2)``; width: width of the figure (inches)
    across, up = np.ptp(points, axis=0) + 2 * DRAWN.margin * float(np.linalg.norm(np.ptp(points, axis=0)))
    return float(np.clip(TEXT + width * up / across, *HEIGHTS))


def kinds_of(joints: dict[str, Joint]) -> list[str]:
    """Kinds of the joints, in the order of `PINS`."""
    present = {joint.kind for joint in joints.values()}
    return [kind for kind in PINS if kind in present]


def _lines(axes: Axes, lines: Array, **look: Any) -> None:
    axes.add_collection(LineCollection([*(MILLI * lines)], **look))


def _polygons(axes: Axes, corners: Array, zorder: float) -> None:
    axes.add_collection(
        PolyCollection([*(MILLI * corners)], facecolors=SHADE, edgecolors=INK, linewidths=1.0, zorder=zorder)
    )


class ActingDrawing:
    """A drawing of what acts on a mechanism."""

    def __init__(self, skeleton: Skeleton, axes: Axes) -> None:
        self.skeleton, self.scene, self.axes = skeleton, skeleton.scene, axes
        self.present: list[str] = []  # kinds of what is drawn
        self.names: list[tuple[str, Array, dict[str, Any]]] = []  # text, place (m) and look of each name
        self.lines: list[Array] = []  # that names must not cover (m), (2, 2) each

    def add_all(self) -> None:
        """Draw all that acts at places of the mechanism, and collect the names."""
        for name, mass in self.scene.masses.items():
            if not mass.mass:  # such as those of a factory that were not stated
                continue
            self._dot("point mass", self._at(mass.at), f"{name} {short(MILLI * mass.mass)} g")
        self._add_loads()
        self._add_springs_and_dampers()
        for drive in self.scene.drives:
            self._add_motion("drive", drive.joint, drive.speed)
        for joint in self.scene.freedoms:
            self._add_motion("freedom", joint, None)
        for name, point in self.scene.points.items():
            (c, s), (x, y) = self._axes_of(point.at), point.offset
            self._dot("traced point", self._at(point.at) + np.array([c * x - s * y, s * x + c * y]), name)

    def _at(self, name: str) -> Array:
        """Place (m) of a point, a joint, or a place along a member."""
        if name in self.scene.joints:
            return np.asarray(self.skeleton.pins[list(self.scene.joints).index(name)])
        return self.skeleton.motion.of_point(*self.scene.place(name))[0][0]

    def _axes_of(self, name: str) -> tuple[float, float]:
        """Cosine and sine of the angle of the link that a point belongs to."""
        if name in self.scene.joints:
            name = next(point for point in self.scene.joints[name].connect if not point.startswith("ground."))
        angle = self.skeleton.angle_of(self.scene.place(name)[0])
        return float(np.cos(angle)), float(np.sin(angle))

    def _add_loads(self) -> None:
        """Draw loads and impulses as arrows that end where they act."""
        for name, load in self.scene.loads.items():
            if isinstance(load, LineLoad):
                self._add_line_load(name, load)
                continue
            c, s = self._axes_of(load.at) if load.follows else (1.0, 0.0)
            x, y = load.force
            self._push("load", name, self._at(load.at), (np.array([c * x - s * y, s * x + c * y]), load.moment, "N"))
        for name, impulse in self.scene.impulses.items():
            effort = (np.array(impulse.impulse), impulse.angular_impulse, "N s")
            self._push("impulse", name, self._at(impulse.at), effort)

    def _push(self, kind: str, name: str, place: Array, effort: tuple[Array, float, str]) -> None:
        """Draw a force and a moment at a place (m); `effort` has both, and the unit of the force."""
        force, moment, unit = effort
        size, said = float(np.linalg.norm(force)), []
        if size:
            tail = place - FORCE * self.skeleton.extent * force / size
            self._arrow(kind, np.array([tail, place]))
            said.append(f"{short(size)} {unit}")
        if moment:
            self._turn(kind, place, moment)
            said.append(f"{short(moment)} {unit.replace('N', 'N m')}")
        self._name(kind, f"{name} {', '.join(said)}", tail if size else place)

    def _add_line_load(self, name: str, load: LineLoad) -> None:
        """Draw a load along a member as arrows as long as it is large."""
        first, second = self.skeleton.path[list(self.scene.members()).index(load.member)][[0, -1]]
        s = np.linspace(0, 1, ARROWS)[:, None]
        line = (1 - s) * load.ends[0] + s * load.ends[1]
        largest = float(np.linalg.norm(line, axis=1).max()) or 1.0
        along = second - first
        forces = turned(line, np.arctan2(along[1], along[0])) if load.axes == "member" else line
        heads = first + s * along
        tails = heads - SPREAD * self.skeleton.extent * forces / largest
        for tail, head, force in zip(tails, heads, forces):
            if force.any():
                self._arrow("load", np.array([tail, head]))
        self._stroke("load", tails)
        self._name("load", f"{name} {short(largest)} N/m", tails[ARROWS // 2])

    def _add_springs_and_dampers(self) -> None:
        """Draw springs as zigzags and dampers as dashpots; at joints, as a spiral and as an arc with a stop."""
        extent = self.skeleton.extent
        for kind, parts in (("spring", self.scene.springs), ("damper", self.scene.dampers)):
            for name, part in parts.items():
                if isinstance(part, Line):
                    ends = np.array([self._at(point) for point in part.between])
                    strokes = [coil(ends, SPRING * extent)] if kind == "spring" else dashpot(ends, SPRING * extent)
                    place = ends.mean(axis=0)
                else:
                    place = self._at(part.joint)
                    size = HINGE * extent * (np.linspace(0.3, 1, 40)[:, None] if kind == "spring" else 1.0)
                    turns = arc(np.zeros(2), 1.0, 0, (5 if kind == "spring" else 1.5) * np.pi)
                    strokes = [place + size * turns]
                    strokes += [] if kind == "spring" else [place + HINGE * extent * np.array([[-0.3, -1], [0.3, -1]])]
                for stroke in strokes:
                    self._stroke(kind, stroke)
                self._name(kind, name, place)

    def _add_motion(self, kind: str, joint: str, speed: float | None) -> None:
        """Draw what moves a joint: an arrow in its sense, or in both where it changes or is not known."""
        place, held = self._at(joint), self.scene.joints[joint]
        if not isinstance(held, Slot | Prismatic):
            self._turn(kind, place, speed)
            return
        angle = self.skeleton.angle_of(held.connect[0].split(".")[0]) + self.scene.guide_angle(held)
        arm = FORCE / 2 * self.skeleton.extent * np.array([np.cos(angle), np.sin(angle)])
        beside = SPREAD / 2 * self.skeleton.extent * np.array([-np.sin(angle), np.cos(angle)])
        self._arrow(kind, np.array([place + beside - arm, place + beside + arm]), both=True)

    def add_gravity(self, gravity: Array) -> None:
        """Draw gravity in the upper right corner of the axes, whose limits are known."""
        # gravity: its acceleration (m/s^2), ``(2,)``
        size = float(np.linalg.norm(gravity))
        high = np.array([self.axes.get_xlim()[1], self.axes.get_ylim()[1]]) / MILLI
        length = FORCE / 2 * self.skeleton.extent
        middle = high - length * np.array([1.0, 1.0])
        arm = length / 2 * gravity / size
        self._arrow("sense of gravity", np.array([middle - arm, middle + arm]))
        self._name("sense of gravity", f"g {short(size)} m/s\N{SUPERSCRIPT TWO}", middle)

    def _turn(self, kind: str, place: Array, sense: float | None) -> None:
        """Draw an arrow that turns about a place, counter-clockwise where `sense` is positive, both ways without it."""
        points = arc(place, TURNING * self.skeleton.extent, *((FROM, TO) if sense is None or sense > 0 else (TO, FROM)))
        self._stroke(kind, points[2:-2] if sense is None else points[:-2])
        self._head(kind, points[-3:])
        if sense is None:
            self._head(kind, points[2::-1])

    def _arrow(self, kind: str, ends: Array, both: bool = False) -> None:
        """Draw a straight arrow (m), with a head at its second end or at both."""
        self._stroke(kind, ends)
        self._head(kind, ends)
        if both:
            self._head(kind, ends[::-1])

    def _head(self, kind: str, points: Array) -> None:
        """Draw the head of an arrow at the last of some points (m)."""
        tail, head = MILLI * points[[0, -1]]
        look = {"arrowstyle": "-|>", "color": LOOKS[kind]["color"], "shrinkA": 0, "shrinkB": 0, "mutation_scale": 12}
        self.axes.annotate("", head, tail, arrowprops=look, zorder=5)

    def _stroke(self, kind: str, points: Array) -> None:
        """Draw a line through points (m)."""
        self._count(kind)
        self.lines += [np.array(pair) for pair in pairwise(points)]
        self.axes.plot(*(MILLI * points).T, zorder=3.8, **LOOKS[kind] | {"linewidth": 1.5})

    def _dot(self, kind: str, place: Array, text: str) -> None:
        """Draw the symbol of what is at a place (m), under the joints, with its name."""
        self._count(kind)
        self.axes.plot(*(MILLI * place), zorder=3.6, **LOOKS[kind])
        self._name(kind, text, place)

    def _name(self, kind: str, text: str, place: Array) -> None:
        """Keep a name for the end, when all lines are known."""
        self.names.append((text, place, {"color": LOOKS[kind]["color"], "fontsize": 8}))

    def _count(self, kind: str) -> None:
        if kind not in self.present:
            self.present.append(kind)


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
    shapes = here["shape"].transpose("mode", "member", "s", "component").to_numpy()[:MOST_MODES]
    rest = skeleton_at(found, float(here["theta"]))
    drawn, most, other = (
        [replace(rest, path=rest.path + share * LARGEST * rest.extent * shape) for shape in shapes]
        for share in (swing, 1.0, -1.0)
    )
    points = np.concatenate([rest.points, *(bent.points for bent in (*most, *other))])
    rows = -(-len(drawn) // MODE_COLUMNS)
    figure, panels = empty_figure(rows, 0.4 + rows * height_for(points, SIZE[0] / MODE_COLUMNS), columns=MODE_COLUMNS)
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
