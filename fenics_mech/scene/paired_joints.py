"""Laws that couple two joints: gear pairs, and cams with their followers."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from fenics_mech._arrays import Array
from fenics_mech.scene.base import Name, Part
from fenics_mech.scene.drives import Law
from fenics_mech.scene.formulas.expression import Jet
from fenics_mech.scene.units import Angle, Length, Speed, TorsionalDamping, TorsionalRate


class AtJoint(Part):
    """What acts at a joint."""

    joint: Name


class PairedJoints(AtJoint):
    """What couples a pin to another joint."""

    drives: Name


class GearPair(PairedJoints):
    """A gear pair, belt or chain from one pin to another, with the stiffness of its teeth or strands.

    It has no moment at the start. Backlash is not known. Without `pressure_angle` it is a pair of moments, and the
    bearings bear nothing of it, as of a belt whose tension is not known.

    Parameters
    ----------
    joint
        The pin of two bodies whose angle it takes.
    drives
        The pin of two bodies that it turns.
    ratio
        Turn of the driven pin over that of the other: negative of two external gears, positive of a belt.
    stiffness
        Moment at the driven pin over the angle by which that is behind (N m/rad).
    damping
        The same over its rate (N m s/rad).
    pressure_angle
        Of gears (rad), between the force of the teeth and the tangent of the pitch circles: bearings bear that force.

    Examples
    --------
    >>> teeth = fm.GearPair(joint="O", drives="C", ratio=-2.5, stiffness="1e5 N m/rad", pressure_angle="20 deg")
    >>> round(teeth.pressure_angle, 3)
    0.349
    """

    kind: Literal["gear-pair"] = "gear-pair"
    ratio: float
    stiffness: Annotated[TorsionalRate, Field(gt=0)]
    damping: Annotated[TorsionalDamping, Field(ge=0)] = 0.0
    pressure_angle: Annotated[Angle, Field(ge=0, lt=np.pi / 2)] | None = None

    def _check_keys(self) -> None:
        if self.ratio == 0:
            raise ValueError("the ratio must not be 0: the driven pin would not turn")
        if self.ratio == 1 and self.pressure_angle is not None:
            raise ValueError("gears of ratio 1 do not mesh: leave out the `pressure_angle` of a belt or a shaft")


class Cam(PairedJoints):
    """A cam that pushes a follower, which may lift off: ``F = K d (1 + b d')`` with the indentation d.

    The cam pushes towards larger strokes or angles of the follower. One that slides along a prismatic joint has a flat
    face across its guide. Other followers push the body that bears them, and the cam's bearing has no share of it.

    Parameters
    ----------
    joint
        The pin of two bodies about which the cam turns.
    drives
        The joint of the follower: its stroke or angle is at least the lift. Without a stated start it starts there.
    lift
        Stroke (m) or angle (rad) of the follower over the cam's angle, by the laws that drives have.
    stiffness
        K (N/m; of a follower that turns N m/rad).
    damping
        b (s/m or s/rad): 1/b is the rate of parting at which the contact has no force.
    friction
        Coefficient of dry friction between the cam and a flat face.
    radius
        Of the base circle (m): from the cam's pin to the face at no lift. Friction needs it.
    width
        Sliding speed at which 76 % of the friction act (m/s).

    Examples
    --------
    >>> import numpy as np
    >>> lift = fm.Harmonics(mean="5 mm", cosine=("-5 mm",))
    >>> fm.Cam(joint="O", drives="G", lift=lift, stiffness=1e7, damping=2.0).kind
    'cam'
    """

    kind: Literal["cam"] = "cam"
    lift: Law
    stiffness: Annotated[float, Field(gt=0)]
    damping: Annotated[float, Field(ge=0)] = 0.0
    friction: Annotated[float, Field(ge=0)] = 0.0
    radius: Annotated[Length, Field(gt=0)] | None = None
    width: Annotated[Speed, Field(gt=0)] = 1e-3

    def _check_keys(self) -> None:
        if self.friction and self.radius is None:
            raise ValueError("a cam that rubs needs the `radius` of its base circle")

    def lift_at(self, angle: Array) -> Jet:
        """Lift (m or rad) and two derivatives by the cam's angle (rad), of the shape of the angle."""
        return self.lift.jet(np.mod(angle, 2 * np.pi))
