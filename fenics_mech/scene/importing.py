"""Scenes from drawings, sketches, and linkages of pylinkage: what they do not state is assumed, and said."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

from fenics_mech._files import read_bounded, reason_of
from fenics_mech.errors import SceneError
from fenics_mech.scene.base import SCENE, check_texts
from fenics_mech.scene.models import Scene
from fenics_mech.scene.writing import text_of

ASSUMED: dict[str, Any] = {  # what neither a drawing nor pylinkage knows
    "effects": "auto",  # slow links of bars do not vibrate
    "materials": {"steel": {"modulus": "207 GPa", "density": "7800 kg/m^3"}},
    "sections": {"bar": {"shape": "rectangle", "width": "15 mm", "height": "6 mm"}},
}
SPEED = "60 rpm"
OF_MEMBERS = {"section": "bar", "material": "steel"}
HEAD = """# Made from {file} by `fenics-mech import`.
# Assumed: the material, the section of all members, the driven joint and its speed. Correct them.

"""
ONE_ELEMENT = {"stations": (0.0, 1.0)}  # of a member, which is what a scene has by itself
LARGEST = 5_000_000  # bytes of a file of pylinkage


def from_drawing(path: str | Path, unit: str = "mm") -> Scene:
    """Make a scene from a sketch (.svg, .dxf) or a drawing (.geo, .msh, .inp); steel bars at 60 rpm are assumed.

    Parameters
    ----------
    path
        The file.
    unit
        Unit of its lengths.

    Returns
    -------
    Scene
        The scene; the first pin of the frame drives it.

    Raises
    ------
    SceneError
        When the file cannot be read, or is no linkage.

    Examples
    --------
    >>> scene = fm.from_drawing("meshes/four_bar.geo").changed({"drive.speed": "340 rpm"})
    >>> list(scene.links)
    ['crank', 'coupler', 'follower']
    """
    return Scene.read(drawn(Path(path), unit))


def from_pylinkage(mechanism: Any, unit: str = "m") -> Scene:
    """Make a scene from a Mechanism or Linkage of pylinkage, as it stands; steel bars at 60 rpm are assumed.

    Parameters
    ----------
    mechanism
        A `Mechanism` or `Linkage`, or the dictionary that pylinkage's `mechanism_to_dict` gives.
    unit
        Unit of its lengths.

    Returns
    -------
    Scene
        The scene. A link of three or more joints has a member from each to the next, and back to the first.

    Raises
    ------
    SceneError
        When it has what a scene cannot state.

    Examples
    --------
    >>> from pylinkage.mechanism import fourbar
    >>> list(fm.from_pylinkage(fourbar(crank=1, coupler=3, rocker=3, ground=4), unit="cm").links)
    ['crank', 'coupler', 'rocker']
    """
    if isinstance(mechanism, dict):
        return Scene.read(linked(mechanism, unit))
    try:
        from pylinkage.dyads import to_mechanism  # noqa: PLC0415
        from pylinkage.mechanism.serialization import mechanism_to_dict  # noqa: PLC0415

        mechanism = to_mechanism(mechanism) if hasattr(mechanism, "components") else mechanism
        return Scene.read(linked(mechanism_to_dict(mechanism), unit))
    except (ImportError, AttributeError) as error:
        raise SceneError(f"this is no Mechanism of pylinkage: {error}", place="pylinkage") from error


def imported(path: Path, unit: str | None) -> str:
    """Give the text of a scene file, which states what a drawing or a file of pylinkage (.json) has."""
    data = linked(_read_json(path), unit or "m") if path.suffix == ".json" else drawn(path, unit or "mm")
    Scene.read(data)
    return HEAD.format(file=path.name) + text_of(_plain(data))


def drawn(path: Path, unit: str) -> dict[str, Any]:
    """Give the data of a scene from a drawing."""
    from fenics_mech.scene.drawing import completed  # noqa: PLC0415  (most scenes have none)

    table = {"file": path.name, "unit": unit} | OF_MEMBERS
    data = {"name": path.stem[: SCENE.longest_name]} | ASSUMED | completed({"drawing": table}, path.parent)
    if not (frame := data["ground"]["points"]):
        raise SceneError(f"{path.name}: no pin is on the frame", place="drawing", hint='Name one as "ground O"')
    return data | {"drive": {"joint": next(iter(frame)), "speed": SPEED}}


def _read_json(path: Path) -> dict[str, Any]:
    """Read a file of pylinkage."""
    try:
        data = json.loads(read_bounded(path, LARGEST))
    except (OSError, ValueError, RecursionError) as error:
        reason = reason_of(error) if isinstance(error, OSError | ValueError) else "it is nested too deeply"
        raise SceneError(f"cannot read {path.name}: {reason}", place=path.name) from error
    if not isinstance(data, dict) or not {"joints", "links"} <= data.keys():
        hint = "It is written by mechanism_to_json of pylinkage.mechanism"
        raise SceneError(f"{path.name} is no mechanism of pylinkage", place=path.name, hint=hint)
    return data


def linked(data: dict[str, Any], unit: str) -> dict[str, Any]:
    """Give the data of a scene from what pylinkage writes about a mechanism."""
    check_texts(data, ("pylinkage",))
    try:
        return _linked(data, unit)
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        said = f"{type(error).__name__}: {error}"
        raise SceneError(f"this is no mechanism that pylinkage has written ({said})", place="pylinkage") from error


def _with_names(data: dict[str, Any]) -> dict[str, Any]:
    """Give joints and links, which pylinkage calls `crank.tip` and so on, names that a scene takes."""
    names: dict[str, str] = {}
    for part in (*data["joints"], *data["links"]):
        name = re.sub(r"[^A-Za-z0-9_\-]", "_", re.sub(r"^(?![A-Za-z_])", "_", part["id"]))
        while name in names.values():
            name += "_"
        names[part["id"]] = name
    links = [link | {"id": names[link["id"]], "joints": [names[j] for j in link["joints"]]} for link in data["links"]]
    for link in links:
        if link.get("motor_joint"):
            link["motor_joint"] = names[link["motor_joint"]]
    return data | {"joints": [joint | {"id": names[joint["id"]]} for joint in data["joints"]], "links": links}


def _linked(data: dict[str, Any], unit: str) -> dict[str, Any]:
    data = _with_names(data)
    joints = {joint["id"]: joint for joint in data["joints"] if joint["type"] != "tracker"}
    on_frame = {name for link in data["links"] if link["type"] == "ground" for name in link["joints"]}
    frame = [name for name, joint in joints.items() if joint["type"] == "ground" or name in on_frame]
    links = {link["id"]: link for link in data["links"] if link["type"] != "ground"}
    drivers = [link for link in links.values() if link["type"] == "driver"]
    if len(drivers) != 1:
        swings = any(link["type"] == "arc_driver" for link in links.values())
        arcs = " One that swings (arc_driver) is not taken over." * swings
        raise SceneError(f"one driver link is expected, and there are {len(drivers)}.{arcs}", place="pylinkage")

    def length(value: float) -> str:
        return f"{float(value)!r} {unit}"

    points = {name: tuple(map(length, joint["position"])) for name, joint in joints.items()}
    rails = {name: joint for name, joint in joints.items() if joint["type"] == "prismatic"}
    ground = {name: points[name] for name in frame}
    ground |= {name: tuple(map(length, joint["line_point"])) for name, joint in rails.items()}
    made: dict[str, Any] = {}
    for name, joint in joints.items():
        bodies = ["ground"] * (name in ground) + [label for label, link in links.items() if name in link["joints"]]
        if len(bodies) > 1:
            made[name] = {"connect": [f"{body}.{name}" for body in bodies]}
        if name in rails:
            x, y = joint["axis"]
            made[name] |= {"kind": "slot", "angle": math.atan2(y, x)}
    return {
        "name": str(data.get("name") or "linkage")[: SCENE.longest_name],
        **ASSUMED,
        "ground": {"points": ground},
        "links": {name: _link(joints, link["joints"], length) for name, link in links.items()},
        "joints": made,
        "drive": {"joint": drivers[0]["motor_joint"], "speed": SPEED},
    }


def _link(joints: dict[str, Any], names: list[str], length: Any) -> dict[str, Any]:
    """Give a link whose frame stands as the linkage does, with its origin in its first joint."""
    x, y = joints[names[0]]["position"]
    places = {name: joints[name]["position"] for name in names}
    pairs = list(zip(names, [*names[1:], names[0]]))[: len(names) if len(names) > 2 else 1]
    return {
        "angle": 0.0,
        "position": [length(x), length(y)],
        "points": {name: [length(a - x), length(b - y)] for name, (a, b) in places.items()},
        "members": {f"{a}-{b}": {"ends": [a, b]} | OF_MEMBERS for a, b in pairs},
    }


def _plain(part: Any) -> Any:
    """Turn tuples into lists, as TOML has them, and leave out what rounding adds to numbers."""
    if isinstance(part, dict):
        kept = {key: value for key, value in part.items() if value != ONE_ELEMENT}
        return {key: _plain(value) for key, value in kept.items()}
    if isinstance(part, list | tuple):
        return [_plain(value) for value in part]
    return float(f"{part:.12g}") if isinstance(part, float) else part
