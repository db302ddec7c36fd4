"""The model of a scene at its start: links, joints, supports, and all that acts on them, with their names."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from fenics_mech._arrays import Array, turned
from fenics_mech._constants import MILLI
from fenics_mech.scene import LineLoad, Prismatic, Scene, Slot
from fenics_mech.scene.springs_dampers import Line
from fenics_mech.views.drawn_parts import ARROWS, INK, arc, coil, dashpot
from fenics_mech.views.figures import COLOURS, SIZE, figure_in, finish, new_axes
from fenics_mech.views.skeleton import PIN, PINS, Skeleton, frame, height_for, kinds_of
from fenics_mech.views.tables import drive_of
from fenics_mech.views.words import short

WIDE, TALL = 0.62, 1.15  # of the font size, that a letter is wide and a line is tall
GAP, MOST = 2.0, 500  # distance of dots on a line (typographic points), and their largest number
FARTHER = (1.0, 2.2)  # distances that are tried
NAMES = 100  # dots that count as much as a name that is covered
DIRECTIONS = np.stack([np.cos(turn := np.arange(16) * np.pi / 8 + np.pi / 4), np.sin(turn)], axis=-1)
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
FORCE, TURN, SPREAD, SPRING, HINGE = 0.16, 0.07, 0.09, 0.018, 0.045  # sizes of symbols over the extent
FROM, TO = -0.35 * np.pi, 0.85 * np.pi  # rad, of the arc of an arrow that turns
LINK: dict[str, Any] = {"color": "#666666", "fontsize": 9, "style": "italic"}
JOINT: dict[str, Any] = {"color": INK, "fontsize": 10, "weight": "bold"}
ALONG = np.array([0.5, 0.35, 0.65])[:, None]  # of a member, where its link's name may stand
COLUMNS = 4  # of the legend


class Labels:
    """Names that do not cover one another, nor the lines of the drawing."""

    # lines: lines of the drawing in the units of the axes, ``(lines, 2, 2)``

    def __init__(self, axes: Axes, lines: Array) -> None:
        self.axes = axes
        self.boxes: list[Array] = []  # middle and half size of each name
        low, high = np.array([self.axes.get_xlim(), self.axes.get_ylim()]).T
        box = self.axes.bbox
        points = np.array([box.width, box.height]) * 72 / figure_in(self.axes).dpi
        self.point = float(np.max((high - low) / points))  # length of a typographic point in the units of the axes
        self.dots = np.concatenate([np.zeros((0, 2)), *(self._dotted(line) for line in lines)])

    def _dotted(self, line: Array) -> Array:
        """Points of a line at about equal distances, which a name must not cover."""
        count = int(np.clip(np.linalg.norm(line[1] - line[0]) / (GAP * self.point), 2, MOST))
        return np.asarray(np.linspace(line[0], line[1], count))

    def add(self, text: str, places: Array, distance: float, look: dict[str, Any]) -> None:
        """Write a name beside the place where it covers least."""
        # places: where it may stand, the best first, ``(places, 2)``
        half = np.array([WIDE * len(text), TALL]) * look["fontsize"] * self.point / 2
        reach = half / np.maximum(np.abs(DIRECTIONS), 1e-9)
        nearest = reach.min(axis=1, keepdims=True)
        arms = np.concatenate([(nearest + far * distance * self.point) * DIRECTIONS for far in FARTHER])
        middles = (places[:, None] + arms).reshape(-1, 2)
        middle = middles[int(np.argmin([self._covered(at, half) for at in middles]))]
        self.boxes.append(np.stack([middle, half]))
        x, y = middle
        self.axes.text(x, y, text, ha="center", va="center", zorder=6, **look)

    def _covered(self, middle: Array, half: Array) -> float:
        """Dots of lines in a box, and area of names that it covers, which counts more."""
        dots = float((np.abs(self.dots - middle) < half).all(axis=1).sum())
        if not self.boxes:
            return dots
        others = np.array(self.boxes)
        both = np.clip(half + others[:, 1] - np.abs(middle - others[:, 0]), 0, None)
        return dots + NAMES * float((both.prod(axis=1) / (4 * half.prod())).sum())


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
        points = arc(place, TURN * self.skeleton.extent, *((FROM, TO) if sense is None or sense > 0 else (TO, FROM)))
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


def plot_scene(scene: Scene, axes: Axes | None = None) -> Axes:
    """Draw the model at its start, in mm: what is stated, where it is, and what it is called.

    An arrow ends where its force acts, and points as it is stated, whatever its factor is at the start.

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
