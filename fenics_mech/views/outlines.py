"""Outlines of the links at a drive angle, as a drawing for programs of draughtsmen (.dxf)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, count
from pathlib import Path
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import MILLI
from fenics_mech._files import write_whole
from fenics_mech.errors import ViewError
from fenics_mech.kinematics import Motion
from fenics_mech.machine.linkage import solve_motion, start_motion
from fenics_mech.recovery.rigid_places import ends_in
from fenics_mech.scene import Clearance, CustomSection, Friction, Scene, TaperSection, VariableSection
from fenics_mech.views.drawn_parts import pin_places

INSTALL = "a .dxf needs the library ezdxf, which is not installed: pip install 'fenics_mech[sketches]'"
PINS = "pins"  # layer beside those of the links
STATIONS = 65  # along an outline that varies
PIN = 0.01  # of the distance over all pins, the radius of one whose radius is not stated; m where there is one pin
AXIS = {"linetype": "CENTER"}
COLOURS = (
    7,
    1,
    5,
    3,
    6,
    30,
    140,
)  # of layers by the numbers of AutoCAD, seen on white and on black; pins have the first
VERSION = "R2010"  # which all programs of draughtsmen of the last years read


@dataclass(frozen=True)
class Outline:
    """A line of the drawing."""

    link: str  # the link
    places: Array  # its corners (mm), ``(corners, 2)``
    closed: bool = False  # whether it returns to its first corner
    is_axis: bool = False  # whether it is the axis of a member whose outline is drawn too


@dataclass(frozen=True)
class Pin:
    """A joint: its centre (mm), ``(2,)``, and its radius (mm)."""

    centre: Array
    radius: float


def write_outlines(scene: Scene, path: str | Path, angle: float | None = None) -> Path:
    """Write the outlines of the rigid links at a drive angle as a DXF, in mm.

    Each link has a layer of its name. A member is as wide as its section in the plane of motion. Where the section is
    stated by numbers and has no shape, and of links that do not bend, lines between their points are drawn. Pins are
    circles on the layer "pins", of the radius that a friction or a clearance states, or of 1 % of the machine's size.

    Parameters
    ----------
    scene
        The linkage.
    path
        File to write, ending in .dxf.
    angle
        Drive angle (rad); without it the machine is drawn at its start.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    AssemblyError
        When the links cannot be assembled at this angle.
    ViewError
        When the ending is another, ezdxf is not installed, or an angle is given and nothing is driven.
    ResultError
        When the file cannot be written.

    Examples
    --------
    >>> fm.write_outlines(fm.load("demos/slider_crank.toml"), "links.dxf", angle=0.5).name
    'links.dxf'
    """
    path = Path(path)
    if path.suffix.lower() != ".dxf":
        raise ViewError(f"{path}: outlines are written as .dxf, not as {path.suffix!r}")
    if angle is not None and not scene.drives:
        raise ViewError("nothing is driven, so that the outlines have no drive angle: leave the angle out")
    motion = start_motion(scene) if angle is None else solve_motion(scene, np.array([angle]))
    document = _document(list(outlines(scene, motion)), pins(scene, motion), layer_names(scene))
    write_whole(path, document.saveas)
    return path


def outlines(scene: Scene, motion: Motion) -> Iterator[Outline]:
    """Give the lines of the links."""
    for (label, (link, member)), ends in zip(scene.members().items(), ends_in(scene, motion)[0]):
        shaped = _has_a_shape(scene, member.section)
        yield Outline(link, MILLI * ends, is_axis=shaped)
        if not shaped:
            continue
        s = np.linspace(0, 1, 2 if scene.sections[member.section].constant else STATIONS)
        here = scene.rigidity(label, s)
        along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        normal = np.array([-along[1], along[0]])
        line, away = ends[0] + s[:, None] * (ends[1] - ends[0]), here.neutral + here.fibre.T
        first, second = (line + side[:, None] * normal for side in away)
        yield Outline(link, MILLI * np.concatenate([first, second[::-1]]), closed=True)
    for link, body in scene.links.items():
        if body.rigid is not None and len(body.points) > 1:
            corners = np.array([motion.of_point(link, place)[0][0] for place in body.points.values()])
            yield Outline(link, MILLI * corners, closed=len(corners) > 2)


def _has_a_shape(scene: Scene, name: str) -> bool:
    """Whether a section states its shape, and not its area and inertia alone."""
    section = scene.sections[name]
    if isinstance(section, TaperSection):
        section = scene.sections[section.from_]
    return not isinstance(section, CustomSection | VariableSection)


def pins(scene: Scene, motion: Motion) -> list[Pin]:
    """Give the pins."""
    places = pin_places(scene, motion, ends_in(scene, motion))[0]
    size = float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) else 0.0
    stated = {}
    for law in scene.joint_laws.values():
        if isinstance(law, Friction | Clearance) and law.radius is not None:
            stated[law.joint] = law.radius - (law.radial if isinstance(law, Clearance) else 0.0)
    return [
        Pin(MILLI * place, MILLI * stated.get(name, PIN * size or PIN)) for name, place in zip(scene.joints, places)
    ]


def layer_names(scene: Scene) -> dict[str, str]:
    """Name a layer for each link: as the link, with a number where another differs by the case of letters alone."""
    found: dict[str, str] = {}
    taken = {PINS, "defpoints"}  # which programs of draughtsmen do not print
    for link in scene.links:
        numbered = (f"{link}_{number}" for number in count(2))
        found[link] = next(name for name in chain([link], numbered) if name.lower() not in taken)
        taken.add(found[link].lower())
    return found


def _document(lines: list[Outline], circles: list[Pin], layers: dict[str, str]) -> Any:
    """Make the drawing in ezdxf."""
    try:
        import ezdxf  # noqa: PLC0415  (an extra that few need)
        from ezdxf.units import MM  # noqa: PLC0415
    except ImportError as error:
        raise ViewError(INSTALL) from error
    document = ezdxf.new(VERSION, setup=["linetypes"], units=MM)
    for number, layer in enumerate([PINS, *layers.values()]):
        document.layers.add(layer, color=COLOURS[number % len(COLOURS)])
    space = document.modelspace()
    for line in lines:
        look = {"layer": layers[line.link]} | (AXIS if line.is_axis else {})
        space.add_lwpolyline(line.places.tolist(), close=line.closed, dxfattribs=look)
    for pin in circles:
        space.add_circle(pin.centre.tolist(), pin.radius, dxfattribs={"layer": PINS})
    return document
