"""What lies between the positions of a cycle of links that bend: by how much its peaks differ from those shown.

The motion without vibration is known at any angle from a linear static answer. What is left of a response is its
vibration, and what its theory adds. The accelerations of points are those of the rigid motion, and what bending adds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.accuracy.at_stations import AtStations
from fenics_mech.accuracy.missed_peaks import ACCELERATIONS
from fenics_mech.accuracy.quantities import Quantities
from fenics_mech.beams.element_matrices import Beams
from fenics_mech.effects import EFFECTS
from fenics_mech.forces.virtual_work import Forces
from fenics_mech.kinematics import Linkage, Motion
from fenics_mech.mechanism.beam_links import links
from fenics_mech.mechanism.motor_equation import at_rate
from fenics_mech.recovery.cycle_curves import CycleCurves
from fenics_mech.recovery.fields import Fields
from fenics_mech.recovery.link_motion import link_motion
from fenics_mech.recovery.peaks import CYCLIC, curves_over_cycle
from fenics_mech.recovery.peaks_between import OfLinkage, PeaksBetween, Values, accelerations_of
from fenics_mech.response.few_nodes import FEW_NODES
from fenics_mech.response.setup import system_at
from fenics_mech.response.solution import MotorSolution, Solution
from fenics_mech.response.static.quasi_static import solve_static
from fenics_mech.scene.meshing import thinned


def with_missed_peaks(solution: Solution, fields: Fields) -> AtStations:
    """Give what was recovered at the stations, and by how much positions of a cycle miss the peaks between them.

    Parameters
    ----------
    solution
        The response.
    fields
        What was recovered from it.
    """
    scene, found = solution.scene, fields.at_stations
    if scene.analysis.method not in CYCLIC or scene.analysis.sub_intervals < 4 or not scene.drives:
        return found
    peaks = PeaksBetween(_WithoutVibration.made(solution, fields), _known(solution, fields))
    return replace(found, missed=peaks.missed_peaks())


@dataclass(frozen=True)
class _WithoutVibration(OfLinkage):
    """A scene without effects by which axial forces act on bending, and its answer by linear statics at any angles.

    `linkage` gives the rigid motion at any angles. `s` are the stations. `twist` are curves of the angle of a motor's
    crank ahead of its drive and of two time derivatives, ``(positions, 3)``.
    """

    linkage: Linkage
    beams: Beams
    s: Array
    twist: CycleCurves | None

    @classmethod
    def made(cls, solution: Solution, fields: Fields) -> _WithoutVibration:
        """Take few nodes where a mesh has many: those of uniform members are right however few."""
        scene, system, twist = solution.scene, fields.system, None
        linear = [n for n in scene.named_effects if not (EFFECTS[n].stress_stiffening or EFFECTS[n].nonlinear)]
        straight, beams = scene.model_copy(update={"effects": tuple(linear)}), system.beams
        if not system.transformation.constraints.contacts:
            few = thinned(straight, beams.mesh.members, FEW_NODES.kept)
            straight, beams = (straight, beams) if few is straight else (few, links(few))
        driven = system.motion
        if isinstance(solution, MotorSolution):
            driven, twist = solution.cycle.system.motion, curves_over_cycle(scene, solution.twist.T)
        linkage = driven.linkage or Linkage(straight)  # whose branch is followed in steps of its own
        return cls(straight, system.motion, linkage, beams, fields.coordinates["s"], twist)

    @property
    def knots(self) -> Array:
        """Drive angles to which the branch was followed (rad)."""
        return self.linkage.branch.over(np.array([0.0, len(self.motion.theta) * self.step])).theta

    def at(self, places: Array) -> Values:
        """Give the quantities at places of the cycle, in positions."""
        theta, rate = places * self.step, self.scene.cycle_rate
        if self.twist is None:
            return self.of(self.linkage.motion(theta, rate))
        ahead, faster, change = self.twist.at(places).T
        crank = at_rate(self.linkage.motion(theta + ahead, rate), rate, rate + faster, change)
        return self.of(replace(crank, theta=theta, time=theta / rate))

    def of(self, motion: Motion) -> Values:
        """Give the quantities in a motion."""
        system = system_at(self.scene, self.beams, motion)
        found = Quantities.of(self.scene, system, solve_static(system), s=self.s)
        rigid = accelerations_of(self.scene, motion)
        strain = found.axial[..., None] + found.bending
        return {
            "strain": strain.reshape(*strain.shape[:2], -1),
            "deflection": found.deflection,
            "joint_force": found.force[:, :, None],
            "torque": found.effort[..., None],
            **dict.fromkeys(ACCELERATIONS, rigid),
        }


def _known(solution: Solution, fields: Fields) -> Values:
    """Give the quantities of a response at the positions."""
    strain, deflection, force = (fields.variables[name][1] for name in ("strain", "deflection", "joint_force"))
    forces = Forces(solution.scene, fields.system, solution.response)
    moving = link_motion(forces)
    return {
        "strain": strain.reshape(*strain.shape[:2], -1),
        "deflection": deflection,
        "joint_force": force[:, :, None],
        "torque": np.stack(list(forces.efforts().values()), axis=1)[..., None],
        **{name: moving[name].to_numpy()[:, :, None] for name in ACCELERATIONS if name in moving},
    }
