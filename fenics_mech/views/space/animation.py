"""Animation of a linkage in space: beams with their true sections, bent and coloured by stress."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from fenics_mech._arrays import Array, Index
from fenics_mech._constants import TURN
from fenics_mech.recovery.spatial_result import SpatialResult
from fenics_mech.scene.sections.plain import ISection
from fenics_mech.sections import numbers_of
from fenics_mech.views.drawn_parts import DRAWN, INK, RIGID, SHADE
from fenics_mech.views.picture_files import Pictures, Progress, write_pictures
from fenics_mech.views.space.reading import SpatialReading
from fenics_mech.views.space.skeleton import EYES
from fenics_mech.views.stage import COLOUR_MAP, FONT, PEAK
from fenics_mech.views.words import in_degrees, short

JOINT, RING, BAR, SUPPORT = 0.012, 0.022, 0.007, 0.035  # sizes over the extent
MARGIN = 0.05  # of the extent, about the motion
TRIAD, FINER = 0.09, 4  # of the picture's height; pieces between two stations
LIGHT = {"ambient": 0.45, "diffuse": 0.6, "specular": 0.0}


def spatial_animation(
    result: SpatialResult,
    path: Path,
    shown: tuple[str, float | None, int, bool],
    fps: int,
    size: tuple[int, int],
    progress: Progress,
) -> Path:
    """Write an animation of a cycle or of a motion in time, or of a .png one picture at the peak.

    `shown` is what colours the beams ("stress" or "strain"), the factor on deflections or None, the number of pictures,
    and whether joints have names.
    """
    reading = SpatialReading(result)
    still = path.suffix.lower() == ".png"
    colour, magnify, frames, names = shown
    stage = SpatialStage(reading, colour, reading.magnify if magnify is None else magnify, size, names)
    places = np.array([float(reading.peak_position)])
    if not still:
        last = len(reading.theta) - reading.in_time if reading.moves else 0
        places = np.linspace(0, last, frames, endpoint=reading.in_time)

    def pictures() -> Pictures:
        try:
            for index, place in enumerate(places):
                progress(index, len(places))
                yield stage.picture(float(place))
        finally:
            stage.close()

    return write_pictures(path, pictures(), fps)


def outline_of(section: Any) -> Array:
    """Give the outline of a section along both principal axes ``(corners, 2)`` (m), in order round it."""
    if not isinstance(section, ISection):
        return numbers_of(section).corners
    h, b, f, w = section.height / 2, section.width / 2, section.flange, section.web / 2
    half = np.array([[h, -b], [h, b], [h - f, b], [h - f, w], [f - h, w], [f - h, b]])
    return np.concatenate([half, -half])


class SpatialStage:
    """An off-screen plotter with the linkage on it, seen obliquely in parallel projection."""

    def __init__(
        self, reading: SpatialReading, colour: str, magnify: float, size: tuple[int, int], names: bool
    ) -> None:
        self.reading, self.size = reading, size
        self.right, self.up = EYES["oblique"]
        self.toward = np.cross(self.right, self.up)
        paths, pins = reading.paths(magnify), reading.joint_points(magnify)
        rigid = reading.paths(0.0)[:, :, [0, -1]]
        ground = np.array([*reading.scene.ground.points.values()]).reshape(-1, 3)
        every = np.concatenate([part.reshape(-1, 3) for part in (paths, pins, rigid, ground)])
        self.extent = float(np.linalg.norm(np.ptp(every, axis=0)))
        kind = "strain" if colour == "strain" else "stress"
        self.outlines = [self._outline(name) for name in reading.members]
        rings = [self._rings(i, paths[:, i], outline) for i, outline in enumerate(self.outlines)]
        colours = [self._colours(i, kind, outline) for i, outline in enumerate(self.outlines)]
        limit = max((float(np.abs(values).max()) for values in colours), default=1.0) or 1.0
        self.over = [self._over_cycle(values) for values in (paths, pins, rigid)]
        self.rings, self.colours = ([self._over_cycle(v) for v in values] for values in (rings, colours))
        self.plotter = pv.Plotter(off_screen=True, window_size=list(size))
        self.plotter.set_background("white")
        self.plotter.enable_anti_aliasing("msaa", multi_samples=8)
        self._look_at(every)
        self._add_ground(ground)
        self._add_parts(pins, limit, names)
        if reading.members:
            self._add_bar(limit, f"{kind} ({reading.units.label(kind)})")
        self._add_texts(kind, magnify)

    def _outline(self, name: str) -> Array:
        scene = self.reading.scene
        return outline_of(scene.sections[scene.members()[name][1].section])

    def _rings(self, i: int, path: Array, outline: Array) -> Array:
        """Sweep an outline along a bent member, across its drawn axis ``(T, S, corners, 3)``."""
        axes = self.reading.values("section_axes", "member", "s", "component", "section_axis")[:, i]
        path, towards = _finer(path, self.reading.s), _finer(axes[..., 1], self.reading.s)
        along = np.gradient(path, axis=1)
        along /= np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-300)
        first = towards - along * np.sum(along * towards, axis=-1, keepdims=True)
        first /= np.linalg.norm(first, axis=-1, keepdims=True)
        across = np.stack([first, np.cross(along, first)], axis=-2)
        return np.asarray(path[:, :, None] + np.einsum("cx,tsxd->tscd", outline, across))

    def _colours(self, i: int, kind: str, outline: Array) -> Array:
        """Stress or strain at the corners of an outline ``(T, S, corners)``: it is linear over a section."""
        corners = self.reading.data["corner_place"].transpose("member", "corner", "principal").to_numpy()[i]
        known = self.reading.values(kind, "member", "s", "corner")[:, i] / self.reading.units.size(kind)
        flat = np.moveaxis(known, 2, 0).reshape(len(corners), -1)
        plane = np.linalg.pinv(np.column_stack([np.ones(len(corners)), corners])) @ flat
        there = np.column_stack([np.ones(len(outline)), outline]) @ plane
        return _finer(np.moveaxis(there.reshape(len(outline), *known.shape[:2]), 0, 2), self.reading.s)

    def _over_cycle(self, values: Array) -> Any:
        """Give values at any position, which need not be whole."""
        if not self.reading.moves:
            return lambda place: values[0]
        if self.reading.in_time:
            return CubicSpline(np.arange(len(values)), values)
        closed = np.concatenate([values, values[:1]])
        return CubicSpline(np.arange(len(closed)), closed, bc_type="periodic")

    def _look_at(self, every: Array) -> None:
        """Put all places into the part of the picture that bar and texts leave free."""
        flat = np.stack([every @ self.right, every @ self.up], axis=1)
        low, high = flat.min(axis=0) - MARGIN * self.extent, flat.max(axis=0) + MARGIN * self.extent
        width, height = self.size
        self.pixel = float(np.max((high - low) / [width * (1 - DRAWN.bar), height * (1 - 2 * DRAWN.text)]))
        self.middle = (low + high) / 2 + [self.pixel * width * DRAWN.bar / 2, 0]
        depth = every @ self.toward
        self.front = float(depth.max()) + 0.5 * self.extent
        centre = self._world(self.middle, float(depth.mean()))
        camera = self.plotter.camera
        camera.parallel_projection = True
        camera.focal_point, camera.up = centre, self.up
        camera.position = centre + 10 * self.extent * self.toward
        camera.parallel_scale = self.pixel * height / 2
        camera.clipping_range = (self.extent, 20 * self.extent)

    def _world(self, flat: Array, depth: float) -> Array:
        """Places in space of those in the plane of the picture ``(..., 2)`` (m)."""
        return np.asarray(flat @ np.stack([self.right, self.up]) + depth * self.toward)

    def _screen(self, shares: Array) -> Array:
        """Places in front of all, by shares of the picture's width and height ``(..., 2)``."""
        return self._world(self.middle + (shares - 0.5) * self.size * self.pixel, self.front)

    def _add_ground(self, ground: Array) -> None:
        """Draw a cone under each point of the ground, and directions X, Y and Z."""
        size = SUPPORT * self.extent
        for point in ground:
            cone = pv.Cone(center=point - [0, 0, size / 2], direction=(0, 0, 1), height=size, radius=0.6 * size)
            self.plotter.add_mesh(cone, color=SHADE, **LIGHT)
        corner, length = self._screen(np.array([0.08, 0.17])), TRIAD * self.size[1] * self.pixel
        for name, way in zip("XYZ", np.eye(3)):
            self.plotter.add_mesh(pv.Line(corner, corner + length * way), color=RIGID, line_width=self.size[1] / 300)
            self._add_text(name, *self._share(corner + 1.15 * length * way))

    def _share(self, place: Array) -> Array:
        """Shares of the picture's width and height at which a place is seen."""
        flat = np.array([place @ self.right, place @ self.up])
        return np.asarray((flat - self.middle) / (self.pixel * np.array(self.size)) + 0.5)

    def _add_parts(self, pins: Array, limit: float, names: bool) -> None:
        """Add what moves; `picture` puts it in its place."""
        reading, radius = self.reading, JOINT * self.extent
        look: dict[str, Any] = {
            "scalars": "colour",
            "cmap": COLOUR_MAP,
            "clim": (-limit, limit),
            "show_scalar_bar": False,
        }
        self.beams = []
        for of_ring, of_colour in zip(self.rings, self.colours):
            stations, corners, _ = of_ring(0).shape
            beam = pv.PolyData(of_ring(0).reshape(-1, 3), faces=_tube(stations, corners))
            beam["colour"] = of_colour(0).ravel()
            self.plotter.add_mesh(beam, interpolate_before_map=True, **look, **LIGHT)
            self.beams.append(beam)
        thin = {"lighting": False, "line_width": self.size[1] / 450}
        for path in np.moveaxis(pins[:, :, 1], 1, 0) if reading.moves else []:
            closed = path if reading.in_time else np.concatenate([path, path[:1]])
            if np.ptp(path, axis=0).max() > 1e-6 * self.extent:
                self.plotter.add_mesh(pv.lines_from_points(closed), color=SHADE, **thin)
        self.rigid = pv.PolyData(self.over[2](0).reshape(-1, 3), lines=_pairs(len(reading.members)))
        if reading.members:
            self.plotter.add_mesh(self.rigid, color=RIGID, **thin)
        flat = self.over[1](0).reshape(-1, 3)
        bars = [np.append([len(bar)], bar) for bar in reading.bars if len(bar) > 1]
        slides = np.flatnonzero(np.linalg.norm(pins[:, :, 0] - pins[:, :, 1], axis=-1).max(axis=0) > 1e-6 * self.extent)
        lines = np.concatenate([*bars, *([2, 2 * n, 2 * n + 1] for n in slides), []]).astype(int)
        self.bars = pv.PolyData(flat, lines=lines) if len(lines) else None
        if self.bars is not None:
            self.plotter.add_mesh(self.bars, color=RIGID, line_width=self.size[1] / 90, render_lines_as_tubes=True)
        self.balls = []
        for name in reading.joints:
            colour = INK if reading.scene.joints[name].kind == "ball" else "white"
            ball = pv.Sphere(radius=radius, theta_resolution=24, phi_resolution=24)
            self.balls.append((ball, ball.points.copy()))
            self.plotter.add_mesh(ball, color=colour, smooth_shading=True, silhouette=False, **LIGHT)
        self.peak = pv.Sphere(radius=RING * self.extent)
        self.peak_points = self.peak.points.copy()
        if reading.members:
            self.plotter.add_mesh(self.peak, color=PEAK, opacity=0.45, lighting=False)
        together: dict[tuple[int, ...], list[str]] = {}  # names of joints that are at one place
        for name, place in zip(reading.joints if names else (), pins[0, :, 1]):
            together.setdefault(tuple(np.rint(place / radius).astype(int)), []).append(name)
        said = {group[0]: ", ".join(group) for group in together.values()}
        self.names = [self._add_text(said.get(name, ""), 0, 0) for name in reading.joints]
        self.angle = self._add_text("", 0.03, 0.895)

    def picture(self, place: float) -> NDArray[np.uint8]:
        """Render the linkage at a position ``(height, width, 3)``."""
        reading = self.reading
        paths, pins, rigid = (of(place) for of in self.over)
        for beam, of_ring, of_colour in zip(self.beams, self.rings, self.colours):
            beam.points = of_ring(place).reshape(-1, 3)
            beam["colour"] = of_colour(place).ravel()
        if reading.members:
            self.rigid.points = rigid.reshape(-1, 3)
            _, i, j = reading.peak(reading.stress)
            self.peak.points = self.peak_points + paths[i, j]
        if self.bars is not None:
            self.bars.points = pins.reshape(-1, 3)
        for (ball, points), text, pin in zip(self.balls, self.names, pins[:, 1]):
            ball.points = points + pin
            text.position = tuple(self._share(pin) + DRAWN.name)
        at = reading.theta[0] + place * TURN / len(reading.theta) * np.sign(reading.scene.cycle_rate)
        turned = in_degrees(np.radians(round(float(np.degrees(at)), 1)))
        seconds = float(np.interp(place, np.arange(len(reading.time)), reading.time))
        moving = f"{seconds:.4g} s" if reading.in_time else f"drive angle {turned}"
        self.angle.input = moving if reading.moves else "at rest"
        self.plotter.render()
        return self.plotter.screenshot(return_img=True)

    def close(self) -> None:
        """Free the render window."""
        self.plotter.close()

    def _add_bar(self, limit: float, measure: str) -> None:
        """Draw the colour bar in front of all."""
        x, low, high = 1 - 0.8 * DRAWN.bar, 0.22, 0.78
        corners = self._screen(np.array([[x, low], [x + 0.022, low], [x + 0.022, high], [x, high]]))
        bar = pv.PolyData(corners, faces=[4, 0, 1, 2, 3])
        bar["colour"] = np.array([-limit, -limit, limit, limit])
        look: dict[str, Any] = {
            "cmap": COLOUR_MAP,
            "clim": (-limit, limit),
            "show_scalar_bar": False,
            "lighting": False,
        }
        self.plotter.add_mesh(bar, scalars="colour", interpolate_before_map=True, **look)
        for share in np.linspace(0, 1, 5):
            value = limit * (2 * share - 1)
            self._add_text(
                f"{'+' if value > 0 else ''}{short(value)}" if value else "0",
                x + 0.03,
                low + share * (high - low) - 0.011,
            )
        self._add_text(measure, x - 0.04, high + 0.03)

    def _add_texts(self, kind: str, magnify: float) -> None:
        """Write what is drawn, above and below."""
        reading = self.reading
        self._add_text(f"{reading.scene.name}, {reading.driven}", 0.03, 0.94)
        said = ["links do not bend"]
        if reading.members:
            peak = reading.peak(reading.stress)
            value = f"{short(reading.stress[peak])} {reading.units.label('stress')}"
            said = [f"deflection \N{MULTIPLICATION SIGN} {magnify:.4g}; colour: {kind} along the member; grey: rigid"]
            said += [f"orange: largest von Mises stress {value} in {reading.words(peak)}"]
        for line, height in zip(said, (0.015, 0.058)):
            self._add_text(line, 0.03, height)

    def _add_text(self, text: str, x: float, y: float) -> pv.Text:
        font = max(int(min(*self.size * np.array([0.75, 1])) / 65), 4)
        look: dict[str, Any] = {"font_size": font, "font_file": FONT, "color": INK}
        return self.plotter.add_text(text, position=(x, y), viewport=True, **look)


def _finer(values: Array, s: Array) -> Array:
    """Values at more places along a member ``(T, places, ...)``."""
    return np.asarray(CubicSpline(s, values, axis=1)(np.linspace(0, 1, FINER * (len(s) - 1) + 1)))


def _tube(stations: int, corners: int) -> Index:
    """Quadrilaterals between rings of corners, and both ends."""
    ring = np.arange(stations * corners).reshape(stations, corners)
    after = np.roll(ring, -1, axis=1)
    sides = np.stack([ring[:-1], after[:-1], after[1:], ring[1:]], axis=-1).reshape(-1, 4)
    ends = [np.append(corners, ring[0][::-1]), np.append(corners, ring[-1])]
    return np.concatenate([np.column_stack([np.full(len(sides), 4), sides]).ravel(), *ends])


def _pairs(count: int) -> Index:
    return np.column_stack([np.full(count, 2), np.arange(2 * count).reshape(-1, 2)]).ravel()
