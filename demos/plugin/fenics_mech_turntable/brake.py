"""Eddy-current brakes: a torque that rises with the speed, and falls beyond the critical one."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from fenics_mech._arrays import Array
from fenics_mech.scene.joint_laws import PluggedEffort
from fenics_mech.scene.units import AngularSpeed, Torque


class EddyBrake(PluggedEffort):
    """An eddy-current brake at a pin.

    Parameters
    ----------
    joint
        The pin of two bodies.
    torque
        Largest torque, which it has at the critical speed (N m).
    critical
        Critical speed (rad/s).
    """

    fits: ClassVar[tuple[str, ...]] = ("revolute",)
    kind: Literal["eddy-brake"] = "eddy-brake"
    torque: Annotated[Torque, Field(gt=0)]
    critical: Annotated[AngularSpeed, Field(gt=0)]

    def effort_at(self, time: Array, place: Array, rate: Array) -> Array:
        """M = -2 T x/(1 + x^2) with x = rate/critical speed (N m): Smythe, AIEE Transactions 61 (1942)."""
        share = rate / self.critical
        return -2 * self.torque * share / (1 + share**2)
