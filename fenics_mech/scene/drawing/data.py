"""From a scene file with a drawing to the data of a scene file without one."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from fenics_mech.errors import SceneError, shortened
from fenics_mech.scene.drawing.gmsh_files import Drawing, read_drawing
from fenics_mech.scene.drawing.links import DrawnLink, Pin, trace
from fenics_mech.scene.units import in_unit

LINK_KEYS = ("section", "material", "mesh", "members")
MEMBER_KEYS = ("section", "material", "mesh")


def completed(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Replace the key ``drawing`` of a scene file by what is drawn."""
    table = _drawing_table(data["drawing"])
    drawing = read_drawing(folder / table["file"], _unit(table.get("unit", "m")))
    links, pins = trace(drawing)
    given = _given_links(data, drawing, links)
    ground = _table(data.get("ground", {}), "ground")
    points = {name: tuple(drawing.nodes[pin.node].tolist()) for name, pin in pins.items() if pin.on_ground}
    common = {key: value for key, value in table.items() if key in ("section", "material")}
    drawn = {name: _link_data(drawing, name, link, common, given.get(name, {})) for name, link in links.items()}
    rest = {name: link for name, link in data.items() if name != "drawing"}
    return rest | {
        "ground": ground | {"points": points | _table(ground.get("points", {}), "ground.points")},
        "links": drawn | {name: link for name, link in given.items() if name not in links},
        "joints": {name: _joint_data(name, pin) for name, pin in pins.items()}
        | _table(data.get("joints", {}), "joints"),
    }


def _given_links(data: dict[str, Any], drawing: Drawing, links: Iterable[str]) -> dict[str, Any]:
    """Links as the scene file gives them; what it gives must be drawn, or be complete."""
    if "mesh" in data:
        hint = "Give `mesh` to the links that need another, or refine: --refine 1"
        raise SceneError("the drawing gives the elements of its members", place="mesh", hint=hint)
    given = _table(data.get("links", {}), "links")
    for name, link in given.items():
        if name not in links and "points" not in _table(link, f"links.{name}"):
            raise SceneError(
                f"{drawing.file} has no group of lines {name!r}", place=f"links.{name}", hint=_guess(name, links)
            )
    return given


def _drawing_table(value: Any) -> dict[str, str]:
    """Read the value of ``drawing``, a file name or a table of strings."""
    table = {"file": value} if isinstance(value, str) else _table(value, "drawing")
    for key, entry in table.items():
        if key not in ("file", "unit", "section", "material"):
            known = "file, unit, section, material"
            raise SceneError(f"unknown key {key!r}", place=f"drawing.{key}", hint=f"Known: {known}")
        if not isinstance(entry, str):
            raise SceneError(f"must be a string, found {shortened(entry)}", place=f"drawing.{key}")
    if "file" not in table:
        raise SceneError("the drawing's file is missing", place="drawing", hint='Write file = "mechanism.geo"')
    return table


def _unit(text: str) -> float:
    """Length of a unit (m)."""
    try:
        return float(in_unit("m")(f"1 {text}"))
    except ValueError as error:
        raise SceneError(f"{text!r} is no unit of length", place="drawing.unit", hint="Write mm, in or m") from error


def _table(value: Any, place: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise SceneError(f"must be a table, found {shortened(value)}", place=place)
    return value


def _guess(name: str, known: Iterable[str]) -> str:
    """Say which known name may have been meant."""
    near = difflib.get_close_matches(name, list(known), n=1)
    return f"Did you mean {near[0]!r}?" if near else f"Drawn: {', '.join(known)}"


def _link_data(
    drawing: Drawing, name: str, link: DrawnLink, common: dict[str, str], given: dict[str, Any]
) -> dict[str, Any]:
    """Table of a drawn link as a scene file has it."""
    rigid = "rigid" in given
    for key in given:
        if key not in (("rigid", "points") if rigid else LINK_KEYS):
            raise SceneError(
                f"the drawing gives {key!r} of a link"
                if key in ("points", "angle", "position")
                else f"unknown key {key!r}",
                place=f"links.{name}.{key}",
                hint=f"A drawn link has {', '.join(LINK_KEYS)}, or rigid and points",
            )
    origin = drawing.nodes[link.origin]
    points = {point: tuple((drawing.nodes[node] - origin).tolist()) for point, node in link.points.items()}
    table = {"points": points, "angle": 0.0, "position": tuple(origin.tolist())}
    if rigid:
        return table | {
            "points": points | _table(given.get("points", {}), f"links.{name}.points"),
            "rigid": given["rigid"],
        }
    own = _table(given.get("members", {}), f"links.{name}.members")
    for member, values in own.items():
        place = f"links.{name}.members.{member}"
        if member not in link.members:
            message = f"link {name!r} of {drawing.file} has no member {member!r}"
            raise SceneError(message, place=place, hint=_guess(member, link.members))
        for key in _table(values, place):
            if key not in MEMBER_KEYS:
                raise SceneError(
                    f"unknown key {key!r}", place=f"{place}.{key}", hint=f"Known: {', '.join(MEMBER_KEYS)}"
                )
    of_point = {node: point for point, node in reversed(link.points.items())}
    of_link = common | {key: given[key] for key in MEMBER_KEYS if key in given}
    members = {}
    for label, drawn in link.members.items():
        first, last = (of_point[node] for node in drawn.ends)
        values = {"mesh": {"stations": drawn.stations}} | of_link | own.get(label, {})
        if "section" not in values:
            message = f"link {name!r} is drawn in {drawing.file} and has no section"
            hint = f'Write {name} = {{ section = "...", material = "..." }} under [links]'
            raise SceneError(message, place=f"links.{name}", hint=hint)
        members[label] = {"ends": (first, last)} | values
    return table | {"members": members}


def _joint_data(name: str, pin: Pin) -> dict[str, Any]:
    """Table of a pin as a scene file has it."""
    points = tuple(f"{body}.{name}" for body in (("ground",) if pin.on_ground else ()) + pin.links)
    return (
        {"connect": points} if pin.guide is None else {"kind": "slot", "connect": points, "angle": f"{pin.guide!r} deg"}
    )
