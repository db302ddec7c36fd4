"""Checks across the parts of a scene: names that must exist, members that must have a length, mobility."""

from __future__ import annotations

import math
from itertools import pairwise

from fenics_mech.errors import SceneError
from fenics_mech.scene.applied_loads import LineLoad
from fenics_mech.scene.base import check_known, known
from fenics_mech.scene.bodies import MESH, Ground, Link
from fenics_mech.scene.drives import common_rate
from fenics_mech.scene.free_motion_checks import check_freedoms
from fenics_mech.scene.joint_law_checks import check_joint_laws, check_rigid, check_units_of_joints
from fenics_mech.scene.joints import Joint
from fenics_mech.scene.scene_data import SceneData
from fenics_mech.scene.sections import Stock
from fenics_mech.scene.springs_dampers import Hinge, Line


def check_references(scene: SceneData) -> None:
    """Raise `SceneError` where a part of the scene names another that is not there or makes no mechanism."""
    _check_sections(scene)
    _ = scene.answer_units  # which names the unit that is none
    if "ground" in scene.links:
        raise SceneError("'ground' is the fixed frame's name", place="links.ground", hint="Give the link another name")
    _check_members(scene)
    _check_joints(scene)
    for name, mass in scene.masses.items():
        _check_point(scene, mass.at, f"masses.{name}.at")
        body = mass.at.split(".")[0]
        if body == "ground":
            raise SceneError("a mass on the ground does not move", place=f"masses.{name}.at", hint="Put it on a link")
        if scene.links[body].rigid:
            hint = "Add it to the link's `rigid` mass"
            raise SceneError("its link is rigid, and its mass is stated there", place=f"masses.{name}.at", hint=hint)
    for i, measurement in enumerate(scene.measurements):
        check_known(measurement.member, scene.members(), "member", f"measurements.{i}.member")
    for name, point in scene.points.items():
        place = f"points.{name}.at"
        if ("." not in point.at.partition("@")[0] and "@" not in point.at) or point.at.startswith("ground."):
            hint = "Write link.point, or member@0.3 for a place along a member"
            raise SceneError("a traced point is fixed to a link", place=place, hint=hint)
        _check_place(scene, point.at, place, turns=True)
    _check_mesh(scene)
    _check_loads(scene)
    _check_drives(scene)
    if any(drive.motor is not None for drive in scene.drives):
        _check_motor(scene)
    check_freedoms(scene)
    if scene.tolerance is not None and not scene.analysis.error_estimates:
        what = "a tolerance is met by the estimated errors, which are switched off"
        hint = "Leave out one of the two"
        raise SceneError(what, place="analysis.error_estimates", hint=hint)
    for kind in ("springs", "dampers"):
        for name, part in getattr(scene, kind).items():
            (_check_hinge if isinstance(part, Hinge) else _check_line)(scene, part, f"{kind}.{name}")
    check_joint_laws(scene)
    check_units_of_joints(scene)
    _check_mobility(scene)
    if not scene.members():
        check_rigid(scene)


def _check_sections(scene: SceneData) -> None:
    """Raise `SceneError` where a section names what the scene does not have, or a member has no material."""
    stock = Stock(None, scene.materials, scene.sections)
    for name, section in scene.sections.items():
        section.check(f"sections.{name}", stock)
    for link, body in scene.links.items():
        for name, member in body.members.items():
            unnamed = member.material is None and member.section in scene.sections
            if unnamed and not scene.sections[member.section].complete:
                what = f"a member of section {member.section!r} needs a material"
                hint = "Only sections that name the materials of their parts do without"
                raise SceneError(what, place=f"links.{link}.members.{name}.material", hint=hint)


def _check_point(scene: SceneData, name: str, place: str) -> None:
    body = name.split(".", maxsplit=1)[0]
    bodies: dict[str, Ground | Link] = {"ground": scene.ground, **scene.links}
    points = known(bodies, body, "link", place).points
    check_known(name, [f"{body}.{point}" for point in points], "point", place)


def _check_mesh(scene: SceneData) -> None:
    """Raise where a member has more elements, or graded more steeply, than rounding lets be."""
    for label, (_, member) in scene.members().items():
        mesh = member.mesh or scene.mesh
        place = "mesh" if member.mesh is None else f"member {label}"
        if mesh.ratio > MESH.largest_unreduced_ratio * (1 + 1e-9):
            raise SceneError(
                f"the longest element of a member is {mesh.ratio:.3g} times as long as the shortest: beyond "
                f"{MESH.largest_unreduced_ratio:g} the strains would be lost to rounding",
                place=place,
                hint="Take a milder grading",
            )
        if mesh.count > MESH.most_unreduced:
            raise SceneError(
                f"{mesh.count} elements in one member: rounding grows with the 4th power of their number, and beyond "
                f"{MESH.most_unreduced} the strains would lose more than 4 digits",
                place=place,
                hint="Take fewer: one to ten are exact to many digits",
            )


def _check_loads(scene: SceneData) -> None:
    """Raise where a load or an impulse has no place of its own, or does not say what its moment turns."""
    for name, load in scene.loads.items():
        if isinstance(load, LineLoad):
            check_known(load.member, scene.members(), "member", f"loads.{name}.member")
        else:
            _check_place(scene, load.at, f"loads.{name}.at", turns=bool(load.moment or load.follows))
    for name, impulse in scene.impulses.items():
        _check_place(scene, impulse.at, f"impulses.{name}.at", turns=bool(impulse.angular_impulse))
    if scene.impulses and scene.analysis.method not in ("periodic", "transient"):
        what = f"impulses act in motions, and the method is {scene.analysis.method!r}"
        hint = "Write analysis.method = 'periodic' or 'transient', or leave the impulses out"
        raise SceneError(what, place="impulses", hint=hint)
    for label, places in scene.loaded_places().items():
        closest = min((b - a for a, b in pairwise([0.0, *places, 1.0])), default=1.0)
        if closest < MESH.closest:
            raise SceneError(
                f"two of {', '.join(f'{label}@{s:g}' for s in places)} and the member's ends are nearer to each other "
                f"than {MESH.closest:g} of its length",
                place="loads",
                hint="Name the point at the end, or make them one place",
            )


def _check_place(scene: SceneData, at: str, place: str, *, turns: bool) -> None:
    """Raise unless `at` is a point of a link, a pin, or a place along a member."""
    if "@" in at:
        check_known(at.partition("@")[0], scene.members(), "member", place)
    elif "." in at:
        _check_point(scene, at, place)
        if at.startswith("ground."):
            raise SceneError("what acts on the ground has no effect", place=place, hint="Name a point of a link")
    else:
        if known(scene.joints, at, "joint", place).slides or turns:
            hint = "A force in the fixed frame may act at a pin or a weld; else write link.point"
            raise SceneError(f"joint {at!r} does not say which of its bodies is acted on", place=place, hint=hint)


def _check_line(scene: SceneData, line: Line, part: str) -> None:
    """Raise where the two ends of a spring or a damper are one, or can never move against each other."""
    place = f"{part}.between"
    for point in line.between:
        _check_point(scene, point, place)
    (body, first), (other, second) = (scene.point(point) for point in line.between)
    pinned = (joint for joint in scene.joints.values() if joint.kind in ("revolute", "weld"))
    if (body == other and first == second) or any(set(line.between) <= set(joint.connect) for joint in pinned):
        what = f"{line.between[0]} and {line.between[1]} are at one place, and a line between them has no direction"
        hint = "Name points at different places, or give the `joint` of a torsional one"
        raise SceneError(what, place=place, hint=hint)
    if body == other and (body == "ground" or scene.links[body].rigid):
        raise SceneError(f"the two points are of one rigid body, {body}: it would do nothing", place=place)


def _check_hinge(scene: SceneData, hinge: Hinge, part: str) -> None:
    """Raise unless two bodies turn against each other at the joint of a torsional spring or damper."""
    joint = known(scene.joints, hinge.joint, "joint", f"{part}.joint")
    if joint.kind in ("weld", "prismatic"):
        raise SceneError(f"a {joint.kind} joint does not turn", place=f"{part}.joint")
    if joint.kind == "slot" and joint.member is not None:
        what = f"the pin of {hinge.joint!r} travels along a member that bends, where no spring or damper takes hold"
        raise SceneError(what, place=f"{part}.joint")
    if hinge.bodies is None:
        if len(joint.bodies) > 2:
            hint = 'Say which two turn against each other: bodies = ["...", "..."]'
            raise SceneError(f"joint {hinge.joint!r} has the bodies {', '.join(joint.bodies)}", place=part, hint=hint)
        return
    for body in hinge.bodies:
        check_known(body, joint.bodies, f"body of joint {hinge.joint}", f"{part}.bodies")
    if hinge.bodies[0] == hinge.bodies[1]:
        raise SceneError("a body does not turn against itself", place=f"{part}.bodies")


def _check_members(scene: SceneData) -> None:
    for label, link in scene.links.items():
        for name, member in link.members.items():
            place = f"links.{label}.members.{name}"
            for end in member.ends:
                check_known(end, link.points, "point", f"{place}.ends", f" of link {label}")
            check_known(member.section, scene.sections, "section", f"{place}.section")
            if member.material is not None:
                check_known(member.material, scene.materials, "material", f"{place}.material")
            first, second = (link.points[end] for end in member.ends)
            if math.dist(first, second) == 0:
                hint = "Its two ends must be at different places"
                raise SceneError("the member has length 0", place=f"{place}.ends", hint=hint)
        unused = [point for point in sorted(link.points) if link.members and link.end_at(point) is None]
        if unused:
            hint = "Every point of a link must be an end of one of its members, or at the place of such an end"
            raise SceneError(f"point {unused[0]!r} is on no member", place=f"links.{label}.points", hint=hint)
        if link.members:
            _check_welded(label, [set(member.ends) for member in link.members.values()])


def _check_welded(label: str, groups: list[set[str]]) -> None:
    """Raise where the members of a link make several pieces that share no point."""
    reached = groups[0]
    while any(grown := [group for group in groups if group & reached and not group <= reached]):
        reached = reached.union(*grown)
    if separate := [point for group in groups for point in group if point not in reached]:
        what = f"point {separate[0]!r} is not connected with the rest of the link"
        hint = "The members of one link must hang together"
        raise SceneError(what, place=f"links.{label}.members", hint=hint)


def _check_joints(scene: SceneData) -> None:
    seen: dict[str, str] = {}
    for name, joint in scene.joints.items():
        place = f"joints.{name}.connect"
        for point in joint.connect:
            _check_point(scene, point, place)
            guide = joint.slides and point == joint.connect[0]
            if point in seen and not guide:
                raise SceneError(
                    f"point {point!r} is already in joint {seen[point]!r}",
                    place=place,
                    hint="A pin through several links is one joint that connects all of them. A slider that is pinned "
                    "to a link has a second point at the same place for its guide",
                )
            if not guide:  # a point of a guide only says where the guide is: other joints may hold it
                seen[point] = name
        if joint.member is not None:
            _check_guide(scene, name, joint, joint.member)
        if len(set(joint.bodies)) < len(joint.bodies):
            raise SceneError("the joint connects a link with itself", place=place, hint="Connect different links")
    jointed = {body for joint in scene.joints.values() for body in joint.bodies}
    for body in ("ground", *scene.links) if scene.drives else ():  # at rest they may be afloat
        if body not in jointed:
            place = "ground" if body == "ground" else f"links.{body}"
            raise SceneError("no joint connects this link with the linkage", place=place, hint="Add it to a joint")


def _check_guide(scene: SceneData, name: str, joint: Joint, member: str) -> None:
    """Raise unless the guide's point is an end of the member that the pin travels along."""
    body, point = joint.connect[0].split(".")
    place = f"joints.{name}.member"
    if body == "ground":
        raise SceneError("the ground has no members", place=place, hint="Give the guide's `angle` instead")
    check_known(member, scene.links[body].members, f"member of {body}", place)
    if scene.links[body].end_at(point) not in scene.links[body].members[member].ends:
        raise SceneError(f"the guide's point {point!r} is no end of {member!r}", place=f"joints.{name}.connect")


def _check_drives(scene: SceneData) -> None:
    """Raise where a drive has no joint of its own, or the drives have no common cycle."""
    seen = set()
    for i, (place, drive) in enumerate(scene.drives_by_place.items()):
        joint = known(scene.joints, drive.joint, "joint", f"{place}.joint")
        if drive.joint in seen:
            raise SceneError(f"joint {drive.joint!r} is driven twice", place=f"{place}.joint")
        seen.add(drive.joint)
        if joint.kind == "weld":
            raise SceneError("a weld cannot be driven", place=f"{place}.joint")
        if len(joint.connect) != 2:
            raise SceneError("a driven joint must connect two bodies", place=f"joints.{drive.joint}.connect")
        if joint.kind != "revolute" and drive.speed is not None:
            what = "a sliding joint cannot be driven at a constant speed"
            raise SceneError(what, place=f"{place}.speed", hint="Give a law")
        if drive.start and drive.law is not None:
            what = "the start is that of a drive at constant speed, and this one has a law"
            hint = "Put it into the law, such as its `mean`"
            raise SceneError(what, place=f"{place}.start", hint=hint)
        if i and drive.run_up is not None:
            what = "the run-up is that of the first drive, which the others follow"
            hint = "Give it to the first drive"
            raise SceneError(what, place=f"{place}.run_up", hint=hint)
    if not scene.drives:
        return
    try:
        common_rate(scene.drives)
    except ValueError as error:
        hint = "Give speeds and periods whose ratios are those of small whole numbers, to 9 digits"
        raise SceneError(str(error), place="drive", hint=hint) from error


def _check_motor(scene: SceneData) -> None:
    """Raise unless the one drive with its motor turns a crank on the ground, in steady vibration."""
    analysis, (place, drive) = scene.analysis, next(iter(scene.drives_by_place.items()))
    place += ".motor"
    if len(scene.drives) > 1 or drive.speed is None:
        raise SceneError("a motor needs a single drive at constant speed", place=place)
    joint = scene.joints[drive.joint]
    if joint.kind != "revolute" or "ground" not in joint.bodies:
        raise SceneError("a motor must drive a link on a pin of the ground", place=place)
    if analysis.method != "periodic" or analysis.solver not in ("auto", "collocation", "poses") or scene.impulses:
        what = "the twist of a motor's shaft comes with the periodic response by collocation or poses, without impulses"
        hint = "Write analysis.method = 'periodic' and solver = 'collocation', or leave the motor out"
        raise SceneError(what, place=place, hint=hint)


def mobility(scene: SceneData) -> int:
    """Number of freedoms by Gruebler's count, 3 for each link less what the joints take."""
    return 3 * len(scene.links) - sum(joint.takes * (len(joint.connect) - 1) for joint in scene.constraints.values())


def _check_mobility(scene: SceneData) -> None:
    """Raise where there are more drives than freedoms; what nothing drives may be held more often than it needs."""
    left, drives = mobility(scene), len(scene.moved_joints)
    if drives and drives > left:
        raise SceneError(
            f"the linkage is over-driven: {len(scene.links)} links and {len(scene.joints)} joints leave {left} "
            f"{'freedom' if left == 1 else 'freedoms'}, and {drives} are driven",
            place="joints",
            hint="A link has 3 freedoms; a pin of two bodies takes 2, a weld 3, a slot 1, a prismatic joint 2",
        )
