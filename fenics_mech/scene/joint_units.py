"""Units of what drives, freedoms and joint laws state: each is to be one of the joint, which turns or slides."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from fenics_mech.errors import SceneError
from fenics_mech.scene.base import Part
from fenics_mech.scene.paired_joints import Cam
from fenics_mech.scene.scene_data import SceneData
from fenics_mech.scene.units import OfSliding, OfTurning


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
    for i, drive in enumerate(scene.drives):
        yield drive.joint, drive, f"drive.{i}" if isinstance(scene.drive, tuple) else "drive"
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
