"""Analysis of rigid links that drives lead, by the equation of poses: their motion, what rows hold, peaks, a result.

The motion follows from the drives alone. So the multipliers of the rows, which are the forces of joints and the efforts
of drives, follow instant by instant from one system of linear equations.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.answers.by_poses import read_off
from fenics_mech.errors import SceneError
from fenics_mech.estimate.error_sources import BY_POSITIONS, Errors
from fenics_mech.estimate.missed_peaks import ACCELERATIONS, BETWEEN
from fenics_mech.estimate.quantities import measures
from fenics_mech.geometry import Given, PoseMotion
from fenics_mech.kinematics import Motion as LinkMotion
from fenics_mech.machine.energy import energy_of_terms, kinetic_energy
from fenics_mech.machine.freed import balanced
from fenics_mech.machine.from_scene import SceneMachine, machine_of
from fenics_mech.machine.led_from_scene import Led, comes_back, led_motion
from fenics_mech.machine.motion import Motion
from fenics_mech.machine.rigid_from_scene import links_of_poses, poses_of_links
from fenics_mech.planning.sampling_checks import require_positions
from fenics_mech.recovery.balance import balance_of, given_by, mean_in_time
from fenics_mech.recovery.dataset import of_errors
from fenics_mech.recovery.freedoms_and_laws import law_efforts
from fenics_mech.recovery.of_poses import OfRigid
from fenics_mech.recovery.peaks import CYCLIC
from fenics_mech.recovery.peaks_between import BETWEEN as CLOSENESS
from fenics_mech.recovery.peaks_between import OverCycle, PeaksBetween, Values, accelerations_of
from fenics_mech.recovery.result import Result
from fenics_mech.recovery.variables import with_units
from fenics_mech.scene import Scene
from fenics_mech.scene.joint_laws import TOUCHING
from fenics_mech.terms.causes import Cause

TOGETHER = 2_000_000  # entries of the rows' derivatives that are looked at together


def rigid_by_poses(scene: Scene) -> Result:
    """Analyse rigid links that drives lead: over a cycle, in one position or in time."""
    _refuse(scene)
    require_positions(scene, count := _positions(scene))
    machine = LedMachine.of(scene)
    found = machine.at(_instants(scene, count))
    parts = [read_off(found), law_efforts(found), _powers(scene, found), _missed_by_positions(machine, found.links())]
    return Result.with_scene(scene, with_units(scene, xr.merge(parts, combine_attrs="no_conflicts")))


def _refuse(scene: Scene) -> None:
    """Raise `SceneError` for what does not act on links that drives lead."""
    for name in scene.impulses:
        place = f"impulses.{name}"
        raise SceneError("drives lead all rigid links, and an impulse does not change their motion", place=place)
    for name, law in scene.joint_laws.items():
        if isinstance(law, TOUCHING) and scene.analysis.method != "static":
            raise SceneError(
                f"drives lead all links, and what touches at joint {law.joint!r} cannot move them",
                place=f"joint_laws.{name}",
                hint="Give a freedom with an effort in place of a drive",
            )


def _positions(scene: Scene) -> int:
    analysis = scene.analysis
    if analysis.method == "static":
        return 1
    return analysis.sub_intervals if analysis.method != "transient" else analysis.cycles * analysis.sub_intervals + 1


def _instants(scene: Scene, count: int) -> Array:
    """Give the instants of the result ``(count,)`` (s)."""
    if scene.analysis.method == "static":
        return np.array([scene.analysis.position / scene.cycle_rate])
    return scene.period / scene.analysis.sub_intervals * np.arange(float(count))


@dataclass(frozen=True)
class LedMachine:
    """The machine of rigid links that drives lead, and their motion at any instant."""

    made: SceneMachine
    led: Led  # the motion of its links at full speed
    back: bool  # whether they are back after a cycle, in which alone they were followed

    @classmethod
    def of(cls, scene: Scene) -> LedMachine:
        """Build the machine of a scene, and follow its links as far as the analysis needs."""
        made = machine_of(scene)
        reached = _clock(scene, _instants(scene, _positions(scene)))[0]
        first, last = min(0.0, reached.min()), max(0.0, reached.max())
        if scene.analysis.method in CYCLIC:
            return cls(made, led_motion(made.bodies, 0.0, scene.period), False)
        if last - first > scene.period:
            cycle = led_motion(made.bodies, 0.0, scene.period)
            if comes_back(cycle):
                return cls(made, cycle, True)
        return cls(made, led_motion(made.bodies, first, last), False)

    def at(self, t: Array) -> OfRigid:
        """Give what acts in their motion."""
        # t: instants, ascending ``(instants,)`` (s)
        scene = self.made.scene
        clock, rate, change = _clock(scene, t)
        q, first, second = self.led.over_cycles(clock) if self.back else self.led.at(clock)
        v, a = rate[:, None] * first, rate[:, None] ** 2 * second + change[:, None] * first
        motion, angle = poses_of_links(self.made, q, v, a), q[:, 2 : self.made.bodies.machine.n : 3]
        return acting(self.made, t, motion, self.made.bodies.angles + angle, scene.cycle_rate * clock)


def acting(
    made: SceneMachine, t: Array, motion: PoseMotion, angle: Array, theta: Array, pulls: Array | None = None
) -> OfRigid:
    """Give what acts in a motion of rigid links."""
    # t, motion: instants, ascending (s), and the motion of all poses there; angle: angles of the links, whole turns
    # and all ``(instants, links)`` (rad); theta: drive angles ``(instants,)`` (rad); pulls: multipliers of all rows
    # ``(instants, rows)``; None where they are not known
    machine, moving = copy(made.machine), made.scene.analysis.method != "static"
    machine.chart = Given(t, motion)
    near, none = _near(made, angle), np.zeros((len(t), machine.n))
    if pulls is None:
        pulls = balanced(machine, t, (none, none, none), pulls=none, angles=near, moving=moving).pulls
    still = np.zeros((len(t), machine.size))
    beside = Motion(machine, t, still, still, np.concatenate([none, pulls], axis=1), moving, angles=near)
    return OfRigid(replace(made, machine=machine), beside, angle, theta)


def _clock(scene: Scene, t: Array) -> tuple[Array, Array, Array]:
    """Give the time in which drives at full speed come as far (s), and two derivatives by time."""
    if scene.analysis.method != "transient":
        return t, np.ones_like(t), np.zeros_like(t)
    theta, rate = scene.coordinate(t), scene.cycle_rate
    return theta.value / rate, theta.first / rate, theta.second / rate


def _near(made: SceneMachine, angle: Array) -> list[Array]:
    """Give the angles between both ends of every element of every term, whole turns and all."""
    of_links, links = np.append(angle, np.zeros((len(angle), 1)), axis=1), links_of_poses(made)
    found = []
    for term in made.machine.terms:
        first, second = links[np.array([[end.pose for end in pair] for pair in term.pairs])].T
        turned = of_links[:, second] - of_links[:, first]
        found.append(np.repeat(turned[..., None], len(term.looks[0]), axis=2))
    return found


def _powers(scene: Scene, found: OfRigid) -> xr.Dataset:
    """Give the mean power of every cause, and how far they are from a balance; see `energy_balance`."""
    powers, time = found.powers(), found.motion.t
    if not any(power.any() for power in powers.values()):
        return xr.Dataset()
    if scene.analysis.method == "transient":
        energy = kinetic_energy(found.motion) + energy_of_terms(found.motion)
        mean = mean_in_time(time, powers) | {Cause.STORED: given_by(energy, float(np.ptp(time)))}
    else:
        mean = {name: float(power.mean()) for name, power in powers.items()}
    return balance_of(mean, powers)


QUANTITIES = "joint_force", "torque"  # whose errors are told beside those of accelerations


def _missed_by_positions(machine: LedMachine, links: LinkMotion) -> xr.Dataset:
    """Give by how much positions of a cycle miss the peaks of joint forces, efforts and accelerations between them."""
    scene = machine.made.scene
    analysis = scene.analysis
    if analysis.method not in CYCLIC or analysis.sub_intervals < 4 or not analysis.error_estimates:
        return xr.Dataset()
    still = _Between(scene, machine, len(links.theta))
    missed = PeaksBetween(still, still.at_positions(1)).missed_peaks()
    largest = {name: missed.peaks[name] for name in QUANTITIES}
    by_source = {name: {BETWEEN: missed.errors[name]} for name in QUANTITIES}
    errors = Errors(by_source, {BETWEEN: BY_POSITIONS}, measures(scene, largest), (), largest, missed)
    if not analysis.allow_coarse:
        errors.refuse_missed(scene)
    return of_errors(errors)


@dataclass(frozen=True)
class _Between(OverCycle):
    """The motion of rigid links between the positions, where all of it is known."""

    machine: LedMachine
    positions: int
    angles = CLOSENESS.cheap
    least = 2

    @property
    def count(self) -> int:
        """Number of the positions."""
        return self.positions

    def turning(self) -> Array:
        """Give the places to which the motion was followed, in positions."""
        return np.unique(np.abs(self.machine.led.t)) * self.count / self.scene.period

    def at(self, places: Array) -> Values:
        """Give the quantities at places of the cycle, in positions."""
        t = places * self.step / self.scene.cycle_rate
        together = max(1, TOGETHER // (3 * len(self.scene.links)) ** 2)
        found = [self.machine.at(t[k : k + together]) for k in range(0, len(t), together)]
        forces = [np.stack(list(part.joint_forces.values()), axis=1) for part in found]
        efforts = [np.stack(list(part.efforts().values()), axis=1) for part in found]
        return {
            "joint_force": np.concatenate(forces)[:, :, None],
            "torque": np.concatenate(efforts)[..., None],
            ACCELERATIONS[0]: np.concatenate([accelerations_of(self.scene, part.links()) for part in found]),
        }
