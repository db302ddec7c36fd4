"""The mechanism at one position as Matplotlib draws it: supports, guides, links and joints."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection

from fenics_mech._arrays import Array, turned
from fenics_mech._constants import MILLI
from fenics_mech.kinematics import Motion, start_motion
from fenics_mech.recovery.rigid_places import ends_in
from fenics_mech.scene import Ground, Link, Prismatic, Scene, Slot
from fenics_mech.scene.joints import Joint
from fenics_mech.views.drawn_parts import (
    BLOCK_CORNERS,
    DRAWN,
    INK,
    RIGID,
    SHADE,
    TRIANGLE,
    ground_points,
    guide_strokes,
    guides_of,
    pin_places,
    rigid_bars,
    slider_angles,
    support_strokes,
)

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
