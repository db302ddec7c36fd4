"""Motion in time of rigid links with freedoms, by the equation of poses: a start, steps, errors, energy, a result.

Steps are few and long. Forces at a position follow from places and rates of the freedoms there alone: with their
accelerations all of the motion is known, and the rows of joints hold what it needs.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech._progress import reached
from fenics_mech.accuracy.quantities import measures_of_efforts
from fenics_mech.errors import AssemblyError, SceneError, SolverError, shortened
from fenics_mech.forces.joint_forces import effort_units
from fenics_mech.geometry import PLANE, Given, Rest
from fenics_mech.machine import Machine
from fenics_mech.machine.assembly import left_open
from fenics_mech.machine.energy import energy_of_terms, energy_of_weight, kinetic_energy
from fenics_mech.machine.from_scene import SceneMachine, lead, machine_of
from fenics_mech.machine.led_from_scene import MOVED
from fenics_mech.machine.motion import Motion, coordinates
from fenics_mech.machine.rigid_from_scene import motion_of_bodies, near_links
from fenics_mech.recovery.balance import balance_of
from fenics_mech.recovery.dataset import joined
from fenics_mech.recovery.law_efforts import law_efforts, with_law_units
from fenics_mech.recovery.of_rigid import OfRigid
from fenics_mech.recovery.result import Result
from fenics_mech.recovery.running import running
from fenics_mech.recovery.variables import with_units
from fenics_mech.response.sampling_checks import require_positions
from fenics_mech.response.transient.course import TRANSIENT, refuse_rough
from fenics_mech.rigid_by_poses import acting, carried, motion_of, read_off
from fenics_mech.scene import Prismatic, Scene, Slot
from fenics_mech.solve import States, Step, steps_in_time
from fenics_mech.solve.held import freed
from fenics_mech.terms.causes import Cause

IN_TWO_WAYS = 1e-5  # singular value of the joints' rows at a position that is found: below it links go on in two ways
STAGES = 7  # of a step, at least: rates, and so forces, are of that order, and places of order 13 at its end
LONGEST = 1 / 40, 1 / 20  # step of a cycle, and of a motion that nothing drives: loads may act between stages
LEAST = 1e-10  # of what a step may miss by: Newton's method ends at a thousandth of it, above rounding
SHARPER = 1e-3  # of the tolerance, which a step may miss by: rates and forces lose digits to places


def rigid_in_time(scene: Scene) -> Result:
    """Analyse a motion in time of rigid links.

    Parameters
    ----------
    scene
        The scene, with a freedom for all that its drives leave free.

    Raises
    ------
    SceneError
        When it has more positions than a result holds, or what no term states yet.
    SolverError
        When a step has no solution, or a freedom moves no mass.
    """
    analysis = scene.analysis
    refuse_rough(analysis)
    times = _times(scene)
    machine = FreeMachine.of(scene)
    course = Course.of(machine, times, max(analysis.stages, STAGES))
    data = _labelled(course)
    parts = [_powers(course), _errors(course, data), running(scene, times, *course.freedoms)]
    data = xr.merge([data, *parts], combine_attrs="no_conflicts")
    units = effort_units(scene.moved_joints, scene.joints)
    return Result.with_scene(
        scene, with_law_units(scene, with_units(data, units, scene.springs.values(), scene.dampers.values()))
    )


def _times(scene: Scene) -> Array:
    """Give the instants of the result (s)."""
    analysis = scene.analysis
    count = (analysis.cycles if scene.drives else 1) * analysis.sub_intervals
    if count + 1 > TRANSIENT.most_positions:
        raise SceneError(
            f"{shortened(count + 1)} positions are more than a result holds, {TRANSIENT.most_positions}",
            place="analysis.sub_intervals",
            hint="Give fewer cycles or sub_intervals",
        )
    require_positions(scene, count + 1)
    return scene.period / analysis.sub_intervals * np.arange(count + 1.0)


@dataclass(frozen=True)
class FreeMachine:
    """The machine of rigid links with freedoms, and the same with its freedoms held.

    Parameters
    ----------
    made
        The machine.
    holding
        The same, where rows lead the freedoms. They are the last rows.
    bodies
        The links as bodies with rows of joints, drives and freedoms, whose determinant has one sign all along.
    """

    made: SceneMachine
    holding: SceneMachine
    bodies: Machine

    @classmethod
    def of(cls, scene: Scene) -> FreeMachine:
        """Build both for a scene."""
        made = machine_of(scene)
        machine = copy(made.machine)
        machine.rows = list(machine.rows)
        holding = replace(made, machine=machine)
        for name in scene.freedoms:
            lead(holding, name, np.zeros_like)
        bodies, rows = copy(made.bodies.machine), made.bodies.machine.rows
        still = [row for row in rows if not row.leads and row.name not in scene.open_joints]
        bodies.rows = [*still, *(replace(row, value=np.zeros_like) for row in rows if row.leads)]
        bodies.forget_plan()
        return cls(made, holding, bodies)

    def at(self, t: Array, near: Array, place: Array, rate: Array) -> OfRigid:
        """Give the motion and what acts in it by places and rates of the freedoms ``(instants, freedoms)``.

        Parameters
        ----------
        t
            Instants, ascending (s).
        near
            Coordinates of the links as bodies near to those that are sought ``(instants, size)``.
        place, rate
            Angles (rad) and strokes (m) of the freedoms, and their rates.
        """
        moved = motion_of_bodies(self.made, t, near, (place, rate, np.zeros_like(place)))
        machine, angles = carried(self.holding, motion_of(self.made, t, t, moved))
        rows = range(len(machine.rows) - place.shape[1], len(machine.rows))
        try:
            second = freed(machine, t, rows, angles=angles)
        except np.linalg.LinAlgError as error:
            names = ", ".join(self.made.scene.freedoms)
            raise SolverError(f"a freedom at joint {names} moves no mass: give its links mass or inertia") from error
        moved = motion_of_bodies(self.made, t, moved[0], (place, rate, second))
        return acting(self.holding, motion_of(self.made, self.theta(t, place), t, moved))

    def theta(self, t: Array, place: Array) -> Array:
        """Give drive angles (rad); of the first freedom, where it turns and nothing is driven; else a phase.

        Parameters
        ----------
        t, place
            As of `at`.
        """
        scene = self.made.scene
        if scene.drives:
            return scene.coordinate(t).value
        if isinstance(scene.joints[next(iter(scene.freedoms))], Slot | Prismatic):
            return scene.cycle_rate * t
        return place[:, 0]

    def start(self) -> tuple[OfRigid, tuple[Array, Array], Machine, Array]:
        """Give what acts at the start, places and rates of freedoms, a machine that rests there, and its rates."""
        freedoms = self.made.scene.freedoms.values()
        place, rate = (np.array([[getattr(x, name) or 0.0 for x in freedoms]]) for name in ("start", "rate_at_start"))
        found = self.at(np.zeros(1), self.made.bodies.q[None], place, rate)
        known, machine = found.motion.machine.known.at(np.zeros(1)), copy(self.made.machine)
        machine.chart = Rest(PLANE, known.r[0], known.R[0])
        return found, (place, rate), machine, coordinates(machine, known.v, known.w)[0]

    def places(self, states: States, angle: Array) -> tuple[Array, Array, Array]:
        """Give coordinates of the links as bodies near to some states, and places and rates of the freedoms there.

        Parameters
        ----------
        states
            The states.
        angle
            Angles of the links, whole turns and all ``(instants, links)`` (rad).
        """
        made, machine = self.made, copy(self.made.machine)
        near, machine.chart = self.near(states, angle), Given(states.t, states.motion)
        still = np.zeros((len(states.t), machine.size))
        alone = Motion(machine, states.t, still, still, still, angles=states.measures)
        jets = [alone.jet(made.acting[f"freedoms.{name}"]) for name in made.scene.freedoms]
        place, rate = (np.stack([jet[k] for jet in jets], axis=1) for k in (0, 1))
        return near, place, rate

    def near(self, states: States, angle: Array) -> Array:
        """Give coordinates of the links as bodies near to some states; arguments as of `places`."""
        found = near_links(self.made, states.motion)
        found[:, 2 : self.bodies.n : 3] = angle - self.made.bodies.angles
        return found

    def determinants(self, q: Array) -> Array:
        """Give the determinant of the derivatives of all rows at coordinates of the bodies ``(instants,)``."""
        return np.asarray(np.linalg.det(left_open(self.bodies, 0.0, q)[1]))

    def refusal(self, t: float, q: Array) -> AssemblyError:
        """Say that the freedoms do not tell at an instant how links move, whose coordinates as bodies are given.

        Where the joints' own rows are singular, those with a freedom at any joint are too.
        """
        scene, J = self.made.scene, left_open(self.bodies, 0.0, q[None])[1][0]
        motion, count = np.abs(np.linalg.svd(J)[2][-1, 2::3]), len(scene.moved_joints)
        moved = ", ".join(list(scene.links)[k] for k in np.argsort(-motion) if motion[k] > MOVED * motion.max())
        kind, advice = "dead centre", "State the freedom at another joint, such as that of a link that can turn fully"
        if np.linalg.svd(J[:-count], compute_uv=False).min(initial=1.0) < IN_TWO_WAYS:
            kind = "change point"
            advice = (
                "No other joint says it either, as the links can go on in two ways. Take other lengths, or stops that "
                "keep the links away from it"
            )
        return AssemblyError(
            f"at {t:.6g} s the linkage comes to a {kind}: the motion of joint {', '.join(scene.moved_joints)} does not "
            f"say how {moved} moves. {advice}"
        )


@dataclass(frozen=True)
class Course:
    """A motion in time.

    Parameters
    ----------
    positions
        What acts at the positions of the result.
    freedoms
        Places and rates of the freedoms there ``(instants, freedoms)``.
    inside, weights
        What acts at the stages of all steps, and their weights in an integral over time (s).
    steps
        Number of steps.
    """

    positions: OfRigid
    freedoms: tuple[Array, Array]
    inside: OfRigid
    weights: Array
    steps: int

    @classmethod
    def of(cls, free: FreeMachine, times: Array, stages: int) -> Course:
        """Follow a motion from its start.

        Parameters
        ----------
        free
            The machine.
        times
            Instants of the positions, from 0 on (s).
        stages
            Of a step.
        """
        made = free.made
        scene, (start, started, machine, v) = made.scene, free.start()
        turns = np.isin(np.arange(machine.n), machine.places[:, 2])
        tolerance = max(SHARPER * scene.analysis.time_tolerance, LEAST)
        allowed = tolerance * np.where(turns, 1.0, machine.extent)
        longest = scene.period * LONGEST[0 if scene.drives else 1]
        poses = [made.end(f"{name}.{next(iter(link.points))}").pose for name, link in scene.links.items()]
        angle, inside, weights = start.links().angle[0], list[tuple[States, Array]](), list[Array]()
        at_positions = list[tuple[States, Array]]()
        for step in steps_in_time(machine, v, times[[0, -1]], tolerance=allowed, stages=stages, longest=longest):
            reached(end := step.t + step.h, 0.0, float(times[-1]))
            _refuse_singular(free, step, angle, poses)
            shares = (times[(times > step.t) & (times <= end)] - step.t) / step.h
            own = machine.places[poses, 2]
            if len(shares):
                at_positions.append((step.within(shares), angle + step.at(shares)[0][:, own]))
            inside.append((step.at_stages(), angle + step.at(step.tableau.c)[0][:, own]))
            angle = inside[-1][1][-1]
            weights.append(step.h * step.tableau.A[-1])
        reached_places = free.places(*_joined(at_positions))
        near, place, rate = (np.concatenate(x) for x in zip((made.bodies.q[None], *started), reached_places))
        states, angles = _joined(inside)
        within = free.at(states.t, *free.places(states, angles))
        positions = free.at(times, near, place, rate)
        return cls(positions, (place, rate), within, np.concatenate(weights), len(inside))


def _refuse_singular(free: FreeMachine, step: Step, angle: Array, poses: list[int]) -> None:
    """Raise `AssemblyError` where the determinant of the rows changes its sign in a step, and tell the instant."""

    def at(s: Array) -> Array:
        """Give coordinates of the links as bodies at shares of the step."""
        return free.near(step.within(s), angle + step.at(s)[0][:, step.machine.places[poses, 2]])

    shares = np.append(0.0, step.tableau.c)
    sizes = free.determinants(at(shares))
    for k in np.flatnonzero(sizes[1:] * sizes[0] <= 0)[:1]:
        share = brentq(lambda s: free.determinants(at(np.array([s])))[0], *shares[k : k + 2], xtol=1e-12)
        raise free.refusal(step.t + share * step.h, at(np.array([share]))[0])


def _joined(parts: list[tuple[States, Array]]) -> tuple[States, Array]:
    states, angles = zip(*parts)
    return States.joined(states), np.concatenate(angles)


def _labelled(course: Course) -> xr.Dataset:
    """Label the motion, and forces and efforts in it."""
    found, along = course.positions, ("theta", "freedom")
    largest = {name: float(np.abs(effort).max()) for name, effort in course.inside.laws().items()}
    place, rate = course.freedoms
    states = xr.Dataset(
        {"freedom_place": (along, place), "freedom_rate": (along, rate)}, {"freedom": list(found.made.scene.freedoms)}
    )
    laws = law_efforts(found.laws(), {}, largest, 0)
    data = read_off(found.made.scene, found).assign_attrs(time_steps=course.steps)
    return joined(data.drop_vars([name for name in laws.variables if name in data]), states, laws)


def _powers(course: Course) -> xr.Dataset:
    """Give the mean power of every cause, and what is stored, by the stages of all steps.

    Efforts in freedoms count without what accelerates their rotors.
    """
    inside, ends = course.inside, course.positions.motion
    powers, duration = inside.powers(), float(np.ptp(ends.t))
    mean = {cause: float(course.weights @ power) / duration for cause, power in powers.items()}
    rotors = np.array([part.inertia for part in course.positions.made.scene.freedoms.values()])
    energy = kinetic_energy(ends) + energy_of_terms(ends) - course.freedoms[1] ** 2 @ rotors / 2
    mean[Cause.STORED] = -float(energy[-1] - energy[0]) / duration
    if Cause.WEIGHT in mean:
        weight = energy_of_weight(ends)
        mean[Cause.WEIGHT] = -float(weight[-1] - weight[0]) / duration
    return balance_of(mean, max(float(np.abs(power).mean()) for power in powers.values()), 0.0)


def _errors(course: Course, data: xr.Dataset) -> xr.Dataset:
    """Give errors by the time steps, from a motion with one more stage in each."""
    scene = course.positions.made.scene
    if not scene.analysis.error_estimates:
        return xr.Dataset()
    stages = max(scene.analysis.stages, STAGES) + 1
    other = _labelled(Course.of(FreeMachine.of(scene), course.positions.motion.t, stages))
    found: dict[str, Any] = {}
    attributes: dict[str, Any] = {}
    for name, axis in {"joint_force": "joint", "drive_effort": "drive", "freedom_place": "freedom"}.items():
        change = np.abs(other[name].to_numpy() - data[name].to_numpy())
        by_part, largest = (_by_part(values) for values in (change, np.abs(data[name].to_numpy())))
        found[f"{name}_error"] = (("source", axis), by_part[None])
        measure = np.full_like(largest, max(float(largest.max(initial=0.0)), TINY))
        if name == "drive_effort":
            measure = measures_of_efforts(scene, largest, float(abs(data["joint_force"]).max()))
        relative = float((by_part / measure).max(initial=0.0))
        found[f"{name}_relative_error"] = (("source",), [relative])
        attributes[f"{name}_error_estimate"] = relative
    return xr.Dataset(found, {"source": ["time"]}, attributes)


def _by_part(values: Array) -> Array:
    """Give the largest over time of each joint, drive or freedom: of ``(times, parts, ...)``."""
    return np.asarray(np.moveaxis(values, 1, 0).reshape(values.shape[1], -1).max(axis=1))
