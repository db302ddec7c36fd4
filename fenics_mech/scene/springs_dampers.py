"""Springs and viscous dampers, between two points or between the rotations of two bodies at a joint."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from fenics_mech.scene.base import Name, Part, PointName
from fenics_mech.scene.units import Angle, Length, SpringRate, TorsionalDamping, TorsionalRate, Viscosity


class Line(Part):
    """What acts along the line between two points, "link.point" or "ground.point"."""

    between: tuple[PointName, PointName]


class Hinge(Part):
    """What acts on the rotation of one body of a joint against another.

    Parameters
    ----------
    joint
        Name of the joint.
    bodies
        The two bodies; they may be left out where the joint has no more than two. The rotation is that of the second
        against the first, counter-clockwise.
    """

    joint: Name
    bodies: tuple[Name, Name] | None = None


class LineSpring(Line):
    """A spring between two points; it pulls and pushes.

    Parameters
    ----------
    between
        The points.
    stiffness
        Force over elongation (N/m).
    length
        Free length (m); without it, the spring is free of force at drive angle 0.

    Examples
    --------
    >>> fm.LineSpring(between=("ground.C", "coupler.A"), stiffness="2 N/mm").stiffness
    2000.0
    """

    stiffness: Annotated[SpringRate, Field(gt=0)]
    length: Annotated[Length, Field(ge=0)] | None = None


class HingeSpring(Hinge):
    """A torsional spring between two bodies at a joint.

    Parameters
    ----------
    joint, bodies
        Where it is.
    stiffness
        Moment over angle (N m/rad).
    angle
        Rotation (rad) at which it is free of moment, of the second body's frame in the first's. Whole turns count: a
        spring of a joint at 0 with "720 deg" is wound by two turns. Without it, the spring is free at drive angle 0.

    Examples
    --------
    >>> fm.HingeSpring(joint="O", stiffness="3 N m/rad").stiffness
    3.0
    """

    stiffness: Annotated[TorsionalRate, Field(gt=0)]
    angle: Angle | None = None


class LineDamper(Line):
    """A viscous damper between two points.

    Parameters
    ----------
    between
        The points.
    damping
        Force over the rate of its length (N s/m).

    Examples
    --------
    >>> fm.LineDamper(between=("ground.C", "coupler.A"), damping="5 N s/m").damping
    5.0
    """

    damping: Annotated[Viscosity, Field(gt=0)]


class HingeDamper(Hinge):
    """Viscous friction of a joint.

    Parameters
    ----------
    joint, bodies
        Where it is.
    damping
        Moment over the rate of rotation (N m s/rad).

    Examples
    --------
    >>> fm.HingeDamper(joint="O", damping=0.01).damping
    0.01
    """

    damping: Annotated[TorsionalDamping, Field(gt=0)]


def _kind(value: Any) -> str:
    at_joint = "joint" in value if isinstance(value, dict) else isinstance(value, Hinge)
    return "hinge" if at_joint else "line"


Spring = Annotated[Annotated[LineSpring, Tag("line")] | Annotated[HingeSpring, Tag("hinge")], Discriminator(_kind)]
Damper = Annotated[Annotated[LineDamper, Tag("line")] | Annotated[HingeDamper, Tag("hinge")], Discriminator(_kind)]
