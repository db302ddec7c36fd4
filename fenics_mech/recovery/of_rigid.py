"""What is read off a motion of poses where no link bends."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from fenics_mech._arrays import Array
from fenics_mech.kinematics import Motion as LinkMotion
from fenics_mech.machine.energy import power_of_weight
from fenics_mech.recovery.of_poses import GROUND, OfPoses
from fenics_mech.scene.joints import Joint
from fenics_mech.solve.held import Held
from fenics_mech.terms.causes import Cause


@dataclass(frozen=True)
class OfRigid(OfPoses):
    """A motion of rigid links at some instants, in the chart itself.

    Parameters
    ----------
    moved_links
        The motion of the links' frames.
    by_rows
        What the rows exert.
    """

    moved_links: LinkMotion
    by_rows: Held

    def links(self) -> LinkMotion:
        """Give the motion of the links' frames."""
        return self.moved_links

    @cached_property
    def theta(self) -> Array:
        """Drive angles (rad)."""
        return self.moved_links.theta

    def held(self, name: str, joint: Joint, body: str) -> Array:
        """Give force and moment, about its point, of a joint on one of its bodies ``(instants, 3)`` (N, N m)."""
        if body == GROUND or name in self.made.scene.open_joints:
            return super().held(name, joint, body)
        end = self.made.end(next(point for point in joint.connect if point.split(".")[0] == body))
        rows = [
            k
            for k, row in enumerate(self.motion.machine.rows)
            if row.name == name and end.pose in (row.pair[0].pose, row.pair[1].pose)
        ]
        found, arm = (
            self.by_rows.on_pose(end.pose, rows),
            self.motion.machine.known.at(self.motion.t).R[:, end.pose] @ end.offset,
        )
        found[:, 2] -= arm[:, 0] * found[:, 1] - arm[:, 1] * found[:, 0]
        return found + self._of_drive(name, joint, body)

    def powers(self) -> dict[str, Array]:
        """Give what drives, weight, loads and damping give to the machine ``(instants,)`` (W)."""
        found = super().powers()
        if any(self.made.scene.gravity):
            drive = next(iter(found))
            found = {drive: found[drive], Cause.WEIGHT: power_of_weight(self.motion)} | found
        return found
