"""Checks across the parts of a scene: names that must exist, members that must have a length, mobility."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from fenics_mech.errors import SceneError

if TYPE_CHECKING:
    from fenics_mech.scene.joints import Prismatic, Slot
    from fenics_mech.scene.models import Scene


def check_references(scene: Scene) -> None:
    """Raise `SceneError` where a part of the scene names another that is not there or makes no mechanism."""
    if not scene.members():
        raise SceneError("no link has a member: there is nothing that bends", place="links")
    if "ground" in scene.links:
        raise SceneError("'ground' is the fixed frame's name", place="links.ground", hint="Give the link another name")
    _check_members(scene)
    _check_joints(scene)
    for name, mass in scene.masses.items():
        _check_point(scene, mass.at, f"masses.{name}.at")
        if mass.at.split(".")[0] in scene.links and scene.links[mass.at.split(".")[0]].rigid:
            raise SceneError("its link is rigid", place=f"masses.{name}.at", hint="Add it to the link's `rigid` mass")
        if mass.at.startswith("ground."):
            raise SceneError("a mass on the ground does not move", place=f"masses.{name}.at", hint="Put it on a link")
    for i, measurement in enumerate(scene.measurements):
        _check_name(measurement.member, scene.members(), "member", f"measurements.{i}.member")
    for name, load in scene.loads.items():
        _check_point(scene, load.at, f"loads.{name}.at")
    _check_drives(scene)
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
            if member.material is not None:
                _check_name(member.material, scene.materials, "material", f"{place}.material")
            first, second = (link.points[end] for end in member.ends)
            if math.dist(first, second) == 0:
                raise SceneError("the member has length 0", place=f"{place}.ends", hint="Its two ends must lie apart")
        loose = set(link.points) - {end for member in link.members.values() for end in member.ends}
        if loose and link.members:
            raise SceneError(
                f"point {min(loose)!r} is on no member",
                place=f"links.{label}.points",
                hint="Every point of a link must be an end of one of its members",
            )
        if link.members:
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
            guide = joint.kind in ("slot", "prismatic") and point == joint.connect[0]
            if point in seen and not guide:
                raise SceneError(
                    f"point {point!r} is already in joint {seen[point]!r}",
                    place=place,
                    hint="A pin through several links is one joint that connects all of them",
                )
            if not guide:  # a point of a guide only says where the guide is: other joints may hold it
                seen[point] = name
        if joint.kind in ("slot", "prismatic") and joint.member is not None:
            _check_guide(scene, name, joint, joint.member)
        bodies = [point.split(".")[0] for point in joint.connect]
        if len(set(bodies)) < len(bodies):
            raise SceneError("the joint connects a link with itself", place=place, hint="Connect different links")
    jointed = {point.split(".")[0] for joint in scene.joints.values() for point in joint.connect}
    for body in ("ground", *scene.links):
        if body not in jointed:
            place = "ground" if body == "ground" else f"links.{body}"
            raise SceneError("no joint connects it with the rest", place=place, hint="Add it to a joint")


def _check_guide(scene: Scene, name: str, joint: Slot | Prismatic, member: str) -> None:
    """Raise unless the guide's point is an end of the member that the pin travels along."""
    body, point = joint.connect[0].split(".")
    place = f"joints.{name}.member"
    if body == "ground":
        raise SceneError("the ground has no members", place=place, hint="Give the guide's `angle` instead")
    _check_name(member, scene.links[body].members, f"member of {body}", place)
    if point not in scene.links[body].members[member].ends:
        raise SceneError(f"the guide's point {point!r} is no end of {member!r}", place=f"joints.{name}.connect")


def _check_drives(scene: Scene) -> None:
    """Raise where a drive has no joint of its own, or the drives have no common cycle."""
    seen = set()
    for i, drive in enumerate(scene.drives):
        place = f"drive.{i}" if isinstance(scene.drive, tuple) else "drive"
        _check_name(drive.joint, scene.joints, "joint", f"{place}.joint")
        joint = scene.joints[drive.joint]
        if drive.joint in seen:
            raise SceneError(f"joint {drive.joint!r} is driven twice", place=f"{place}.joint")
        seen.add(drive.joint)
        if joint.kind == "weld":
            raise SceneError("a weld cannot be driven", place=f"{place}.joint")
        if len(joint.connect) != 2:
            raise SceneError("a driven joint must connect two bodies", place=f"joints.{drive.joint}.connect")
        if joint.kind != "revolute" and drive.speed is not None:
            raise SceneError("a stroke cannot go on for ever at one speed", place=f"{place}.speed", hint="Give a law")
        if i and drive.run_up is not None:
            raise SceneError(
                "the run-up is that of the first drive, which the others follow",
                place=f"{place}.run_up",
                hint="Give it to the first drive",
            )
        turns = drive.cycle_rate / scene.cycle_rate
        if abs(turns - round(turns)) > 1e-9 or round(turns) == 0 or (drive.law is not None and round(turns) != 1):
            raise SceneError(
                "the drives have no common cycle: this one's rate must be that of the first, or for a constant "
                f"speed a whole multiple of it, and is {turns:.6g} of it",
                place=place,
            )


def freedoms(scene: Scene) -> int:
    """Freedoms that the joints of a scene leave (Gruebler's count), before any drive."""
    lost = {"revolute": 2, "weld": 3, "slot": 1, "prismatic": 2}
    taken = sum(lost[joint.kind] * (len(joint.connect) - 1) for joint in scene.joints.values())
    return 3 * len(scene.links) - taken


def _check_mobility(scene: Scene) -> None:
    """Raise unless there are as many drives as freedoms; what nothing drives may be held more often than it needs."""
    left, drives = freedoms(scene), len(scene.drives)
    if left > drives or (drives and left != drives):
        raise SceneError(
            f"the linkage is {'under' if left > drives else 'over'}-driven: {len(scene.links)} links and "
            f"{len(scene.joints)} joints leave {left} freedoms, and {drives} are driven",
            place="joints",
            hint="A link has 3 freedoms; a pin of two bodies takes 2, a weld 3, a slot 1, a prismatic joint 2",
        )
