"""What lies between the positions of a cycle of rigid links: their motion and forces are known at any angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.accuracy.estimate import BY_POSITIONS, Errors
from fenics_mech.accuracy.missed_peaks import ACCELERATIONS
from fenics_mech.accuracy.missed_peaks import BETWEEN as POSITIONS
from fenics_mech.accuracy.quantities import measures
from fenics_mech.kinematics import Linkage, Motion
from fenics_mech.recovery.dataset import of_errors
from fenics_mech.recovery.peaks import CYCLIC
from fenics_mech.recovery.peaks_between import BETWEEN, OverCycle, PeaksBetween, Values, accelerations_of
from fenics_mech.response.transient.rigid_motion import led
from fenics_mech.scene import Scene

QUANTITIES = "joint_force", "torque"  # whose errors are told beside those of accelerations


def missed_by_positions(scene: Scene, whole: Motion) -> xr.Dataset:
    """Give by how much positions of a cycle miss the peaks of joint forces, efforts and accelerations between them.

    Parameters
    ----------
    scene
        The scene, of which no link bends.
    whole
        The motion at the positions.

    Raises
    ------
    UnresolvedError
        When the positions miss the peak of a joint force by too much.
    """
    analysis = scene.analysis
    cyclic = analysis.method in CYCLIC and analysis.sub_intervals >= 4 and scene.drives and not scene.freedoms
    if not cyclic or not analysis.error_estimates:
        return xr.Dataset()
    still = _Rigid(scene, whole, linkage=whole.linkage or Linkage(scene))
    missed = PeaksBetween(still, still.of(whole)).missed_peaks()
    largest = {name: missed.peaks[name] for name in QUANTITIES}
    by_source = {name: {POSITIONS: missed.errors[name]} for name in QUANTITIES}
    errors = Errors(by_source, {POSITIONS: BY_POSITIONS}, measures(scene, largest), (), largest, missed)
    if not analysis.allow_coarse:
        errors.refuse_missed(scene)
    return of_errors(errors).dataset()


@dataclass(frozen=True)
class _Rigid(OverCycle):
    """Rigid links that drives lead."""

    linkage: Linkage
    angles = BETWEEN.cheap
    least = 2

    def moved(self, theta: Array) -> Motion:
        """Give the rigid motion at other drive angles (rad)."""
        return self.linkage.motion(theta, self.scene.cycle_rate)

    @property
    def knots(self) -> Array:
        """Drive angles to which the branch was followed (rad)."""
        return self.linkage.branch.over(np.array([0.0, len(self.motion.theta) * self.step])).theta

    def of(self, motion: Motion) -> Values:
        """Give the quantities in a motion."""
        parts = led(self.scene, motion).instants
        forces = [np.stack(list(part.joint_forces.values()), axis=1) for part in parts if part.joint_forces]
        none = np.zeros((len(motion.theta), 0, 2))
        return {
            "joint_force": (np.concatenate(forces) if forces else none)[:, :, None],
            "torque": np.concatenate([part.efforts for part in parts])[..., None],
            ACCELERATIONS[0]: accelerations_of(self.scene, motion),
        }
