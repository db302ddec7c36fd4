"""Laws of joints: forces beyond what a joint's constraint transmits, or in its place.

Friction and stops act beside the constraint of a joint. A clearance or a bushing takes its place.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from fenics_mech._arrays import Array
from fenics_mech.scene.base import Part
from fenics_mech.scene.freedoms import Effort, SpeedController, effort_of
from fenics_mech.scene.paired_joints import AtJoint, Cam, GearPair
from fenics_mech.scene.units import (
    Angle,
    AngleOrLength,
    Length,
    Speed,
    SpringRate,
    TorsionalDamping,
    TorsionalRate,
    Viscosity,
)

Coefficient = Annotated[float, Field(ge=0)]
Width = Annotated[Speed, Field(gt=0)]


class Contact(Part):
    """How two bodies push each other where they touch: ``F = K d^n (1 + c d'/v)``.

    The indentation is d, its rate d', and v the rate at which the contact began.

    Parameters
    ----------
    stiffness
        K (N/m^n; of an angle N m/rad^n).
    exponent
        n: 1.5 of Hertz, 1 of a linear spring.
    restitution
        Speed after a contact over that before it, e, of 0.05 to 1.
    law
        How c follows from e. "exact" has the stated restitution. The two printed formulas have a larger one:
        "lankarani-nikravesh", c = 3 (1 - e^2)/4, and "flores", c = 8 (1 - e)/(5 e).

    Examples
    --------
    >>> fm.Contact(stiffness=6.6e10, restitution=0.9).exponent
    1.5
    """

    stiffness: Annotated[float, Field(gt=0)]
    exponent: Annotated[float, Field(ge=1, le=10)] = 1.5
    restitution: Annotated[float, Field(ge=0.05, le=1)] = 1.0
    law: Literal["exact", "lankarani-nikravesh", "flores"] = "exact"


class Friction(AtJoint):
    """Dry friction of a pin or a slider, with Stribeck's fall and a viscous share.

    The coefficient at a sliding speed v is ``(m + (m0 - m) exp(-(v/v0)^2)) tanh(v/w)``. It multiplies
    the joint's force.

    Parameters
    ----------
    joint
        Where it is: a pin, a slot or a prismatic joint of two bodies.
    coefficient
        m, of fast sliding.
    radius
        Of the pin (m): its surface rubs at that radius.
    static
        m0, of slow sliding; without it, m.
    stribeck
        v0 (m/s): speed over which the friction falls from m0 to m.
    viscous
        Force over speed (N s/m), or moment over rate of rotation (N m s/rad), beside the dry friction.
    width
        w (m/s): speed at which 76 % of the friction act. What sticks creeps at a part of it: by less than
        1e-3 mm in 20 s at 1e-8 m/s. A pin of 10 mm then turns at up to 1e-6 rad/s.
    belt_speed
        Speed of the first body's surface along its guide (m/s), such as of a belt that runs on it.

    Examples
    --------
    >>> fm.Friction(joint="A", coefficient=0.1, radius="10 mm").radius
    0.01
    """

    kind: Literal["friction"] = "friction"
    coefficient: Coefficient
    radius: Annotated[Length, Field(gt=0)] | None = None
    static: Coefficient | None = None
    stribeck: Width | None = None
    viscous: Annotated[float, Field(ge=0)] = 0.0
    width: Width = 1e-8
    belt_speed: Speed = 0.0

    def _check_keys(self) -> None:
        if self.static is not None and self.static < self.coefficient:
            raise ValueError(
                f"the static coefficient {self.static:g} is less than that of fast sliding, {self.coefficient:g}"
            )
        if (self.static is None) != (self.stribeck is None):
            raise ValueError("`static` and `stribeck` go together: the friction falls from one speed to another")


class Stop(AtJoint):
    """Limits of a joint's angle or stroke, at which its bodies touch.

    Parameters
    ----------
    joint
        Where it is: a pin, a slot or a prismatic joint of two bodies.
    contact
        How they push each other.
    lower, upper
        Angle (rad) or stroke (m) of the second body against the first at which they touch; one of them is enough.

    Examples
    --------
    >>> fm.Stop(joint="O", upper="90 deg", contact=fm.Contact(stiffness=1e6)).lower is None
    True
    """

    kind: Literal["stop"] = "stop"
    contact: Contact
    lower: AngleOrLength | None = None
    upper: AngleOrLength | None = None

    def _check_keys(self) -> None:
        if self.lower is None and self.upper is None:
            raise ValueError("a stop needs `lower`, `upper` or both")
        if self.lower is not None and self.upper is not None and self.lower >= self.upper:
            raise ValueError(f"the lower limit {self.lower:g} is not below the upper one, {self.upper:g}")


class LooseJoint(AtJoint):
    """A joint whose bodies touch with clearance, instead of its constraint."""

    contact: Contact
    friction: Coefficient = 0.0
    width: Width = 1e-3


class Clearance(LooseJoint):
    """Radial clearance of a pin: a journal of the second body moves inside a bearing of the first.

    Parameters
    ----------
    joint
        The pin of two bodies.
    radial
        Radius of the bearing less that of the journal (m).
    radius
        Of the bearing (m).
    contact
        How journal and bearing push each other.
    friction
        Coefficient of dry friction between them.
    width
        Sliding speed at which 76 % of the friction act (m/s).

    Examples
    --------
    >>> steel = fm.Contact(stiffness=6.6e10, restitution=0.9)
    >>> fm.Clearance(joint="B", radial="0.5 mm", radius="10 mm", contact=steel).friction
    0.0
    """

    kind: Literal["clearance"] = "clearance"
    radial: Annotated[Length, Field(gt=0)]
    radius: Annotated[Length, Field(gt=0)]

    def _check_keys(self) -> None:
        if self.radial >= self.radius:
            raise ValueError(
                f"the clearance {self.radial:g} m is not less than the radius of the bearing, {self.radius:g} m"
            )


class GuideClearance(LooseJoint):
    """Clearance of a slider in its guide: both ends of the slider may touch either wall.

    Parameters
    ----------
    joint
        The prismatic joint; the second body is the slider.
    play
        From each end of the slider to either wall, where the slider is in the middle (m).
    length
        Of the slider along the guide, with its point in the middle (m).
    contact, friction, width
        As of a clearance.

    Examples
    --------
    >>> steel = fm.Contact(stiffness=1e10, restitution=0.8)
    >>> fm.GuideClearance(joint="G", play="0.2 mm", length="40 mm", contact=steel).play
    0.0002
    """

    kind: Literal["guide-clearance"] = "guide-clearance"
    play: Annotated[Length, Field(gt=0)]
    length: Annotated[Length, Field(gt=0)]


class SideContact(LooseJoint):
    """A guide with one side: the pin of a slot may lift off it, and comes back by an impact.

    Parameters
    ----------
    joint
        The slot: the guide is a line of the first body, or its `member` as it bends. The pin is a point of the second.
    side
        Side of the guide on which the pin is, as one looks along it.
    contact, friction, width
        As of a clearance.

    Examples
    --------
    >>> fm.SideContact(joint="S", contact=fm.Contact(stiffness=1e8, restitution=0.6)).side
    'left'
    """

    kind: Literal["side-contact"] = "side-contact"
    side: Literal["left", "right"] = "left"


class Bushing(AtJoint):
    """A soft bearing in place of a pin: stiffness and damping along two directions and in rotation.

    Parameters
    ----------
    joint
        The pin of two bodies.
    stiffness, damping
        Force over displacement (N/m) and over velocity (N s/m) of the second body, along x and y of the first.
    turning_stiffness, turning_damping
        Moment over rotation (N m/rad) and over its rate (N m s/rad).
    turned
        Rotation of the second body against the first that is free of moment (rad).

    Examples
    --------
    >>> fm.Bushing(joint="B", stiffness=("1 kN/mm", "2 kN/mm")).stiffness
    (1000000.0, 2000000.0)
    """

    kind: Literal["bushing"] = "bushing"
    stiffness: tuple[Annotated[SpringRate, Field(gt=0)], Annotated[SpringRate, Field(gt=0)]]
    damping: tuple[Annotated[Viscosity, Field(ge=0)], Annotated[Viscosity, Field(ge=0)]] = (0.0, 0.0)
    turning_stiffness: Annotated[TorsionalRate, Field(ge=0)] = 0.0
    turning_damping: Annotated[TorsionalDamping, Field(ge=0)] = 0.0
    turned: Angle = 0.0


class JointEffort(AtJoint):
    """A torque or force at a joint that is no freedom, such as that of a gas over the stroke of its piston.

    Parameters
    ----------
    joint
        A pin, a slot or a prismatic joint of two bodies.
    effort
        Torque (N m) or force (N) on the second body, with the opposite one on the first.

    Examples
    --------
    >>> fm.JointEffort(joint="B", effort=fm.FormulaEffort(formula="-50/(0.2 - theta)")).effort.kind
    'formula'
    """

    kind: Literal["joint-effort"] = "joint-effort"
    effort: Effort

    def _check_keys(self) -> None:
        if isinstance(self.effort, SpeedController) and self.effort.integral:
            raise ValueError("the integral of a speed's error is known at freedoms: state this effort at one")

    def effort_at(self, time: Array, place: Array, rate: Array) -> Array:
        """Effort on the second body (N m or N) at times (s), by place and rate of the joint, ``(states,)`` each."""
        return effort_of(self.effort, time, (place, rate), 0.0)


class PluggedEffort(AtJoint, ABC):
    """A torque or force at a joint by a law of another package: the base of its class, which adds keys.

    Parameters
    ----------
    joint
        A pin, a slot or a prismatic joint of two bodies.
    """

    fits: ClassVar[tuple[str, ...]] = ("revolute", "slot", "prismatic")  # kinds of joints at which it may be
    kind: str

    @abstractmethod
    def effort_at(self, time: Array, place: Array, rate: Array) -> Array:
        """Effort on the second body (N m or N) at times (s), by place and rate of the joint, ``(states,)`` each."""


OneJointLaw = Friction | Stop | Clearance | GuideClearance | SideContact | Bushing | JointEffort
AnyJointLaw = Annotated[OneJointLaw | GearPair | Cam, Field(discriminator="kind")]
OPEN = (Clearance, GuideClearance, SideContact, Bushing)  # laws in place of a joint's constraint
TOUCHING = (Stop, Clearance, GuideClearance, SideContact, Cam)  # laws of contact
