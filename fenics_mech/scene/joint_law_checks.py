"""Checks of joint laws against the rest of a scene, of units at joints, and of scenes in which no link bends."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from fenics_mech.errors import SceneError
from fenics_mech.scene.base import Part, known
from fenics_mech.scene.joint_laws import (
    OPEN,
    TOUCHING,
    AnyJointLaw,
    Friction,
    GuideClearance,
    JointEffort,
    PluggedEffort,
    SideContact,
    Stop,
)
from fenics_mech.scene.paired_joints import Cam, GearPair, PairedJoints
from fenics_mech.scene.scene_data import SceneData
from fenics_mech.scene.units import OfSliding, OfTurning


def check_joint_laws(scene: SceneData) -> None:
    """Raise `SceneError` where a joint law has no joint that it fits, or contradicts another."""
    seen: dict[tuple[str, str], str] = {}
    for name, law in scene.joint_laws.items():
        place = f"joint_laws.{name}"
        joint = known(scene.joints, law.joint, "joint", f"{place}.joint")
        if len(joint.connect) != 2:
            raise SceneError("a joint law acts between two bodies, and the joint has more", place=f"{place}.joint")
        fitting = _fitting(law)
        if joint.kind not in fitting:
            raise SceneError(
                f"a {law.kind} is at a joint of kind {' or '.join(fitting)}, and {law.joint!r} is of kind {joint.kind}",
                place=f"{place}.joint",
            )
        if isinstance(law, Friction):
            _check_friction(law, place, turns=joint.kind == "revolute")
        if isinstance(law, PairedJoints):
            _check_driven(scene, law, place)
        kind = "clearance or bushing" if isinstance(law, OPEN) else law.kind
        if (law.joint, kind) in seen and not isinstance(law, JointEffort | PluggedEffort | PairedJoints):
            raise SceneError(
                f"joint {law.joint!r} has a {kind} already, joint_laws.{seen[law.joint, kind]}", place=place
            )
        seen[law.joint, kind] = name
        if law.joint in scene.open_joints and not isinstance(law, OPEN):
            _refuse_beside_open(law, place)
        if law.joint in scene.open_joints and law.joint in scene.moved_joints:
            what = f"joint {law.joint!r} has no constraint: nothing drives it, and its angle states no freedom"
            raise SceneError(what, place=f"{place}.joint")
        if joint.member is not None and not isinstance(law, SideContact):
            what = f"where a pin travels along a member that bends, as at {law.joint!r}, a side-contact is known alone"
            hint = "Give the guide's link `rigid` instead of members"
            raise SceneError(what, place=f"{place}.joint", hint=hint)


def _fitting(law: AnyJointLaw) -> tuple[str, ...]:
    """Kinds of joints at which a law may be."""
    if isinstance(law, PluggedEffort):
        return law.fits
    if isinstance(law, GuideClearance):
        return ("prismatic",)
    if isinstance(law, SideContact):
        return ("slot",)
    return ("revolute",) if isinstance(law, (*OPEN, PairedJoints)) else ("revolute", "slot", "prismatic")


def _check_friction(law: Friction, place: str, *, turns: bool) -> None:
    """Raise where a pin has no radius at which it rubs, or a slider has one."""
    if turns and law.radius is None:
        raise SceneError(
            "the friction of a pin needs the radius at which it rubs", place=f"{place}.radius", hint="Such as '10 mm'"
        )
    if not turns and law.radius is not None:
        raise SceneError("a slider rubs along its guide, without a radius", place=f"{place}.radius")
    if turns and law.belt_speed:
        raise SceneError("a pin has no belt that runs along it", place=f"{place}.belt_speed")


def _check_driven(scene: SceneData, law: PairedJoints, place: str) -> None:
    """Raise where gears drive no other pin of two bodies, or a cam no other joint."""
    other = known(scene.joints, law.drives, "joint", f"{place}.drives")
    kinds = ("revolute", "slot", "prismatic") if isinstance(law, Cam) else ("revolute",)
    if other.kind not in kinds or len(other.connect) != 2 or law.drives == law.joint:
        moved = "a cam moves a follower on another joint" if isinstance(law, Cam) else "gears turn another pin"
        raise SceneError(f"{moved} of two bodies", place=f"{place}.drives")
    if isinstance(law, Cam) and law.friction and other.kind != "prismatic":
        raise SceneError("a cam rubs on a follower that slides along a prismatic joint", place=f"{place}.friction")
    if isinstance(law, GearPair) and law.pressure_angle is not None:
        _check_gears(scene, law, place)
    if law.drives in scene.open_joints:
        raise SceneError(f"joint {law.drives!r} has no constraint: its place says nothing", place=f"{place}.drives")


def _check_gears(scene: SceneData, law: GearPair, place: str) -> None:
    """Raise where gears whose teeth push each other are not borne by one body, side by side."""
    pins = [scene.joints[name] for name in (law.joint, law.drives)]
    carriers, gears = ({pin.bodies[k] for pin in pins} for k in (0, 1))
    if len(carriers) > 1 or "ground" in gears or len({scene.point(pin.connect[0])[1] for pin in pins}) == 1:
        what = "gears with a pressure angle turn on pins of one body at two places, and are the second bodies there"
        hint = "Order `connect` of both pins so that the body that bears the gears comes first"
        raise SceneError(what, place=f"{place}.pressure_angle", hint=hint)


def _refuse_beside_open(law: AnyJointLaw, place: str) -> None:
    """Raise where a law needs the constraint that a clearance or a bushing has replaced."""
    if isinstance(law, Friction):
        hint = "A clearance has a `friction` of its own"
        raise SceneError(f"joint {law.joint!r} has no constraint whose force could rub", place=place, hint=hint)
    if isinstance(law, Stop):
        raise SceneError(f"joint {law.joint!r} has no constraint, and a stop beside it is not known", place=place)


def check_rigid(scene: SceneData) -> None:
    """Raise `SceneError` where a scene in which no link bends asks for what bends."""
    led, method = bool(scene.drives), scene.analysis.method
    touching = [name for name, law in scene.joint_laws.items() if isinstance(law, TOUCHING)]
    refused = (
        (not led and method not in ("transient", "static"), "analysis.method", "nothing drives the rigid links"),
        (scene.tolerance is not None, "tolerance", "rigid links have no strain, and their motion has `time_tolerance`"),
        (bool(scene.impulses) and method != "transient", "impulses", "impulses on rigid links act in motions in time"),
        (scene.damping.air is not None, "damping.air", "a motion of rigid links has no drag of the air"),
        (any(drive.motor is not None for drive in scene.drives), "drive.motor", "rigid links have no vibration"),
        (
            bool(touching) and method not in ("transient", "static"),
            f"joint_laws.{touching[0] if touching else ''}",
            "bodies that touch move in time: write method = 'transient'",
        ),
    )
    for wrong, place, why in refused:
        if wrong:
            raise SceneError(why, place=place)


def check_units_of_joints(scene: SceneData) -> None:
    """Raise `SceneError` where a quantity of a joint is written in a unit of the other kind of joints."""
    for joint, part, place in _stated(scene):
        slides = scene.joints[joint].kind != "revolute"
        for at, value in with_units(part, place):
            if slides == isinstance(value, OfTurning):
                does, other, right = (
                    ("slides", "turn", "a length (m), a speed (m/s) or a force (N)")
                    if slides
                    else ("turns", "slide", "an angle (rad), a rate of it (rad/s) or a torque (N m)")
                )
                what = f"joint {joint!r} {does}, and the unit is one of joints that {other}"
                hint = f"Write the unit of {right}"
                raise SceneError(what, place=at, hint=hint)


def _stated(scene: SceneData) -> Iterator[tuple[str, Any, str]]:
    """Give every part that states quantities of a joint, with the joint before it and its place behind."""
    for place, drive in scene.drives_by_place.items():
        yield drive.joint, drive, place
    for name, freedom in scene.freedoms.items():
        yield name, freedom, f"freedoms.{name}"
    for name, law in scene.joint_laws.items():
        yield law.drives if isinstance(law, Cam) else law.joint, law, f"joint_laws.{name}"
    section = scene.analysis.poincare
    if section is not None and section.joint is not None:
        yield section.joint, section, "analysis.poincare"


def with_units(part: Any, place: str = "") -> Iterator[tuple[str, float]]:
    """Give quantities in a part that are written in a unit of one kind of joints, with their places."""
    if isinstance(part, OfTurning | OfSliding):
        yield place, part
    elif isinstance(part, Part):
        for name in type(part).model_fields:
            yield from with_units(getattr(part, name), f"{place}.{name}")
    elif isinstance(part, tuple):
        for i, value in enumerate(part):
            yield from with_units(value, f"{place}.{i}")
