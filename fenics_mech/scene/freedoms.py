"""Freedoms: joints that nothing leads, with the state that they start from and the effort that acts in them.

A linkage moves by itself as far as its freedoms go. An effort is a torque between the two bodies of a pin, or a force
along the guide of a slot or prismatic joint: of a motor, a brake, a controller.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, Tag

from fenics_mech._arrays import Array
from fenics_mech.scene.base import Part
from fenics_mech.scene.formulas.expression import JET_FUNCTIONS, Formula, Jet, formula_of, slopes_of
from fenics_mech.scene.units import AngleOrLength, AngularSpeed, Inertia, RateOfJoint, Torque, TorqueOrForce


def _turns(speed: float) -> float:
    if speed == 0:
        raise ValueError("must not be 0: its sign is the sense of rotation, and torques go with the speed over it")
    return speed


SpeedOfMotor = Annotated[AngularSpeed, AfterValidator(_turns)]


class FormulaEffort(Part):
    """An effort by a formula.

    Parameters
    ----------
    formula
        Torque (N m) or force (N) as a formula of the time t (s), of theta and of omega. These are the joint's angle or
        stroke (rad or m), and its rate (rad/s or m/s).

    Examples
    --------
    >>> fm.Freedom(effort=fm.FormulaEffort(formula="3 - 0.2 * omega")).effort.kind
    'formula'
    """

    kind: Literal["formula"] = "formula"
    formula: Annotated[str, formula_of("t", "theta", "omega")]

    def at(self, time: Array, place: Array, rate: Array, start: float) -> Array:
        """Effort (N m or N) at times (s), with the joint's angle or stroke and its rate there, ``(times,)`` each."""
        formula = Formula(self.formula, ("t", "theta", "omega"))
        return formula(JET_FUNCTIONS, t=time, theta=place, omega=rate) + 0.0 * time


class DirectCurrentMotor(Part):
    """A direct-current motor: its torque falls linearly with the speed.

    Parameters
    ----------
    stall_torque
        Torque at rest (N m).
    no_load_speed
        Speed at which there is none (rad/s); its sign is the sense of rotation.

    Examples
    --------
    >>> motor = fm.DirectCurrentMotor(stall_torque="3 N m", no_load_speed="3000 rpm")
    >>> round(motor.no_load_speed, 2)
    314.16
    """

    kind: Literal["dc-motor"] = "dc-motor"
    stall_torque: Annotated[Torque, Field(gt=0)]
    no_load_speed: SpeedOfMotor

    def at(self, time: Array, place: Array, rate: Array, start: float) -> Array:
        """Torque (N m) at times (s), with the joint's angle and its rate there, ``(times,)`` each."""
        return np.sign(self.no_load_speed) * self.stall_torque * (1 - rate / self.no_load_speed)


class InductionMotor(Part):
    """An induction motor on the mains by Kloss's formula, without its electrical transients.

    Parameters
    ----------
    breakdown_torque
        Its largest torque (N m).
    breakdown_slip
        Slip at which it has that: the share by which its speed is below the synchronous one.
    synchronous_speed
        Speed at which there is no torque (rad/s); its sign is the sense of rotation.

    Examples
    --------
    >>> motor = fm.InductionMotor(breakdown_torque=20.0, breakdown_slip=0.2, synchronous_speed="1500 rpm")
    >>> round(motor.synchronous_speed, 2)
    157.08
    """

    kind: Literal["induction-motor"] = "induction-motor"
    breakdown_torque: Annotated[Torque, Field(gt=0)]
    breakdown_slip: Annotated[float, Field(gt=0, le=1)] = 0.2
    synchronous_speed: SpeedOfMotor

    def at(self, time: Array, place: Array, rate: Array, start: float) -> Array:
        """Torque (N m) at times (s), with the joint's angle and its rate there, ``(times,)`` each."""
        slip = 1 - rate / self.synchronous_speed
        share = 2 * slip * self.breakdown_slip / (slip**2 + self.breakdown_slip**2)  # Kloss (1901)
        return np.sign(self.synchronous_speed) * self.breakdown_torque * share


class SpeedController(Part):
    """A controller of a constant speed, proportional and integral, without a limit of its effort.

    Parameters
    ----------
    speed
        Speed that it holds (rad/s or m/s).
    proportional
        Effort over the error of the speed (N m s/rad or N s/m).
    integral
        Effort over the integral of that error, from the start on (N m/rad or N/m).

    Examples
    --------
    >>> fm.SpeedController(speed="300 rpm", proportional=0.5).integral
    0.0
    """

    kind: Literal["speed-controller"] = "speed-controller"
    speed: RateOfJoint
    proportional: Annotated[float, Field(ge=0)]
    integral: Annotated[float, Field(ge=0)] = 0.0

    def at(self, time: Array, place: Array, rate: Array, start: float) -> Array:
        """Effort (N m or N) at times (s), with the joint's angle or stroke and its rate there, ``(times,)`` each."""
        # the integral of the error of the speed is that of the place
        return self.proportional * (self.speed - rate) + self.integral * (self.speed * time - (place - start))


def _kind_of(value: Any) -> Any:
    if isinstance(value, Part):
        return getattr(value, "kind", None)
    return value.get("kind") if isinstance(value, dict) else "number"


Effort = Annotated[
    Annotated[TorqueOrForce, Tag("number")]
    | Annotated[FormulaEffort, Tag("formula")]
    | Annotated[DirectCurrentMotor, Tag("dc-motor")]
    | Annotated[InductionMotor, Tag("induction-motor")]
    | Annotated[SpeedController, Tag("speed-controller")],
    Discriminator(_kind_of),
]


def no_torque_speed(effort: Effort) -> float | None:
    """Give the speed at which a motor has no torque (rad/s); None of what is no motor."""
    match effort:
        case DirectCurrentMotor():
            return effort.no_load_speed
        case InductionMotor():
            return effort.synchronous_speed
    return None


def effort_of(effort: Effort, time: Array, state: tuple[Array, Array], start: float) -> Array:
    """Effort on the second body (N m or N) at times (s), by place and rate of the joint, ``(times,)`` each."""
    return np.full_like(time, effort) if isinstance(effort, float) else effort.at(time, *state, start)


def with_slopes(effort: Effort, time: Array, state: tuple[Array, Array], start: float) -> tuple[Array, Array, Array]:
    """Effort on the second body of a joint, and its derivatives by place and rate, ``(times,)`` each."""
    if isinstance(effort, float):
        return np.full_like(time, effort), np.zeros_like(time), np.zeros_like(time)
    law: Any = effort.at  # it takes jets as well
    return slopes_of(lambda *moved: law(*moved, start), time, *state)


class Freedom(Part):
    """A joint that nothing leads.

    Parameters
    ----------
    start
        Angle (rad) or stroke (m) of the joint's second body against its first at time 0; without it, that of the links'
        rough angles.
    speed
        Its rate at time 0 (rad/s or m/s); without it, none. Where a pin has a clearance or a bushing, that of the
        linkage with a tight pin.
    effort
        Torque (N m) or force (N) on the second body, with the opposite one on the first.
    inertia
        Moment of inertia of what turns with the second body against the first (kg m^2): rotor, gears, flywheel.

    Examples
    --------
    >>> fm.Freedom(start="90 deg", effort=fm.DirectCurrentMotor(stall_torque=3.0, no_load_speed=300.0)).rate_at_start
    0.0
    """

    start: AngleOrLength | None = None
    speed: RateOfJoint | None = None
    effort: Effort = 0.0
    inertia: Annotated[Inertia, Field(ge=0)] = 0.0

    @property
    def rate_at_start(self) -> float:
        """Rate at time 0 (rad/s or m/s)."""
        return self.speed or 0.0

    def held(self, theta: Array) -> Jet:
        """Give the angle or stroke at the start, without derivatives, of the shape of theta."""
        return Jet(np.full_like(theta, self.start or 0.0), np.zeros_like(theta), np.zeros_like(theta))

    def effort_at(self, time: Array, place: Array, rate: Array) -> Array:
        """Effort on the second body (N m or N), with the rotor's share in it, ``(times,)``; see `effort_of`."""
        return effort_of(self.effort, time, (place, rate), self.start or 0.0)
