"""Joints: what holds two or more bodies together, and what a drive does to one of them."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag

from fenics_mech.scene.base import Name, Part, PointName
from fenics_mech.scene.design import Pin
from fenics_mech.scene.units import Angle


class Connection(Part):
    """What all joints have in common: points that they connect, and what they hold there."""

    takes: ClassVar[int]  # freedoms in the plane, of each body but the first
    slides: ClassVar[bool] = False  # its drive leads a stroke (m), and no angle (rad)
    kind: str
    connect: tuple[PointName, ...]

    @property
    def bodies(self) -> list[str]:
        """Bodies of the points."""
        return [point.split(".")[0] for point in self.connect]


class Revolute(Connection):
    """A pin through two or more points.

    Parameters
    ----------
    connect
        The points, as "link.point" or "ground.point".
    pin
        Its pin and eyes, by which the verdict judges them.

    Examples
    --------
    >>> fm.Revolute(connect=("crank.A", "coupler.A")).kind
    'revolute'
    """

    takes = 2
    member: ClassVar[None] = None  # along which no pin travels, as in a slot
    kind: Literal["revolute"] = "revolute"
    connect: Annotated[tuple[PointName, ...], Field(min_length=2)]
    pin: Pin | None = None


class Weld(Connection):
    """Two points and the rotations of their bodies made one; on the ground it is a fixed support.

    Parameters
    ----------
    connect
        The two points.
    angle
        Angle of the second body's frame in the first's (rad).

    Examples
    --------
    >>> round(fm.Weld(connect=("ground.base", "arm.base"), angle="90 deg").angle, 4)
    1.5708
    """

    takes = 3
    member: ClassVar[None] = None
    kind: Literal["weld"] = "weld"
    connect: tuple[PointName, PointName]
    angle: Angle = 0.0


class Slot(Connection):
    """A pin of the second body that slides along a straight guide of the first and may turn; a roller on the ground.

    Parameters
    ----------
    connect
        A point of the guide on the first body, and the pin on the second.
    angle
        Direction of the guide in the first body's frame (rad).
    member
        Instead of an angle: the member of the first body along whose bent axis the pin travels.

    Examples
    --------
    >>> fm.Slot(connect=("ground.G", "rod.B"), angle=0.0).kind
    'slot'
    """

    takes, slides = 1, True
    kind: Literal["slot"] = "slot"
    connect: tuple[PointName, PointName]
    angle: Angle = 0.0
    member: Name | None = None


class Prismatic(Connection):
    """A slot in which the second body cannot turn against the first.

    Parameters
    ----------
    connect, angle, member
        As of a slot.
    turn
        Angle of the second body's frame in the first's (rad).

    Examples
    --------
    >>> fm.Prismatic(connect=("rocker.C", "block.P"), member="CD").member
    'CD'
    """

    takes, slides = 2, True
    kind: Literal["prismatic"] = "prismatic"
    connect: tuple[PointName, PointName]
    angle: Angle = 0.0
    member: Name | None = None
    turn: Angle = 0.0


def _kind(value: Any) -> Any:
    return value.get("kind", "revolute") if isinstance(value, dict) else getattr(value, "kind", None)


Joint = Annotated[
    Annotated[Revolute, Tag("revolute")]
    | Annotated[Weld, Tag("weld")]
    | Annotated[Slot, Tag("slot")]
    | Annotated[Prismatic, Tag("prismatic")],
    Discriminator(_kind),
]


def members_under_pins(joints: Mapping[str, Joint], members: Container[str]) -> dict[str, str]:
    """Give the labels of the members along which pins travel, by their joints; `members` are all labels."""
    links = {name: joint.bodies[0] for name, joint in joints.items() if joint.member is not None}
    return {name: link if link in members else f"{link}.{joints[name].member}" for name, link in links.items()}


def joint_names(joints: Mapping[str, Joint]) -> list[str]:
    """Give the names of joint forces: one to a joint, or "joint:body" for every body on a pin but the first."""
    return [
        name if len(joint.bodies) == 2 else f"{name}:{body}"
        for name, joint in joints.items()
        for body in joint.bodies[1:]
    ]


def effort_units(moved: Sequence[str], joints: Mapping[str, Joint]) -> list[str]:
    """Give the unit of each drive's effort: N where it slides, N m where it turns."""
    return ["N" if joints[name].slides else "N m" for name in moved]
