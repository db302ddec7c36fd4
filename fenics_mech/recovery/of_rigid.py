"""What is read off a motion of poses where no link bends."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from fenics_mech._arrays import Array
from fenics_mech.kinematics import Motion as LinkMotion
from fenics_mech.machine.energy import power_of_weight
from fenics_mech.recovery.of_poses import OfPoses
from fenics_mech.terms.causes import Cause


@dataclass(frozen=True)
class OfRigid(OfPoses):
    """A motion of rigid links at some instants, in the chart itself."""

    angle: Array  # angles of the links, whole turns and all ``(instants, links)`` (rad)
    turned: Array  # drive angles ``(instants,)`` (rad)

    def links(self) -> LinkMotion:
        """Give the motion of the links' frames."""
        return replace(super().links(), angle=self.angle)

    @cached_property
    def theta(self) -> Array:
        """Drive angles (rad)."""
        return self.turned

    def powers(self) -> dict[str, Array]:
        """Give what drives, weight, loads and damping give to the machine ``(instants,)`` (W)."""
        found = super().powers()
        if any(self.made.scene.gravity):
            drive = next(iter(found))
            found = {drive: found[drive], Cause.WEIGHT: power_of_weight(self.motion)} | found
        return found
