"""The mechanism as pyvista draws it: an off-screen picture per position."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index
from fenics_mech.views.frames import Frames
from fenics_mech.views.symbols import DRAWN, INK, RIGID, SHADE, TRIANGLE, guide_strokes, support_strokes

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


@dataclass(frozen=True)
class Look:
    """How the mechanism is drawn."""

    limit: float  # stress or strain at the ends of the colour bar
    measure: str  # its name and unit, such as "stress (MPa)"
    # names that are written beside joints, traced points and loads: of all pins, then of all points, then of all
    # arrows. None where none shall be; an empty one is not written.
    names: tuple[str, ...] = ()
    true_width: bool = False  # whether members are as wide as their sections in the plane of motion, not all alike


class Stage:
    """An off-screen plotter with the mechanism on it, seen along z in parallel projection."""

    # ground: points of the ground (m), ``(points, 2)``, and guides on it, ``(guides, 2, 2)``; size: of the picture
    # (pixels)

    def __init__(
        self, frames: Frames, ground: tuple[Array, Array], size: tuple[int, int], look: Look, text: tuple[str, str]
    ) -> None:
        shown = (
            frames.path,
            frames.rigid,
            frames.bars,
            frames.pins,
            frames.guides,
            frames.traced,
            frames.trails,
            *ground,
        )
        points = np.concatenate([part.reshape(-1, 2) for part in shown])
        low, high = points.min(axis=0), points.max(axis=0)
        self.extent = float(np.linalg.norm(high - low))
        tails = self._tails(frames.loads).reshape(-1, 2)
        low, high = (np.stack([low, high, *tails]).min(axis=0), np.stack([low, high, *tails]).max(axis=0))
        self.frames, self.size = frames, size
        self.plotter = pv.Plotter(off_screen=True, window_size=list(size))
        self.plotter.set_background("white")
        self.plotter.enable_anti_aliasing("msaa", multi_samples=8)
        self._look_at(low - DRAWN.margin * self.extent, high + DRAWN.margin * self.extent)
        self._add_supports(ground[0])
        self._add_guides(ground[1])
        self.half = frames.half_width if look.true_width else DRAWN.ribbon * self.extent
        self.edge = THIN if look.true_width else 1.0
        self._add_trails()
        self.meshes = self._add_mechanism(look.limit) | self._add_acting()
        if frames.path.shape[1]:
            self._add_bar(look.limit, look.measure)
        self._add_text(text[0], 0.03, 0.94)
        for line, height in zip(text[1].splitlines()[::-1], (0.015, 0.058)):
            self._add_text(line, 0.03, height)
        self.names = [self._add_text(written, 0, 0) for written in look.names]
        for name in self.names:  # legible on a member too
            name.prop.background_color, name.prop.background_opacity = "white", VEIL * bool(name.input)
        self.angle = self._add_text("", 0.03, 0.895)

    def picture(self, index: int) -> NDArray[np.uint8]:
        """Render one of the frames, ``(height, width, 3)``."""
        frames = self.frames
        path, pins = frames.path[index], frames.pins[index]
        self.meshes["rigid"].points = self._raised(frames.rigid[index], "rigid")
        edge = (DRAWN.outline - DRAWN.ribbon) * self.extent * self.edge
        self.meshes["outline"].points = self._raised(ribbon(path, self.half + edge), "outline")
        left, right = np.moveaxis(ribbon(path, self.half), 2, 0)
        halves = np.stack([np.stack([left, path], axis=2), np.stack([path, right], axis=2)], axis=1)
        self.meshes["ribbon"].points = self._raised(halves, "ribbon")
        self.meshes["ribbon"]["colour"] = np.repeat(np.moveaxis(frames.sides[index], 2, 1).ravel(), 2)
        self.meshes["bar edge"].points = self._raised(ribbon(frames.bars[index], DRAWN.outline * self.extent), "rigid")
        self.meshes["bar"].points = self._raised(ribbon(frames.bars[index], DRAWN.ribbon * self.extent), "outline")
        self.meshes["guide"].points = self._raised(frames.guides[index], "rigid")
        corners = frames.slider_pins[index][:, None] + DRAWN.block * self.extent * frames.sliders[index]
        for name in ("block", "block edge"):
            self.meshes[name].points = self._raised(corners, "block")
        for name, radius in (("pin", DRAWN.pin), ("hole", DRAWN.hole)):
            self.meshes[name].points = self._raised(pins[:, None] + radius * self.extent * CIRCLE, name)
        if np.isfinite(frames.peak_value):
            self.meshes["peak"].points = self._raised(frames.peak[index] + DRAWN.peak * self.extent * RING, "hole")
        self._move_acting(index)
        named = np.concatenate([pins, frames.traced[index], self._tails(frames.loads[index])])
        for text, place in zip(self.names, named + DRAWN.name * self.extent):
            text.position = tuple((place - self.corner) / (self.pixel * np.array(self.size)))
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

    def _add_supports(self, ground: Array) -> None:
        """Draw each point of the ground as a triangle on a hatched line."""
        size, first, lines = DRAWN.support * self.extent, ground[:, None], support_strokes()
        if not len(ground):
            return
        corners = self._raised(first + size * TRIANGLE, "ground")
        strokes = self._raised(first + size * lines.reshape(-1, 2), "ground")
        look = {"lighting": False, "color": INK, "line_width": self.size[1] / 450}
        self.plotter.add_mesh(pv.PolyData(corners, faces=_cells(len(ground), 3)), color=SHADE, lighting=False)
        self.plotter.add_mesh(pv.PolyData(corners, lines=_cells(len(ground), 3, closed=True)), **look)
        self.plotter.add_mesh(pv.PolyData(strokes, lines=_cells(len(ground) * len(lines), 2)), **look)

    def _add_guides(self, guides: Array) -> None:
        """Draw each guide as a hatched line under its slider's block."""
        for guide in guides:
            strokes = guide_strokes(guide, self.extent)
            lines = pv.PolyData(self._raised(strokes, "ground"), lines=_cells(len(strokes), 2))
            self.plotter.add_mesh(lines, lighting=False, color=INK, line_width=self.size[1] / 450)

    def _add_mechanism(self, limit: float) -> dict[str, pv.PolyData]:
        """Add the parts that move; `picture` puts them in their places."""
        _, members, stations, _ = self.frames.path.shape
        joints = self.frames.pins.shape[1]
        strips = _strips(members, stations)
        blank = np.zeros((members * stations * 2, 3))
        circles = np.zeros((joints * len(CIRCLE), 3))
        meshes = {
            "rigid": pv.PolyData(np.zeros((2 * members, 3)), lines=_cells(members, 2)),
            "outline": pv.PolyData(blank, faces=strips),
            "ribbon": pv.PolyData(np.zeros((2 * len(blank), 3)), faces=_strips(2 * members, stations)),  # its two sides
            "pin": pv.PolyData(circles, faces=_cells(joints, len(CIRCLE))),
            "hole": pv.PolyData(circles, faces=_cells(joints, len(CIRCLE))),
            "peak": pv.PolyData(np.zeros((len(RING), 3)), faces=_strips(1, len(RING) // 2)),
        }
        meshes["ribbon"]["colour"] = np.zeros(2 * len(blank))
        meshes |= self._add_rigid_parts()
        for name, colour in (("rigid", RIGID), ("outline", INK), ("pin", INK), ("hole", "white"), ("peak", PEAK)):
            if meshes[name].n_points:
                self.plotter.add_mesh(meshes[name], color=colour, lighting=False, line_width=self.size[1] / 400)
        if members:
            self.plotter.add_mesh(meshes["ribbon"], **_coloured(limit))
        return meshes

    def _add_trails(self) -> None:
        """Draw the paths of the joints, and those of the traced points, which are the last."""
        paths, traced = self.frames.trails, self.frames.traced.shape[1]
        for i, path in enumerate(paths):
            lines = pv.PolyData(self._raised(path, "trail"), lines=np.append(len(path), np.arange(len(path))))
            of_point = i >= len(paths) - traced
            look = {"color": TRACE if of_point else SHADE, "line_width": self.size[1] / (300 if of_point else 500)}
            self.plotter.add_mesh(lines, lighting=False, **look)

    def _add_acting(self) -> dict[str, pv.PolyData]:
        """Add traced points, point masses and loads; `_move_acting` puts them in their places."""
        counts = {"traced": self.frames.traced.shape[1], "mass": self.frames.masses.shape[1]}
        loads = self.frames.loads.shape[1]
        meshes = {
            name: pv.PolyData(np.zeros((count * len(CIRCLE), 3)), faces=_cells(count, len(CIRCLE)))
            for name, count in counts.items()
        }
        meshes["load"] = pv.PolyData(np.zeros((2 * loads, 3)), lines=_cells(loads, 2))
        meshes["load head"] = pv.PolyData(np.zeros((3 * loads, 3)), faces=_cells(loads, 3))
        for mesh, colour in zip(meshes.values(), (TRACE, MASS, LOAD, LOAD)):
            if mesh.n_points:
                self.plotter.add_mesh(mesh, color=colour, lighting=False, line_width=self.size[1] / 200)
        return meshes

    def _move_acting(self, index: int) -> None:
        """Put traced points, masses and loads where they are in a frame."""
        frames, extent = self.frames, self.extent
        traced, masses = frames.traced[index][:, None], frames.masses[index][:, None]
        self.meshes["traced"].points = self._raised(traced + DRAWN.traced * extent * CIRCLE, "hole")
        radius = DRAWN.mass * extent * frames.mass_sizes[:, None, None]
        self.meshes["mass"].points = self._raised(masses + radius * CIRCLE, "mass")
        place, force = np.moveaxis(frames.loads[index], 1, 0)
        size = np.linalg.norm(force, axis=-1, keepdims=True)
        along = force / np.maximum(size, 1e-300)
        across = np.stack([-along[:, 1], along[:, 0]], axis=-1)
        head = DRAWN.head * extent * np.minimum(size * DRAWN.load / DRAWN.head, 1.0)
        self.meshes["load"].points = self._raised(
            np.stack([self._tails(frames.loads[index]), place - head * along], axis=1), "load"
        )
        base = place - head * along
        corners = np.stack([place, base + 0.4 * head * across, base - 0.4 * head * across], axis=1)
        self.meshes["load head"].points = self._raised(corners, "load")

    def _add_rigid_parts(self) -> dict[str, pv.PolyData]:
        """Add rigid links and the blocks of sliders, where there are any."""
        bars, blocks = self.frames.bars.shape[1], self.frames.sliders.shape[1]
        edges, corners = np.zeros((bars * 4, 3)), np.zeros((blocks * 4, 3))
        guides = self.frames.guides.shape[1]
        track = pv.PolyData(np.zeros((2 * guides, 3)), lines=_cells(guides, 2))
        if guides:
            self.plotter.add_mesh(track, color=INK, lighting=False, line_width=self.size[1] / 250)
        meshes = {
            "bar edge": pv.PolyData(edges, faces=_strips(bars, 2)),
            "bar": pv.PolyData(edges, faces=_strips(bars, 2)),
            "block": pv.PolyData(corners, faces=_cells(blocks, 4)),
            "block edge": pv.PolyData(corners, lines=_cells(blocks, 4, closed=True)),
        }
        for mesh, colour in zip(meshes.values(), (INK, RIGID, SHADE, INK)):
            if mesh.n_points:
                self.plotter.add_mesh(mesh, color=colour, lighting=False, line_width=self.size[1] / 450)
        return meshes | {"guide": track}

    def _add_bar(self, limit: float, measure: str) -> None:
        """Draw the colour bar. Not VTK's own: its number formatting ends the process once dolfinx is loaded."""
        x, low, high = 1 - 0.8 * DRAWN.bar, 0.22, 0.78  # of the picture
        corners = np.array([[x, low], [x + 0.022, low], [x + 0.022, high], [x, high]])
        points = self._raised(self.corner + corners * self.size * self.pixel, "ground")
        bar = pv.PolyData(points, faces=_cells(1, 4))
        bar["colour"] = np.array([-limit, -limit, limit, limit])
        self.plotter.add_mesh(bar, **_coloured(limit))
        frame = pv.PolyData(points, lines=_cells(1, 4, closed=True))
        self.plotter.add_mesh(frame, color=INK, lighting=False, line_width=self.size[1] / 600)
        at = self.frames.peak_value / (2 * limit) + 0.5  # of the bar, where the peak is
        across = [[x - 0.012, low + at * (high - low)], [x + 0.022, low + at * (high - low)]]
        line = self._raised(self.corner + np.array(across) * self.size * self.pixel, "rigid")
        look = {"color": PEAK, "lighting": False, "line_width": self.size[1] / 180}
        self.plotter.add_mesh(pv.PolyData(line, lines=_cells(1, 2)), **look)
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
    return {
        "scalars": "colour",
        "cmap": COLOUR_MAP,
        "clim": (-limit, limit),
        "lighting": False,
        "show_scalar_bar": False,
        "interpolate_before_map": True,
    }


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
