"""The mechanism as pyvista draws it: an off-screen picture per position."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index
from fenics_mech.views.drawn_parts import DRAWN, INK, RIGID, SHADE, TRIANGLE, guide_strokes, support_strokes
from fenics_mech.views.frames import Frames

FONT = str(Path(mpl.get_data_path()) / "fonts/ttf/DejaVuSans.ttf")  # has the degree, times and micro signs
COLOUR_MAP = "RdBu_r"

CIRCLE = np.stack([np.cos(turn := np.linspace(0, 2 * np.pi, 33)[:-1]), np.sin(turn)], axis=-1)
RING = np.stack([CLOSED := np.concatenate([CIRCLE, CIRCLE[:1]]), 0.72 * CLOSED], axis=1).reshape(-1, 2)
PEAK = "#E69F00"  # colour of the ring at the peak
VEIL = 0.7  # opacity behind names
THIN = 0.5  # of the outline, beside members that may be thinner than it
TRACE, MASS, LOAD = "#D55E00", "#555555", "#009E73"  # of traced points, point masses and loads
SYMBOLS = (INK, SHADE, RIGID, PEAK, TRACE, MASS, LOAD)
LAYERS = {"ground": 0, "trail": 0.5, "rigid": 1, "outline": 2, "block": 2.5, "ribbon": 3, "mass": 3.5}
LAYERS |= {"pin": 4, "hole": 5, "load": 6}


class Stage:
    """An off-screen plotter with the mechanism on it, seen along z in parallel projection; it holds all frames."""

    # ground: points of the ground (m), ``(points, 2)``, and guides on it, ``(guides, 2, 2)``; size: of the picture
    # (pixels); limit: stress or strain at the ends of the colour bar, whose name and unit `measure` is; text: above and
    # below the mechanism; names: of all pins, then of all traced points, then of all arrows, an empty one is not
    # written; true_width: whether members are as wide as their sections in the plane of motion, not all alike

    def __init__(
        self,
        frames: Frames,
        ground: tuple[Array, Array],
        size: tuple[int, int],
        limit: float,
        measure: str,
        text: tuple[str, str],
        names: tuple[str, ...],
        true_width: bool,
    ) -> None:
        moving = (frames.path, frames.rigid, frames.bars, frames.pins, frames.guides, frames.traced, frames.trails)
        points = np.concatenate([part.reshape(-1, 2) for part in (*moving, *ground)])
        self.extent = float(np.linalg.norm(np.ptp(points, axis=0)))
        points = np.concatenate([points, self._tails(frames.loads).reshape(-1, 2)])
        self.frames, self.size = frames, size
        self.plotter = pv.Plotter(off_screen=True, window_size=list(size))
        self.plotter.set_background("white")
        self.plotter.enable_anti_aliasing("msaa", multi_samples=8)
        margin = DRAWN.margin * self.extent
        self._look_at(points.min(axis=0) - margin, points.max(axis=0) + margin)
        self.half = frames.half_width if true_width else DRAWN.ribbon * self.extent
        self.edge = (DRAWN.outline - DRAWN.ribbon) * self.extent * (THIN if true_width else 1.0)
        self._add_ground(*ground)
        self._add_trails()
        self.meshes = self._add_mechanism(limit)
        if frames.path.shape[1]:
            self._add_bar(limit, measure)
        self._add_text(text[0], 0.03, 0.94)
        for line, height in zip(text[1].splitlines()[::-1], (0.015, 0.058)):
            self._add_text(line, 0.03, height)
        self.names = [self._add_text(written, 0, 0) for written in names]
        for name in self.names:  # legible on a member too
            name.prop.background_color, name.prop.background_opacity = "white", VEIL * bool(name.input)
        self.angle = self._add_text("", 0.03, 0.895)

    def picture(self, index: int) -> NDArray[np.uint8]:
        """Render one of the frames, ``(height, width, 3)``."""
        frames, extent = self.frames, self.extent
        path, pins, traced = frames.path[index], frames.pins[index], frames.traced[index]
        left, right = np.moveaxis(ribbon(path, self.half), 2, 0)
        halves = np.stack([np.stack([left, path], axis=2), np.stack([path, right], axis=2)], axis=1)
        self.meshes["ribbon"]["colour"] = np.repeat(np.moveaxis(frames.sides[index], 2, 1).ravel(), 2)
        blocks = frames.slider_pins[index][:, None] + DRAWN.block * extent * frames.sliders[index]
        place, force = np.moveaxis(frames.loads[index], 1, 0)
        tails, size = self._tails(frames.loads[index]), np.linalg.norm(force, axis=-1, keepdims=True)
        along = force / np.maximum(size, 1e-300)
        across = np.stack([-along[:, 1], along[:, 0]], axis=-1)
        head = DRAWN.head * extent * np.minimum(size * DRAWN.load / DRAWN.head, 1.0)
        base = place - head * along
        mass_radius = DRAWN.mass * extent * frames.mass_sizes[:, None, None]
        shown = {  # points of each mesh (m), and their layer
            "rigid": (frames.rigid[index], "rigid"),
            "outline": (ribbon(path, self.half + self.edge), "outline"),
            "ribbon": (halves, "ribbon"),
            "bar edge": (ribbon(frames.bars[index], DRAWN.outline * extent), "rigid"),
            "bar": (ribbon(frames.bars[index], DRAWN.ribbon * extent), "outline"),
            "guide": (frames.guides[index], "rigid"),
            "block": (blocks, "block"),
            "block edge": (blocks, "block"),
            "pin": (pins[:, None] + DRAWN.pin * extent * CIRCLE, "pin"),
            "hole": (pins[:, None] + DRAWN.hole * extent * CIRCLE, "hole"),
            "traced": (traced[:, None] + DRAWN.traced * extent * CIRCLE, "hole"),
            "mass": (frames.masses[index][:, None] + mass_radius * CIRCLE, "mass"),
            "load": (np.stack([tails, base], axis=1), "load"),
            "load head": (np.stack([place, base + 0.4 * head * across, base - 0.4 * head * across], axis=1), "load"),
        }
        if np.isfinite(frames.peak_value):
            shown["peak"] = (frames.peak[index] + DRAWN.peak * extent * RING, "hole")
        for name, (points, layer) in shown.items():
            self.meshes[name].points = self._raised(points, layer)
        for text, at in zip(self.names, np.concatenate([pins, traced, tails]) + DRAWN.name * extent):
            text.position = tuple((at - self.corner) / (self.pixel * np.array(self.size)))
        self.angle.input = frames.labels[index]
        self.plotter.render()
        return self.plotter.screenshot(return_img=True)

    def close(self) -> None:
        """Free the render window."""
        self.plotter.close()

    def _tails(self, loads: Array) -> Array:
        """Where the arrows of loads begin (m), ``(..., arrows, 2)``."""
        return np.asarray(loads[..., 0, :] - DRAWN.load * self.extent * loads[..., 1, :])

    def _look_at(self, low: Array, high: Array) -> None:
        """Put the box into the part of the picture that bar and text leave free."""
        width, height = self.size
        self.pixel = np.max((high - low) / [width * (1 - DRAWN.bar), height * (1 - 2 * DRAWN.text)])  # m
        x, y = (low + high) / 2
        x += self.pixel * width * DRAWN.bar / 2
        self.corner = np.array([x - self.pixel * width / 2, y - self.pixel * height / 2])  # lower left
        camera = self.plotter.camera
        camera.parallel_projection = True
        camera.focal_point, camera.position, camera.up = (x, y, 0), (x, y, 10 * self.extent), (0, 1, 0)
        camera.parallel_scale = self.pixel * height / 2
        camera.clipping_range = (self.extent, 20 * self.extent)

    def _add(self, colour: str, cells: Index, points: Array | None = None, width: float = 0) -> pv.PolyData:
        """Add faces, or lines of a share of the picture's height, at points in 3D or where `picture` puts them."""
        blank = np.zeros((cells.max(initial=-1) + 1, 3))  # at least as many as the cells have
        mesh = pv.PolyData(blank if points is None else points, **{"lines" if width else "faces": cells})
        if mesh.n_points:
            self.plotter.add_mesh(mesh, color=colour, lighting=False, line_width=self.size[1] / (width or 400))
        return mesh

    def _add_ground(self, ground: Array, guides: Array) -> None:
        """Draw each point of the ground as a triangle on a hatched line, and each guide as such a line."""
        size, first = DRAWN.support * self.extent, ground[:, None]
        corners = self._raised(first + size * TRIANGLE, "ground")
        self._add(SHADE, _cells(len(ground), 3), corners)
        self._add(INK, _cells(len(ground), 3, closed=True), corners, 450)
        under = (first + size * support_strokes().reshape(-1, 2)).reshape(-1, 2, 2)
        for strokes in (under, *(guide_strokes(guide, self.extent) for guide in guides)):
            self._add(INK, _cells(len(strokes), 2), self._raised(strokes, "ground"), 450)

    def _add_trails(self) -> None:
        """Draw the paths of the joints, and those of the traced points, which are the last."""
        joints = len(self.frames.trails) - self.frames.traced.shape[1]
        for i, path in enumerate(self.frames.trails):
            colour, width = (SHADE, 500) if i < joints else (TRACE, 300)
            self._add(colour, np.append(len(path), np.arange(len(path))), self._raised(path, "trail"), width)

    def _add_mechanism(self, limit: float) -> dict[str, pv.PolyData]:
        """Add the parts that move and what acts on them; `picture` puts them in their places."""
        frames = self.frames
        _, members, stations, _ = frames.path.shape
        bars, blocks, loads = (part.shape[1] for part in (frames.bars, frames.sliders, frames.loads))
        joints, traced, masses = (
            _cells(part.shape[1], len(CIRCLE)) for part in (frames.pins, frames.traced, frames.masses)
        )
        meshes = {
            "guide": self._add(INK, _cells(frames.guides.shape[1], 2), width=250),
            "bar edge": self._add(INK, _strips(bars, 2)),
            "bar": self._add(RIGID, _strips(bars, 2)),
            "block": self._add(SHADE, _cells(blocks, 4)),
            "block edge": self._add(INK, _cells(blocks, 4, closed=True), width=450),
            "rigid": self._add(RIGID, _cells(members, 2), width=400),
            "outline": self._add(INK, _strips(members, stations)),
            "pin": self._add(INK, joints),
            "hole": self._add("white", joints),
            "peak": self._add(PEAK, _strips(1, len(RING) // 2)),
        }
        two_sides = np.zeros((4 * members * stations, 3))
        meshes["ribbon"] = pv.PolyData(two_sides, faces=_strips(2 * members, stations))
        meshes["ribbon"]["colour"] = two_sides[:, 0]
        if members:
            self.plotter.add_mesh(meshes["ribbon"], **_coloured(limit))
        return meshes | {
            "traced": self._add(TRACE, traced),
            "mass": self._add(MASS, masses),
            "load": self._add(LOAD, _cells(loads, 2), width=200),
            "load head": self._add(LOAD, _cells(loads, 3)),
        }

    def _add_bar(self, limit: float, measure: str) -> None:
        """Draw the colour bar. Not VTK's own: its number formatting ends the process once dolfinx is loaded."""
        x, low, high = 1 - 0.8 * DRAWN.bar, 0.22, 0.78  # of the picture
        corners = np.array([[x, low], [x + 0.022, low], [x + 0.022, high], [x, high]])
        points = self._raised(self.corner + corners * self.size * self.pixel, "ground")
        bar = pv.PolyData(points, faces=_cells(1, 4))
        bar["colour"] = np.array([-limit, -limit, limit, limit])
        self.plotter.add_mesh(bar, **_coloured(limit))
        self._add(INK, _cells(1, 4, closed=True), points, 600)
        at = self.frames.peak_value / (2 * limit) + 0.5  # of the bar, where the peak is
        across = np.array([[x - 0.012, low + at * (high - low)], [x + 0.022, low + at * (high - low)]])
        line = self._raised(self.corner + across * self.size * self.pixel, "rigid")
        self._add(PEAK, _cells(1, 2), line, 180)
        for share in np.linspace(0, 1, 5):
            value = limit * (2 * share - 1)
            label = f"{value:+.4g}".replace("-", "\N{MINUS SIGN}") if value else "0"
            self._add_text(label, x + 0.03, low + share * (high - low) - 0.011)
        self._add_text(measure, x - 0.04, high + 0.03)

    def _add_text(self, text: str, x: float, y: float) -> pv.Text:
        look = {"font_size": max(int(min(*self.size * np.array([0.75, 1])) / 65), 4), "font_file": FONT, "color": INK}
        return self.plotter.add_text(text, position=(x, y), viewport=True, **look)

    def _raised(self, points: Array, layer: str) -> Array:
        """Points of the plane, put in their layer, ``(points, 3)``."""
        flat = points.reshape(-1, 2)
        return np.column_stack([flat, np.full(len(flat), LAYERS[layer] * 1e-3 * self.extent)])


def ribbon(path: Array, half_width: float | Array) -> Array:
    """Left and right edge of centre lines ``(members, stations, 2)``, as ``(members, stations, 2, 2)``."""
    # Half the width is one number, or one at each station, ``(members, stations)``.
    tangent = np.gradient(path, axis=1)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=-1, keepdims=True), 1e-300)
    normal = np.asarray(half_width)[..., None] * np.stack([-tangent[..., 1], tangent[..., 0]], axis=-1)
    return np.stack([path + normal, path - normal], axis=2)


def _coloured(limit: float) -> dict[str, object]:
    """Look of a mesh that is coloured by its stress or strain."""
    look = {"scalars": "colour", "cmap": COLOUR_MAP, "clim": (-limit, limit), "interpolate_before_map": True}
    return look | {"lighting": False, "show_scalar_bar": False}


def _cells(count: int, points: int, closed: bool = False) -> Index:
    """Cells of VTK's layout, each of its own `points` consecutive points."""
    cells = np.arange(count * points).reshape(count, points)
    if closed:
        cells = np.column_stack([cells, cells[:, 0]])
    return np.column_stack([np.full(count, cells.shape[1]), cells]).ravel()


def _strips(members: int, stations: int) -> Index:
    """Quadrilaterals between the edges that `ribbon` gives."""
    left = 2 * np.arange(members * stations).reshape(members, stations)[:, :-1].ravel()
    return np.column_stack([np.full(len(left), 4), left, left + 1, left + 3, left + 2]).ravel()
