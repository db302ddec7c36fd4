"""What lies between the positions of a cycle of poses: by how much its peaks differ from those shown."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.estimate.missed_peaks import ACCELERATIONS, MissedPeaks
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.machine.motion import LinearMotion, Motion
from fenics_mech.recovery.of_linear import OfLinear
from fenics_mech.recovery.of_poses import OfPoses
from fenics_mech.recovery.peaks import PEAK
from fenics_mech.recovery.peaks_between import OverCycle, PeaksBetween, Values
from fenics_mech.solve import quasi_static

FINE = 4  # times as many places as angles, at which the rigid motion is looked at
TURNS = 40  # places between which accelerations change alike, over all that they change in a cycle


def missed_peaks(
    made: SceneMachine,
    at: Callable[[float], OfPoses],
    bent: bool,
    shares: int,
    still: Callable[[Array], OfPoses] | None = None,
) -> MissedPeaks:
    """Give by how much the positions of a cycle miss the peaks between them."""
    # still: gives what is read off the static answer at instants (s); None for that of the machine
    times = min(shares, math.ceil(PEAK.certain / made.scene.analysis.sub_intervals))
    parts = [_values(at(share / times), bent) for share in range(times)]
    known = {name: np.stack([part[name] for part in parts], axis=1) for name in parts[0]}
    whole = {name: value.reshape(-1, *value.shape[2:]) for name, value in known.items()}
    return PeaksBetween(
        _WithoutVibration(made.scene, made, still or partial(_at_rest, made)), whole, times
    ).missed_peaks()


def _values(found: OfPoses, bent: bool) -> Values:
    """Give the quantities whose peaks are compared ``(instants, owners, curves of each)``."""
    axial, bending = found.strains
    strain, forces, efforts = axial[..., None] + bending, found.joint_forces, found.efforts()
    none = np.zeros((len(axial), 0))
    values = {
        "strain": strain.reshape(*strain.shape[:2], -1),
        "deflection": found.deflection,
        "joint_force": np.stack(list(forces.values()), axis=1)[:, :, None] if forces else none[..., None, None],
        "torque": np.stack(list(efforts.values()), axis=1)[..., None] if efforts else none[..., None],
    }
    ways = (found.motion.chart.of_end, found.moved) if bent else (found.motion.chart.of_end,)
    for name, moved in zip(ACCELERATIONS, ways):
        values[name] = np.stack([moved(end)[2] for end in found.traced.values()], axis=1)[:, :, None]
    return values


def _at_rest(made: SceneMachine, t: Array) -> OfPoses:
    """Read off the linear static answer of a machine at some instants (s)."""
    machine, zero = made.machine, np.zeros((len(t), made.machine.size))
    answer = quasi_static(machine, t)
    rigid = Motion(machine, t, zero, zero, zero)
    return OfLinear.by(made, LinearMotion(rigid, answer.change, moving=False, stresses=answer.stresses))


@dataclass(frozen=True)
class _WithoutVibration(OverCycle):
    """The linear static answer to loads and rigid inertia of a machine at any angles."""

    made: SceneMachine
    still: Callable[[Array], OfPoses]

    @property
    def count(self) -> int:
        """Number of the positions."""
        return self.scene.analysis.sub_intervals

    def at(self, places: Array) -> Values:
        """Give the quantities at places of the cycle, in positions."""
        values = _values(self.still(places * (self.scene.period / self.count)), bent=False)
        return values | {ACCELERATIONS[1]: values[ACCELERATIONS[0]]}

    def turning(self) -> Array:
        """Give places over the cycle between which accelerations of the rigid links change alike."""
        fine = np.linspace(0.0, 1.0, self.angles * FINE + 1)
        change = np.abs(np.diff(self.made.machine.known.at(fine * self.scene.period).a, axis=0)).max(axis=(1, 2))
        sum_of = np.append(0.0, np.cumsum(change))
        even = np.linspace(0.0, sum_of[-1], TURNS + 1)
        return np.asarray(self.count * np.unique(np.interp(even, sum_of, fine)))
