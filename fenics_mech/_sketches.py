"""Sketches of linkages in SVG and DXF files: lines are links, circles are pins.

It is run by the process that reads drawings, whose time and memory are bounded, and imports nothing of the rooms.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from fenics_mech._arrays import Array, Index

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_\-]*")
BY_ITSELF = re.compile(r"(circle|ellipse|g|group|layer|line|path|polygon|polyline|svg|use)[-_]?\d*|0|Defpoints", re.I)
GROUND, GUIDE, POINTS, CONSTRUCTION = "ground", "guide", "points", "construction"  # layers and groups that are no links
DIGITS = 6  # of places, by the size of the sketch: what is drawn is no more exact
LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
INSTALL = "reading a sketch needs the extra `sketches`: pip install 'fenics_mech[sketches]'"
STRAIGHT = "draw links as straight lines and polylines, and pins as circles"
OF_DRAUGHTSMEN = {"TEXT", "MTEXT", "DIMENSION", "HATCH", "POINT", "VIEWPORT", "LEADER", "MULTILEADER", "ATTDEF"}


@dataclass(frozen=True)
class Stroke:
    """A line or polyline, ``(corners, 3)``, and its name, empty where it has none."""

    name: str
    places: Array


@dataclass(frozen=True)
class Circle:
    """A circle: the name of its layer or group, its own name, its centre ``(3,)`` and its radius."""

    layer: str
    name: str
    centre: Array
    radius: float


def groups_of_sketch(path: Path) -> tuple[Array, dict[str, Index], dict[str, Index], list[str]]:
    """Read a sketch, and give nodes, lines of links and named points, as the reader of drawings gives them."""
    try:
        found = list(_of_svg(path) if path.suffix == ".svg" else _of_dxf(path))
    except ImportError as error:
        raise ValueError(INSTALL) from error
    drawn = [one for one in found if isinstance(one, Stroke)]
    strokes, guides = ([one for one in drawn if (one.name == GUIDE) == guide] for guide in (False, True))
    circles = [one for one in found if isinstance(one, Circle)]
    if not strokes:
        raise ValueError(f"it has no straight lines: {STRAIGHT}")
    if any(circle.radius <= 0 for circle in circles):
        raise ValueError("a circle has no radius")
    if not any(circle.layer == GROUND for circle in circles):
        raise ValueError("no circle is on the frame: put those that are into a group or layer named `ground`")
    return _joined(strokes, circles, guides)


def _joined(
    strokes: list[Stroke], circles: list[Circle], guides: list[Stroke]
) -> tuple[Array, dict[str, Index], dict[str, Index], list[str]]:
    """Find which lines make a link, which meet at a pin, and which pins slide."""
    places = np.concatenate([stroke.places for stroke in strokes])
    size = float(np.ptp(places[:, :2], axis=0).max()) or 1.0
    if not np.isfinite(size):
        raise ValueError("a place is not a finite number")
    decimals = DIGITS - 1 - math.floor(math.log10(size))
    nodes, pins = _pins(circles, decimals)
    known = {tuple(node): i for i, node in enumerate(nodes)}
    chains = []
    for stroke in strokes:
        chain: list[int] = []
        for place in np.round(stroke.places, decimals) + 0.0:
            pin = _inside(place, pins)
            node = known.setdefault(tuple(place.tolist()), len(nodes)) if pin is None else pin
            if node == len(nodes):
                nodes.append(tuple(place.tolist()))
            chain += [] if chain and chain[-1] == node else [*_passed(chain, node, nodes, pins), node]
        chains.append(chain)
    of_link: dict[str, list[tuple[int, int]]] = {}
    for name, chain in zip(_names_of_links(strokes, chains, len(pins)), chains):
        of_link.setdefault(name, []).extend(pairwise(chain))
    lines = {name: np.array(pairs, dtype=np.int64).reshape(-1, 2) for name, pairs in of_link.items()}
    return np.array(nodes), lines, _named_points(pins, lines, _angles(guides, nodes, pins)), []


def _pins(circles: list[Circle], decimals: int) -> tuple[list[tuple[float, ...]], list[Circle]]:
    """Give the centres and the pins; circles about one centre are one pin."""
    nodes: list[tuple[float, ...]] = []
    pins: list[Circle] = []
    for circle in sorted(circles, key=lambda one: one.layer != GROUND):  # of several, that of the frame says what it is
        if _inside(circle.centre, pins) is None:
            nodes.append(tuple((np.round(circle.centre, decimals) + 0.0).tolist()))
            pins.append(circle)
    return nodes, pins


def _inside(place: Array, pins: list[Circle]) -> int | None:
    """Give the pin in whose circle a place lies."""
    away = [math.dist(place[:2], pin.centre[:2]) / pin.radius for pin in pins]
    return int(np.argmin(away)) if away and min(away) < 1 else None


def _passed(chain: list[int], node: int, nodes: list[tuple[float, ...]], pins: list[Circle]) -> list[int]:
    """Give the pins through whose circles a line passes on its way to a node, in their order."""
    if not chain:
        return []
    start, end = (np.array(nodes[i][:2]) for i in (chain[-1], node))
    along, found = end - start, []
    for i, pin in enumerate(pins):
        s = float((pin.centre[:2] - start) @ along / (along @ along or 1.0))
        if i not in (chain[-1], node) and 0 < s < 1 and math.dist(start + s * along, pin.centre[:2]) < pin.radius:
            found.append((s, i))
    return [i for _, i in sorted(found)]


def _angles(guides: list[Stroke], nodes: list[tuple[float, ...]], pins: list[Circle]) -> dict[int, float]:
    """Give the angle (deg) of the guide of each pin that slides: a straight line that meets its circle alone."""
    angles: dict[int, float] = {}
    for guide in guides:
        (x, y), end = guide.places[0][:2], guide.places[-1][:2]
        along = end - (x, y)
        ends = [_inside(place, pins) for place in guide.places]
        # The corners of the line's two ends come after all nodes, as if they were drawn.
        met = {*_passed([len(nodes)], len(nodes) + 1, [*nodes, (x, y), tuple(end)], pins), *ends} - {None}
        where = f"the guide at ({x:g}, {y:g})"
        if len(guide.places) != 2 or not along.any():
            raise ValueError(f"{where} is no straight line")
        if len(met) != 1:
            raise ValueError(f"{where} meets {len(met)} circles: it must meet that of the pin which slides on it")
        (pin,) = (i for i in met if i is not None)
        if pin in angles or pins[pin].layer == GROUND:
            raise ValueError(f"{where} is of a pin that is on the frame, or on another guide")
        angles[pin] = round(math.degrees(math.atan2(along[1], along[0])), DIGITS)
    return angles


def _names_of_links(strokes: list[Stroke], chains: list[list[int]], pins: int) -> list[str]:
    """Name the link of each stroke: by its own name; others, which share an end that is no pin, by a number."""
    leader = list(range(len(strokes)))

    def first(i: int) -> int:
        while leader[i] != i:
            i = leader[i]
        return i

    at: dict[int, int] = {}
    for i, (stroke, chain) in enumerate(zip(strokes, chains)):
        if not stroke.name:
            for node in (node for node in chain if node >= pins):
                leader[first(i)] = first(at.setdefault(node, i))
    taken, numbers = {stroke.name for stroke in strokes}, dict[int, int]()
    names = []
    for i, stroke in enumerate(strokes):
        number = numbers.setdefault(first(i), len(numbers) + 1) if not stroke.name else 0
        names.append(stroke.name or _free(f"link{number}", taken))
    return names


def _free(name: str, taken: set[str]) -> str:
    """Lengthen a name until it is not taken."""
    while name in taken:
        name += "_"
    return name


def _named_points(pins: list[Circle], lines: dict[str, Index], guides: dict[int, float]) -> dict[str, Index]:
    """Name the pins as groups of a drawing are named."""
    taken = {pin.name for pin in pins}
    letters = (name for k in range(len(pins) + 27) if (name := chr(65 + k) if k < 26 else f"P{k}") not in taken)
    found = {}
    for node, pin in enumerate(pins):
        met = sum(bool((cells == node).any()) for cells in lines.values())
        kind = GROUND if pin.layer == GROUND else "point" if pin.layer == POINTS or met == 1 else "joint"
        name = pin.name or next(letters)
        group = f"slide {name} {guides[node]:.{DIGITS}f}" if node in guides else f"{kind} {name}"
        found[group] = np.array([node], dtype=np.int64)
    return found


def _own_name(*names: str | None) -> str:
    """Give the first name that a person has given, and that can name a link or a point."""
    return next((name for name in names if name and NAME.fullmatch(name) and not BY_ITSELF.fullmatch(name)), "")


def _of_svg(path: Path) -> Iterator[Stroke | Circle]:
    """Read an SVG: without entities, which could fill the memory or name other files."""
    import defusedxml.ElementTree as Safe  # noqa: PLC0415
    import svgelements  # noqa: PLC0415

    content = path.read_bytes()
    try:
        Safe.fromstring(content)
    except Safe.ParseError as error:
        raise ValueError(f"it is no SVG: {error}") from error
    picture = svgelements.SVG.parse(io.BytesIO(content), reify=True, ppi=25.4)  # a pixel is then 1 mm
    if not isinstance(picture, svgelements.SVG):
        raise ValueError("it is no SVG: its outermost element is another")
    yield from _of_group(picture, "", svgelements)


def _of_group(group: Any, layer: str, svg: Any) -> Iterator[Stroke | Circle]:
    """Read what stands in a group of an SVG, as a part of the layer that it names."""
    for part in group:
        said = part.values.get("attributes", {}) if hasattr(part, "values") else {}
        own = _own_name(said.get(LABEL), said.get("id"))
        if part.values.get("display") == "none" or CONSTRUCTION in (layer, own):
            continue
        if isinstance(part, svg.Group):
            yield from _of_group(part, own or layer, svg)
        elif isinstance(part, svg.Circle | svg.Ellipse):
            centre, radius = part.implicit_center, float(part.implicit_rx)  # as groups turn, move and scale it
            if not math.isclose(radius, part.implicit_ry, rel_tol=1e-3):
                raise ValueError(f"it has an ellipse: {STRAIGHT}")
            yield Circle(layer, own, np.array([centre.x, -centre.y, 0.0]), radius)
        elif isinstance(part, svg.Shape):
            name = GUIDE if layer == GUIDE else own or ("" if layer in (GROUND, POINTS) else layer)
            yield from _strokes(part, name, svg)


def _strokes(shape: Any, name: str, svg: Any) -> Iterator[Stroke]:
    """Read the straight lines of a shape of an SVG, whose y axis points down."""
    for part in svg.Path(shape).as_subpaths():
        places = []
        for segment in part:
            if not isinstance(segment, svg.Move | svg.Line | svg.Close):
                raise ValueError(f"it has a curve: {STRAIGHT}")
            if segment.end is not None:
                places.append((segment.end.x, -segment.end.y, 0.0))
        if len(places) > 1:
            yield Stroke(name, np.array(places))


def _of_dxf(path: Path) -> Iterator[Stroke | Circle]:
    """Read the model space of a DXF; layers that are off or frozen are not seen."""
    import ezdxf  # noqa: PLC0415

    document = ezdxf.readfile(path)
    hidden = {layer.dxf.name for layer in document.layers if layer.is_off() or layer.is_frozen()}
    for part in document.modelspace():
        layer, kind = part.dxf.layer, part.dxftype()
        if layer in hidden or layer == CONSTRUCTION or kind in OF_DRAUGHTSMEN:
            continue
        name = "" if layer in (GROUND, POINTS) else _own_name(layer)
        if kind == "CIRCLE":
            centre = part.ocs().to_wcs(part.dxf.center)  # a circle that was mirrored has axes of its own
            yield Circle(layer, "", np.array(centre), float(part.dxf.radius))
        elif kind == "LINE":
            yield Stroke(name, np.array([part.dxf.start, part.dxf.end]))
        elif kind in ("LWPOLYLINE", "POLYLINE") and not part.has_arc:
            points = part.vertices_in_wcs() if kind == "LWPOLYLINE" else part.points()
            places = [tuple(point) for point in points]
            yield Stroke(name, np.array([*places, *places[:1]] if part.is_closed else places, dtype=float))
        else:
            raise ValueError(f"it has {kind} on layer {layer!r}: {STRAIGHT}")
