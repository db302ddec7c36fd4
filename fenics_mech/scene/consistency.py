"""Checks across the parts of a scene: names that must exist, members that must have a length, mobility."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from fenics_mech.errors import SceneError

if TYPE_CHECKING:
    from fenics_mech.scene.models import Scene


def check_references(scene: Scene) -> None:
    """Raise `SceneError` where a part of the scene names another that is not there or makes no mechanism."""
    if "ground" in scene.links:
        raise SceneError("'ground' is the fixed frame's name", place="links.ground", hint="Give the link another name")
    _check_members(scene)
    _check_joints(scene)
    for name, mass in scene.masses.items():
        _check_point(scene, mass.at, f"masses.{name}.at")
        if mass.at.startswith("ground."):
            raise SceneError("a mass on the ground does not move", place=f"masses.{name}.at", hint="Put it on a link")
    for i, measurement in enumerate(scene.measurements):
        _check_name(measurement.member, scene.members(), "member", f"measurements.{i}.member")
    _check_mobility(scene)


def _check_name(name: str, known: Iterable[str], kind: str, place: str) -> None:
    if name not in known:
        raise SceneError(f"there is no {kind} {name!r}", place=place, hint=f"Known: {', '.join(known) or 'none'}")


def _check_point(scene: Scene, name: str, place: str) -> None:
    body, point = name.split(".")
    _check_name(body, ("ground", *scene.links), "link", place)
    points = scene.ground.points if body == "ground" else scene.links[body].points
    _check_name(point, points, f"point of {body}", place)


def _check_members(scene: Scene) -> None:
    for label, link in scene.links.items():
        for name, member in link.members.items():
            place = f"links.{label}.members.{name}"
            for end in member.ends:
                _check_name(end, link.points, f"point of {label}", f"{place}.ends")
            _check_name(member.section, scene.sections, "section", f"{place}.section")
            _check_name(member.material, scene.materials, "material", f"{place}.material")
            first, second = (link.points[end] for end in member.ends)
            if math.dist(first, second) == 0:
                raise SceneError("the member has length 0", place=f"{place}.ends", hint="Its two ends must lie apart")
        loose = set(link.points) - {end for member in link.members.values() for end in member.ends}
        if loose:
            raise SceneError(
                f"point {min(loose)!r} is on no member",
                place=f"links.{label}.points",
                hint="Every point of a link must be an end of one of its members",
            )
        _check_welded(label, [set(member.ends) for member in link.members.values()])


def _check_welded(label: str, groups: list[set[str]]) -> None:
    """Raise where the members of a link fall apart into pieces that share no point."""
    reached = groups[0]
    while any(grown := [group for group in groups if group & reached and not group <= reached]):
        reached = reached.union(*grown)
    if apart := [point for group in groups for point in group if point not in reached]:
        raise SceneError(
            f"point {apart[0]!r} is not connected with the rest of the link",
            place=f"links.{label}.members",
            hint="The members of one link must hang together",
        )


def _check_joints(scene: Scene) -> None:
    seen: dict[str, str] = {}
    for name, joint in scene.joints.items():
        place = f"joints.{name}.connect"
        for point in joint.connect:
            _check_point(scene, point, place)
            if point in seen:
                raise SceneError(
                    f"point {point!r} is already in joint {seen[point]!r}",
                    place=place,
                    hint="A pin through several links is one joint that connects all of them",
                )
            seen[point] = name
        bodies = [point.split(".")[0] for point in joint.connect]
        if len(set(bodies)) < len(bodies):
            raise SceneError("the joint connects a link with itself", place=place, hint="Connect different links")
    _check_name(scene.drive.joint, scene.joints, "joint", "drive.joint")
    if len(scene.joints[scene.drive.joint].connect) != 2:
        raise SceneError("a driven joint must connect two bodies", place=f"joints.{scene.drive.joint}.connect")
    jointed = {point.split(".")[0] for point in seen}
    for body in ("ground", *scene.links):
        if body not in jointed:
            place = "ground" if body == "ground" else f"links.{body}"
            raise SceneError("no joint connects it with the rest", place=place, hint="Add it to a joint")


def _check_mobility(scene: Scene) -> None:
    """Raise unless the linkage has as many freedoms as it has drives (Gruebler's count)."""
    freedoms = 3 * len(scene.links) - sum(2 * (len(joint.connect) - 1) for joint in scene.joints.values())
    if freedoms != 1:
        raise SceneError(
            f"{len(scene.links)} links and {len(scene.joints)} joints leave {freedoms} freedoms, and 1 is driven",
            place="joints",
            hint="Each moving link has 3 freedoms and each revolute joint of two bodies takes 2",
        )
