"""Analysis of rigid links that drives lead, by the equation of poses: their motion, what rows hold, peaks, a result.

The motion follows from the drives alone. So the multipliers of the rows, which are the forces of joints and the efforts
of drives, follow instant by instant from one system of linear equations.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.accuracy.estimate import BY_POSITIONS, Errors
from fenics_mech.accuracy.missed_peaks import ACCELERATIONS, BETWEEN
from fenics_mech.accuracy.quantities import measures
from fenics_mech.errors import SceneError
from fenics_mech.forces.joint_forces import effort_units
from fenics_mech.geometry import Given
from fenics_mech.kinematics import Motion as LinkMotion
from fenics_mech.kinematics.motion import coordinates
from fenics_mech.machine import Machine
from fenics_mech.machine.energy import energy_of_terms, kinetic_energy
from fenics_mech.machine.from_scene import SceneMachine, machine_of
from fenics_mech.machine.led_from_scene import Led, comes_back, led_motion
from fenics_mech.machine.motion import Motion
from fenics_mech.machine.rigid_from_scene import Places, links_of_poses, poses_of_links
from fenics_mech.recovery.balance import balance_of, mean_in_time, stored
from fenics_mech.recovery.dataset import joined, of_errors
from fenics_mech.recovery.law_efforts import law_efforts, with_law_units
from fenics_mech.recovery.link_motion import motion_of_links
from fenics_mech.recovery.of_rigid import OfRigid
from fenics_mech.recovery.peaks import CYCLIC
from fenics_mech.recovery.peaks_between import BETWEEN as CLOSENESS
from fenics_mech.recovery.peaks_between import OverCycle, PeaksBetween, Values, accelerations_of
from fenics_mech.recovery.result import Result, stamp
from fenics_mech.recovery.rigid_places import rigid_places
from fenics_mech.recovery.variables import with_units
from fenics_mech.response.sampling_checks import require_positions
from fenics_mech.scene import Scene
from fenics_mech.solve.held import held

TOGETHER = 2_000_000  # entries of the rows' derivatives that are looked at together


def rigid_by_poses(scene: Scene) -> Result:
    """Analyse rigid links that drives lead: over a cycle, in one position or in time.

    Parameters
    ----------
    scene
        The scene, without members and freedoms.

    Raises
    ------
    AssemblyError
        When the links cannot be assembled, or a position of theirs is singular.
    SceneError
        When the scene has what does not act on links that are led.
    UnresolvedError
        When the positions miss the peak of a joint force by too much.
    """
    _refuse(scene)
    require_positions(scene, count := _positions(scene))
    machine = LedMachine.of(scene)
    links = machine.links(_instants(scene, count))
    found = acting(machine.made, links)
    data = read_off(scene, found)
    parts = [_powers(scene, found), _missed_by_positions(machine, links)]
    data = xr.merge([data, *parts], combine_attrs="no_conflicts")
    units = effort_units(scene.moved_joints, scene.joints)
    return Result.with_scene(
        scene, with_law_units(scene, with_units(data, units, scene.springs.values(), scene.dampers.values()))
    )


def _refuse(scene: Scene) -> None:
    """Raise `SceneError` for what does not act on links that drives lead."""
    for name in scene.impulses:
        place = f"impulses.{name}"
        raise SceneError("drives lead all rigid links, and an impulse does not change their motion", place=place)


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
    """The machine of rigid links that drives lead, and their motion at any instant.

    Parameters
    ----------
    made
        The machine.
    led
        The motion of its links at full speed.
    back
        Whether they are back after a cycle, in which alone they were followed.
    """

    made: SceneMachine
    led: Led
    back: bool

    @classmethod
    def of(cls, scene: Scene) -> LedMachine:
        """Build the machine of a scene, and follow its links as far as the analysis needs.

        Raises
        ------
        AssemblyError
            When they cannot be assembled, or the motion cannot be followed.
        """
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

    def links(self, t: Array) -> LinkMotion:
        """Give the motion of the links' frames.

        Parameters
        ----------
        t
            Instants, ascending ``(instants,)`` (s).
        """
        scene = self.made.scene
        clock, rate, change = _clock(scene, t)
        q, first, second = self.led.over_cycles(clock) if self.back else self.led.at(clock)
        v, a = rate[:, None] * first, rate[:, None] ** 2 * second + change[:, None] * first
        found = motion_of(self.made, scene.cycle_rate * clock, t, (q, v, a))
        return found.held() if scene.analysis.method == "static" else found


def motion_of(made: SceneMachine, theta: Array, t: Array, moved: Places) -> LinkMotion:
    """Give the motion of the links' frames by coordinates, rates and accelerations of the links as bodies.

    Parameters
    ----------
    made
        The machine of a scene.
    theta, t
        Drive angles (rad) and instants (s), ``(instants,)`` each.
    moved
        ``(instants, size)`` each.
    """
    bodies = made.bodies
    place, velocity, acceleration = (x[:, : bodies.machine.n].reshape(len(t), -1, 3) for x in moved)
    return LinkMotion(
        theta,
        t,
        tuple(made.scene.links),
        place[..., :2] + np.array(bodies.machine.r)[1:],
        velocity[..., :2],
        acceleration[..., :2],
        place[..., 2] + bodies.angles,
        velocity[..., 2],
        acceleration[..., 2],
    )


def acting(made: SceneMachine, links: LinkMotion) -> OfRigid:
    """Give what acts in a motion of rigid links.

    Parameters
    ----------
    made
        A machine whose rows hold all coordinates.
    links
        The motion, at ascending instants.
    """
    (machine, near), t = carried(made, links), links.time
    still, moving = np.zeros((len(t), machine.size)), made.scene.analysis.method != "static"
    by_rows = held(machine, t, angles=near, moving=moving)
    motion = Motion(machine, t, still, still, by_rows.accelerations, moving, angles=near)
    return OfRigid(replace(made, machine=machine), motion, links, by_rows)


def carried(made: SceneMachine, links: LinkMotion) -> tuple[Machine, list[Array]]:
    """Give the machine with a motion of its links as chart, and the angles of every term with their whole turns.

    Parameters
    ----------
    made, links
        As of `acting`.
    """
    bodies, machine = made.bodies, copy(made.machine)
    place = links.position - np.array(bodies.machine.r)[1:], links.angle - bodies.angles
    moved = place, (links.velocity, links.omega), (links.acceleration, links.alpha)
    machine.chart = Given(links.time, poses_of_links(made, *(coordinates(*part) for part in moved)))
    return machine, _near(made, links.angle)


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


def read_off(scene: Scene, found: OfRigid) -> xr.Dataset:
    """Label the motion, and forces and efforts in it.

    Parameters
    ----------
    scene
        The scene.
    found
        What acts at its positions.
    """
    links, forces, efforts, moments = found.links(), found.joint_forces, found.efforts(), found.joint_moments()
    variables: dict[str, Any] = {
        "joint_force": (("theta", "joint", "component"), np.stack(list(forces.values()), axis=1)),
        "drive_effort": (("theta", "drive"), np.stack(list(efforts.values()), axis=1)),
        "input_torque": (("theta",), next(iter(efforts.values()))),
        **found.frame(),
        **found.springs(),
        **found.points(),
    }
    if moments:
        variables["joint_moment"] = (("theta", "held"), np.stack(list(moments.values()), axis=1))
    labels = {
        "theta": links.theta,
        "time": ("theta", links.time),
        "joint": list(forces),
        "component": ["x", "y"],
        "drive": list(efforts),
        "held": list(moments),
        "support": list(found.supports),
        "point": list(found.traced),
        "spring": list(scene.springs),
        "damper": list(scene.dampers),
    }
    used = {dimension for dimensions, _ in variables.values() for dimension in dimensions} | {"time"}
    attributes = stamp(scene) | {"solver": str(scene.analysis.method), "effects": "[]", "dofs": len(scene.freedoms)}
    attributes |= {"elements": 0, "time_steps": 0}
    data = xr.Dataset(variables, {name: label for name, label in labels.items() if name in used}, attributes)
    places = rigid_places(scene, links)[["link_position", "link_angle"]]
    return joined(data, places, motion_of_links(scene, links), law_efforts(found.laws(), {}, {}, 0))


def _powers(scene: Scene, found: OfRigid) -> xr.Dataset:
    """Give the mean power of every cause, and how far they are from a balance; see `energy_balance`."""
    powers, time = found.powers(), found.motion.t
    if not any(power.any() for power in powers.values()):
        return xr.Dataset()
    if scene.analysis.method == "transient":
        energy = kinetic_energy(found.motion) + energy_of_terms(found.motion)
        mean = mean_in_time(time, powers) | stored(time, energy)
    else:
        mean = {name: float(power.mean()) for name, power in powers.items()}
    return balance_of(mean, max(float(np.abs(power).mean()) for power in powers.values()), 0.0)


QUANTITIES = "joint_force", "torque"  # whose errors are told beside those of accelerations


def _missed_by_positions(machine: LedMachine, links: LinkMotion) -> xr.Dataset:
    """Give by how much positions of a cycle miss the peaks of joint forces, efforts and accelerations between them."""
    scene = machine.made.scene
    analysis = scene.analysis
    if analysis.method not in CYCLIC or analysis.sub_intervals < 4 or not analysis.error_estimates:
        return xr.Dataset()
    still = _Between(scene, links, machine)
    missed = PeaksBetween(still, still.of(links)).missed_peaks()
    largest = {name: missed.peaks[name] for name in QUANTITIES}
    by_source = {name: {BETWEEN: missed.errors[name]} for name in QUANTITIES}
    errors = Errors(by_source, {BETWEEN: BY_POSITIONS}, measures(scene, largest), (), largest, missed)
    if not analysis.allow_coarse:
        errors.refuse_missed(scene)
    return of_errors(errors).dataset()


@dataclass(frozen=True)
class _Between(OverCycle):
    """The motion of rigid links between the positions, where all of it is known."""

    machine: LedMachine
    angles = CLOSENESS.cheap
    least = 2

    def moved(self, theta: Array) -> LinkMotion:
        """Give the motion of the links at drive angles (rad)."""
        return self.machine.links(theta / self.scene.cycle_rate)

    @property
    def knots(self) -> Array:
        """Drive angles to which the motion was followed (rad)."""
        return self.scene.cycle_rate * self.machine.led.t

    def of(self, motion: LinkMotion) -> Values:
        """Give the quantities in a motion."""
        together = max(1, TOGETHER // (3 * len(self.scene.links)) ** 2)
        parts = [motion.part(slice(k, k + together)) for k in range(0, len(motion.theta), together)]
        found = [acting(self.machine.made, part) for part in parts]
        forces = [np.stack(list(part.joint_forces.values()), axis=1) for part in found]
        efforts = [np.stack(list(part.efforts().values()), axis=1) for part in found]
        return {
            "joint_force": np.concatenate(forces)[:, :, None],
            "torque": np.concatenate(efforts)[..., None],
            ACCELERATIONS[0]: accelerations_of(self.scene, motion),
        }
