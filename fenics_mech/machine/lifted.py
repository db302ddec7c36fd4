"""A planar scene stated in space: the same links, drawn at the start of the cycle, with all that they can do there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.machine.drawn_from_scene import bodies_of
from fenics_mech.scene import Scene
from fenics_mech.scene.applied_loads import Load
from fenics_mech.scene.in_space import SpatialScene
from fenics_mech.scene.joints import Prismatic, Revolute, Weld
from fenics_mech.scene.sections import ISection, RectangleSection, RoundSection, TubeSection
from fenics_mech.scene.springs_dampers import HingeDamper, HingeSpring
from fenics_mech.scene.state_factors import StateFactor

UNSTATED = "impulses", "joint_laws", "freedoms"  # tables that have no counterpart in space yet
SHAPES = RectangleSection, RoundSection, TubeSection, ISection
Z = [0.0, 0.0, 1.0]


def lifted(scene: Scene) -> SpatialScene:
    """State a planar scene in space: pins turn about Z, guides lie in the plane, and sections have their widths.

    Parameters
    ----------
    scene
        The scene.

    Raises
    ------
    SceneError
        When it has what cannot be stated in space, such as a section whose width is not known.

    Examples
    --------
    >>> from fenics_mech.machine.lifted import lifted
    >>> lifted(fm.load("demos/slider_crank.toml")).joints["A"].axis
    (0.0, 0.0, 1.0)
    """
    _refuse(scene)
    frames = bodies_of(scene).frames()

    def place(body: str, point: Any) -> list[float]:
        origin, axes = frames[body]
        return [*(origin + axes @ np.array(point)).tolist(), 0.0]

    def points(body: str) -> dict[str, list[float]]:
        own = (scene.ground if body == "ground" else scene.links[body]).points
        return {name: place(body, point) for name, point in own.items()}

    links: dict[str, Any] = {}
    for name, link in scene.links.items():
        links[name] = {"points": points(name)}
        if link.rigid is not None:  # its extent across the plane is not known: that of a lamina
            inertia = link.rigid.inertia
            links[name]["rigid"] = {
                "mass": link.rigid.mass,
                "inertia": [inertia / 2, inertia / 2, inertia],
                "centre": place(name, link.rigid.centre),
            }
            continue
        used = {end for member in link.members.values() for end in member.ends}
        links[name]["points"] = {point: at for point, at in links[name]["points"].items() if point in used}
        links[name]["members"] = {
            label: {
                "ends": member.ends,
                "section": member.section,
                "material": member.material,
                "up": _normal(links[name]["points"], member.ends),
                "elements": None if member.mesh is None else member.mesh.count,
            }
            for label, member in link.members.items()
        }
    data = {
        "name": scene.name,
        "units": scene.units,
        "materials": {name: part.model_dump(by_alias=True) for name, part in scene.materials.items()},
        "sections": {name: part.model_dump() for name, part in scene.sections.items() if isinstance(part, SHAPES)},
        "ground": {"points": points("ground")},
        "links": links,
        "joints": _joints(scene, lambda body: frames[body][1]),
        "masses": {name: {"at": mass.at, "mass": mass.mass} for name, mass in scene.masses.items()},
        "gravity": [*scene.gravity, 0.0],
        "loads": {name: _load(scene, load) for name, load in scene.loads.items()},
        "springs": {name: spring.model_dump() for name, spring in scene.springs.items()},
        "dampers": {name: damper.model_dump() for name, damper in scene.dampers.items()},
        "drive": [drive.model_copy(update={"start": 0.0}).model_dump() for drive in scene.drives],
        "damping": scene.damping.model_dump(exclude={"air"}),
        "mesh": {"elements": scene.mesh.count},
        "analysis": {"method": scene.analysis.method, "allow_unstable": True},
    }
    return SpatialScene.read(data)


def _normal(points: dict[str, list[float]], ends: tuple[str, str]) -> list[float]:
    """Give the direction in the plane 90 degrees counter-clockwise of a member, along which its section is high."""
    (x, y, _), (x2, y2, _) = (points[end] for end in ends)
    return [y - y2, x2 - x, 0.0]


def _joints(scene: Scene, axes_of: Callable[[str], Array]) -> dict[str, Any]:
    """State pins, guides and welds in space; a pin of several links is one to each but the first."""
    made: dict[str, Any] = {}
    for name, joint in scene.joints.items():
        first, *others = joint.connect
        for other in others:
            one = name if len(others) == 1 else f"{name}-{other.split('.')[0]}"
            made[one] = {"connect": [first, other]}
            if isinstance(joint, Revolute):
                made[one] |= {"axis": Z}
            elif isinstance(joint, Weld):
                made[one] |= {"kind": "weld"}
            else:
                along = axes_of(first.split(".")[0]) @ [np.cos(joint.angle), np.sin(joint.angle)]
                kind = "slider" if isinstance(joint, Prismatic) else "slot"
                made[one] |= {"kind": kind, "axis": [*along.tolist(), 0.0]}
    return made


def _load(scene: Scene, load: Any) -> dict[str, Any]:
    at = load.at
    if at in scene.joints:
        at = next(point for point in scene.joints[at].connect if not point.startswith("ground."))
    factor = None if load.factor is None else load.factor.model_dump()
    return {"at": at, "force": [*load.force, 0.0], "factor": factor}


def _refuse(scene: Scene) -> None:
    """Raise `SceneError` where something of a planar scene has no counterpart in space."""

    def refuse(what: str, place: str) -> None:
        raise SceneError(f"{what} cannot be stated in space yet", place=place)

    for table in UNSTATED:
        if getattr(scene, table):
            refuse(f"[{table}]", table)
    for label, (link, member) in scene.members().items():
        if not isinstance(scene.sections[member.section], SHAPES):
            raise SceneError(
                f"section {member.section!r} of member {label} has no known width across the plane",
                place=f"sections.{member.section}",
                hint="Give it by its shape: rectangle, round, tube or I",
            )
        if member.offset:
            refuse("a member beside the line through its points", f"links.{link}")
    for name, load in scene.loads.items():
        if not isinstance(load, Load) or load.moment or load.follows or isinstance(load.factor, StateFactor):
            refuse("a load that is spread, follows, is a moment, or goes by a joint", f"loads.{name}")
    for table in ("springs", "dampers"):
        for name, part in getattr(scene, table).items():
            several = isinstance(part, HingeSpring | HingeDamper) and len(scene.joints[part.joint].connect) > 2
            if several or (isinstance(part, HingeSpring) and part.angle is not None):
                refuse("a spring or damper at a pin of several links, or with a free angle", f"{table}.{name}")
    for name, joint in scene.joints.items():
        if joint.member is not None:
            refuse("a pin that rides along a member", f"joints.{name}")
    for drive in scene.drives:
        if drive.motor is not None or drive.run_up is not None:
            refuse("a motor or a run-up", "drive")
    if scene.damping.air is not None:
        refuse("drag of the air", "damping.air")
