"""Analysis of a motion in time by the equation of poses: a start, steps up to each position, errors, energy, a result.

The links are followed from poses that move along. Afterwards they are measured against the rigid motion: that of links
that do not bend, whose drives and freedoms are where those of the bent ones are.
"""

from __future__ import annotations

import math
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._progress import reached
from fenics_mech.accuracy.estimate import Errors
from fenics_mech.accuracy.quantities import MEASURE
from fenics_mech.accuracy.remarks import after_contacts
from fenics_mech.by_poses import planned, quantities, read_off, told
from fenics_mech.errors import SceneError
from fenics_mech.forces.joint_forces import effort_units
from fenics_mech.geometry import PLANE, Given, PoseMotion, Rest
from fenics_mech.joints.law_terms import LawTerm
from fenics_mech.machine import Machine
from fenics_mech.machine.assembly import led
from fenics_mech.machine.drawn_from_scene import clock_of
from fenics_mech.machine.energy import energy_of_terms, energy_of_weight, kinetic_energy
from fenics_mech.machine.from_scene import SceneMachine, lead, machine_of
from fenics_mech.machine.motion import Motion, coordinates
from fenics_mech.machine.rigid_from_scene import Places, near_links, rigid_motion, values_at
from fenics_mech.recovery.balance import balance_of
from fenics_mech.recovery.dataset import joined, of_errors
from fenics_mech.recovery.law_efforts import law_efforts, with_law_units
from fenics_mech.recovery.mode_speeds import mode_speeds
from fenics_mech.recovery.of_poses import OfPoses
from fenics_mech.recovery.residual_vibration import residual_vibration
from fenics_mech.recovery.result import Result
from fenics_mech.recovery.running import running
from fenics_mech.recovery.signal import last_cycle, of_cycle
from fenics_mech.recovery.stress_figures import stress_figures
from fenics_mech.recovery.variables import with_units
from fenics_mech.response.periodic.steps import corners_to_cut
from fenics_mech.response.sampling_checks import refuse_hidden_peaks
from fenics_mech.response.velocity_jumps import passages
from fenics_mech.scene import Prismatic, Scene, Slot
from fenics_mech.scene.analysis_options import STATED_STARTS
from fenics_mech.scene.meshing import with_halves
from fenics_mech.scene.sampling import SAMPLING
from fenics_mech.solve import States, Step, damp_modes, equilibria, quasi_static, steps_in_time
from fenics_mech.solve.held_modes import POSITIONS
from fenics_mech.terms.causes import Cause

LONGEST = 1 / 40, 1 / 20  # step of a cycle, and of a motion that nothing drives: loads may act between stages
PEAKS = 60  # places in a step at which the peaks of contacts are looked for, which 8 steps in a contact tell to 1e-4
SMALL = 1e-4  # of the machine's extent, and rad: deflections below it are to be as exact as it. Their motion is stiff
SHARPER = 0.1  # of the tolerance of steps: its motion is the exact one beside that of the tolerance
SLOWLY = 3e-3  # rad, by which a slow motion is differentiated: its square is the error, and rounding is as small
SLOW = 4  # corrections of a start: accelerations of freedoms take two, and three derivatives of a slow motion four


def in_time_by_poses(scene: Scene) -> Result:
    """Analyse a motion in time.

    Parameters
    ----------
    scene
        The scene, with a freedom for all that its drives leave free.

    Raises
    ------
    SceneError
        When it has what no term or joint of poses states yet.
    SolverError
        When a step has no solution.
    UnresolvedError
        When an error is too large.
    """
    _refuse(scene)
    scene = planned(scene)
    whole = InTime.of(scene, times_of(scene))
    errors = estimated(whole) if scene.analysis.error_estimates else None
    return collected(whole, errors)


def _refuse(scene: Scene) -> None:
    """Raise `SceneError` for what a motion in time by poses does not have yet."""
    analysis = scene.analysis
    riding = [name for name, joint in scene.constraints.items() if getattr(joint, "member", None) is not None]
    refused = [(f"joints.{name}.member", "pins that ride along members") for name in riding]
    stated = (
        (analysis.lyapunov, "analysis.lyapunov", "Lyapunov exponents"),
        (analysis.poincare is not None, "analysis.poincare", "Poincare sections"),
        (bool(scene.impulses), "impulses", "impulses"),
        (analysis.start == "periodic", "analysis.start", "motions that repeat"),
        (analysis.start not in STATED_STARTS, "analysis.start", "starts from a result"),
        (bool(scene.freedoms) and np.any(scene.damping.ratio), "damping.ratio", "ratios of modes where freedoms move"),
        (scene.tolerance is not None, "tolerance", "a tolerance of the result"),
    )
    refused += [(place, what) for asked, place, what in stated if asked]
    if not scene.drives and not scene.freedoms:
        refused.append(("analysis.method", "motions of what nothing drives or frees"))
    if refused:
        place, what = refused[0]
        raise SceneError(f"motions in time by poses do not have {what} yet", place=place, hint="Write solver = 'auto'")


def times_of(scene: Scene) -> Array:
    """Give the instants of the result (s): equal parts of a cycle, which follow the run-up, or of the whole motion."""
    analysis = scene.analysis
    cycles = analysis.cycles if scene.drives else 1
    return scene.period / analysis.sub_intervals * np.arange(_lead(scene) + cycles * analysis.sub_intervals + 1.0)


def _stops(scene: Scene, times: Array) -> Array:
    """Give where steps end (s): at positions, where loads jump, and at corners of loads that steps do not show.

    A jump counts to the step after it, which begins by a rounding before it.
    """
    if not scene.drives:
        return times
    least, rate = math.ceil(1 / LONGEST[0]), abs(scene.cycle_rate)
    longest = scene.changed({"analysis.sub_intervals": max(least, scene.analysis.sub_intervals)})
    refuse_hidden_peaks(longest.changed({"analysis.sub_intervals": least * scene.analysis.stages}))
    jumps = [angle for load in scene.loads.values() for angle in load.jumps]
    cut = [passages(scene, angle, times[0], times[-1]) - 2 * SAMPLING.same / rate for angle in jumps]
    cut += [passages(scene, angle, times[0], times[-1]) for angle in corners_to_cut(longest)]
    found = np.unique(np.concatenate([times, *cut]))
    found = found[found >= times[0]]
    apart = np.diff(found, prepend=-np.inf) > SAMPLING.same / rate
    return np.union1d(found[apart], times)


def _lead(scene: Scene) -> int:
    """Give the number of positions before cycles count: those of the run-up, where no freedom moves."""
    if not scene.drives or scene.freedoms or scene.drives[0].run_up is None:
        return 0
    return max(0, math.ceil(scene.drives[0].run_up / scene.period * scene.analysis.sub_intervals - 1e-6))


@dataclass(frozen=True)
class OfTime(OfPoses):
    """A motion in time at its positions, with freedoms.

    Parameters
    ----------
    places
        Angles (rad) and strokes (m) of the freedoms, and two derivatives by time, ``(instants, freedoms)`` each.
    """

    places: Places

    @cached_property
    def theta(self) -> Array:
        """Drive angles (rad); of the first freedom, where it turns and nothing is driven; else a phase."""
        scene = self.made.scene
        if scene.drives or isinstance(scene.joints[next(iter(scene.freedoms))], Slot | Prismatic):
            return super().theta
        return self.places[0][:, 0]


@dataclass(frozen=True)
class InTime:
    """A motion in time of a scene's machine.

    Parameters
    ----------
    scene
        The scene.
    positions
        The motion at the positions of the result, beside the rigid one.
    inside, weights
        The motion at the stages of all steps, and their weights in an integral over time (s).
    ends
        The motion at its start, and at the end of its last step.
    change
        Difference of the last two cycles relative to the largest coordinate; infinite where there is only one.
    steps
        Number of steps.
    peaks
        The most that each law of contact exerts, between the stages too (N or N m).
    """

    scene: Scene
    positions: OfTime
    inside: OfPoses
    ends: Motion
    weights: Array
    change: float
    steps: int
    peaks: dict[str, float]

    @property
    def closings(self) -> int:
        """How often contacts closed."""
        return sum(term.closings for term in self.inside.made.machine.terms if isinstance(term, LawTerm))

    @classmethod
    def of(cls, scene: Scene, times: Array, sharper: float = 1.0, settled: float | None = None) -> InTime:
        """Follow the motion of a scene from its start.

        Parameters
        ----------
        scene
            The scene, with its effects chosen.
        times
            Instants of the positions (s).
        sharper
            Factor on the tolerance of its steps.
        settled
            Change from cycle to cycle at which it ends; None for that of the scene.
        """
        made, tolerance = _built(scene)
        machine, analysis = made.machine, scene.analysis
        share = sharper * analysis.time_tolerance
        v = _start(made)
        longest = scene.period * LONGEST[0 if scene.drives else 1]
        chosen = {"tolerance": share * tolerance, "share": share, "stages": analysis.stages, "longest": longest}
        steps = steps_in_time(machine, v, _stops(scene, times), **chosen)
        taken = _Taken(made, times, analysis.settled if settled is None else settled)
        for step in steps:
            if taken.over(step):
                break
        return taken.whole()


def _built(scene: Scene) -> tuple[SceneMachine, Array]:
    """Build a machine, and give the size of each coordinate: that of its static answers.

    Drives are at even positions of a cycle, and freedoms are held where they start.
    """
    made, held = machine_of(scene), machine_of(scene)
    for name, part in scene.freedoms.items():
        lead(held, name, values_at(np.zeros(1), np.array([part.start or 0.0])))
    if scene.freedoms:
        held.machine.chart = _rigid_at(held, np.zeros(1))
        times = np.zeros(1)
    else:
        held.machine.chart, times = _over_cycle(held)
        if np.any(scene.damping.ratio):
            still = quasi_static(held.machine, times).change[0]
            damp_modes(held.machine, scene.period, scene.damping.ratio, times=times)
            modal = held.machine.beams.modal
            assert modal is not None
            made.machine.beams.modal = replace(modal, clock=clock_of(scene))
            made.machine.forget_plan()
            return made, _sizes(made.machine, still)
    return made, _sizes(made.machine, quasi_static(held.machine, times).change[0])


def _sizes(machine: Machine, q: Array) -> Array:
    """Give the largest change of a place, or of a turn, for each coordinate ``(coordinates,)``."""
    turns = np.isin(np.arange(machine.n), machine.places[:, machine.geometry.d :])
    most = np.abs(q[:, : machine.n]).max(axis=0)
    return np.where(turns, most[turns].max(initial=SMALL), most[~turns].max(initial=SMALL * machine.extent))


def _over_cycle(made: SceneMachine) -> tuple[Given, Array]:
    """Give the rigid motion at even positions of the cycle at full speed, and when the drives are there (s)."""
    scene, bodies = made.scene, made.bodies
    finer = math.ceil(bodies.turned.shape[0] / POSITIONS)
    cycle = scene.period / POSITIONS / finer * np.arange(POSITIONS * finer)
    near = led(bodies.machine, bodies.q[None], cycle)[0][::finer, 0]
    begun = scene.drives[0].run_up or 0.0
    times = begun + np.mod(cycle[::finer] - clock_of(scene)(np.array([begun])), scene.period)
    order = np.argsort(times)
    none = (np.zeros((POSITIONS, 0)),) * 3
    return rigid_motion(made, times[order], near[order], none), times


def _rigid_at(made: SceneMachine, t: Array, freedoms: Places | None = None) -> Given:
    """Give the rigid motion about the start, with the freedoms as they move there, or at first without acceleration."""
    freedoms = freedoms or _freedoms_at(made.scene, t, np.zeros((len(t), len(made.scene.freedoms))))
    return rigid_motion(made, t, np.repeat(made.bodies.q[None], len(t), axis=0), freedoms)


def _freedoms_at(scene: Scene, t: Array, seconds: Array) -> Places:
    """Give the freedoms about the start by their accelerations, which are those of the middle instant all along."""
    freedoms = scene.freedoms.values()
    place, rate = (np.array([getattr(x, name) or 0.0 for x in freedoms]) for name in ("start", "rate_at_start"))
    at, middle = t[:, None], seconds[len(t) // 2]
    return place + at * rate + at**2 / 2 * middle, rate + at * middle, seconds


def _start(made: SceneMachine) -> Array:
    """Let the chart rest where the motion starts, and give the rates there ``(size,)``."""
    machine = made.machine
    if made.scene.analysis.start == "rigid":
        known, q = _rigid_at(made, np.zeros(1)).motion, np.zeros(machine.size)
    else:
        known, q = _slow_start(made)
    machine.chart = Rest(PLANE, known.r[0], known.R[0])
    v = coordinates(machine, known.v, known.w)[0]
    return machine.rebase(q, v, np.zeros_like(v))[0]


def _slow_start(made: SceneMachine) -> tuple[PoseMotion, Array]:
    """Give a start that is bent by loads and the rigid motion: its rates, and the coordinates beside it ``(size,)``.

    Freedoms go on as nothing holds them. A "smooth" start is that of the slow motion, which does not vibrate: each
    correction knows one more of its derivatives by time.
    """
    scene, held = made.scene, machine_of(made.scene)
    smooth, count = scene.analysis.start == "smooth", len(scene.freedoms)
    rates = [abs(scene.cycle_rate)] if scene.drives else []
    spacing = SLOWLY / max(1.0, *rates, *(abs(part.rate_at_start) for part in scene.freedoms.values()))
    t = spacing * np.array([-1.0, 0.0, 1.0]) if smooth else np.zeros(1)
    seconds, value = np.zeros((len(t), count)), np.zeros((len(t), count))
    for k, name in enumerate(scene.freedoms):
        lead(held, name, values_at(t, value[:, k]))
    first = second = np.zeros((1, held.machine.n))

    def bent(seconds: Array) -> tuple[PoseMotion, Array, Array]:
        """Give the chart, the coordinates beside it, and what holds the freedoms."""
        freedoms = _freedoms_at(scene, t, seconds)
        value[:] = freedoms[0]
        known = held.machine.with_rates(_rigid_at(held, t, freedoms).motion, first, second)
        held.machine.chart = Given(t, known)
        q, a = equilibria(held.machine, t, np.zeros((len(t), held.machine.size)), what="the start")
        rows = held.machine.n + len(held.machine.rows)
        return known, q, a[:, rows - count : rows]

    for _ in range(SLOW if smooth or count else 1):
        known, q, pull = bent(seconds)
        if count:
            by = np.stack([bent(seconds + one)[2] - pull for one in np.eye(count)], axis=-1)
            seconds = seconds - np.linalg.solve(by, pull[..., None])[..., 0]
        if smooth:
            coordinates = q[:, : held.machine.n]
            first = (coordinates[2:] - coordinates[:1]) / (2 * spacing)
            second = (coordinates[2:] - 2 * coordinates[1:2] + coordinates[:1]) / spacing**2
    middle = slice(len(t) // 2, len(t) // 2 + 1)
    return known.part(middle), np.append(
        q[middle.start, : held.machine.n], np.zeros(made.machine.size - held.machine.n)
    )


def noted_peaks(peaks: dict[str, float], step: Step, scene: Scene) -> None:
    """Note the most that contacts exert in a step, which places and rates tell between its stages too.

    Parameters
    ----------
    peaks
        The most by law so far, which is added to (N or N m).
    step
        The step.
    scene
        The scene.
    """
    shares = np.linspace(0, 1, PEAKS)
    for k, term in enumerate(step.machine.terms):
        if isinstance(term, LawTerm) and term.closed.any():
            found = step.measured(k, shares)
            alone = term.law.joint.name in scene.open_joints
            size = term.size(step.t + step.h * shares, found.x, found.rate, alone)
            peaks[term.name] = max(peaks.get(term.name, 0.0), float(np.abs(size).max()))


class _Taken:
    """Takes the positions of the result as steps come to them, and says whether cycles have settled."""

    def __init__(self, made: SceneMachine, times: Array, settled: float) -> None:
        self.made, self.times, self.settled, self.change = made, times, settled, math.inf
        self.positions: list[States] = []
        self.stages: list[States] = []
        self.weights: list[Array] = []
        self.peaks: dict[str, float] = {}  # of what laws of contact exert
        self.cycle: Array | None = None  # coordinates of the last cycle that was compared

    def over(self, step: Step) -> bool:
        """Take the positions in a step, and say whether the motion is over."""
        if not self.positions:
            self.start = step.at_start()
            self.positions.append(self.start)
        reached(step.t + step.h, 0.0, float(self.times[-1]))
        self.stages.append(step.at_stages())
        self.weights.append(step.h * step.tableau.A[-1])
        noted_peaks(self.peaks, step, self.made.scene)
        self.end = step.at_end()
        if self.end.t[0] < self.times[len(self.positions)] * (1 - 1e-12):
            return False
        self.positions.append(self.end)
        return self._is_settled()

    def _is_settled(self) -> bool:
        """Compare the last two cycles, where one is full."""
        scene = self.made.scene
        count, samples = len(self.positions) - 1 - _lead(scene), scene.analysis.sub_intervals
        if not scene.drives or scene.freedoms or count <= 0 or count % samples:
            return False
        now, before = self._beside(States.joined(self.positions[-samples:])).motion.q, self.cycle
        self.cycle = now = now[:, : self.made.machine.n]
        if before is None:
            return False
        self.change = float(np.abs(now - before).max() / max(np.abs(now).max(), 1e-300))
        return self.change < self.settled

    def _alone(self, states: States) -> OfPoses:
        """Give a motion beside itself."""
        machine = copy(self.made.machine)
        machine.chart = Given(states.t, states.motion)
        still = np.zeros((len(states.t), machine.size))
        a = still.copy()
        a[:, machine.n :] = states.others
        return OfPoses(
            replace(self.made, machine=machine), Motion(machine, states.t, still, still, a, angles=states.measures)
        )

    def _beside(self, states: States) -> OfTime:
        """Give a motion beside the rigid one."""
        alone = self._alone(states).motion
        moved = [alone.jet(self.made.acting[f"freedoms.{name}"]) for name in self.made.scene.freedoms]
        none = (np.zeros((len(states.t), 0)),) * 3
        places = tuple(np.stack(part, axis=1) for part in zip(*moved)) if moved else none
        rigid = rigid_motion(self.made, states.t, near_links(self.made, states.motion), places)  # type: ignore[arg-type]
        motion = alone.beside(rigid)
        return OfTime(replace(self.made, machine=motion.machine), motion, places)  # type: ignore[arg-type]

    def whole(self) -> InTime:
        """Give the motion."""
        return InTime(
            self.made.scene,
            self._beside(States.joined(self.positions)),
            self._alone(States.joined(self.stages)),
            self._alone(States.joined([self.start, self.end])).motion,
            np.concatenate(self.weights),
            self.change,
            len(self.stages),
            self.peaks,
        )


def estimated(whole: InTime) -> Errors:
    """Estimate the errors of a motion: by sharper steps, by halved elements, and between stations.

    Contacts let nearly the same motions part. After one, halved elements tell nothing, and sharper steps where asked.
    """
    scene, times, here = whole.scene, whole.positions.motion.t, quantities(whole.positions)
    better, asked = {}, scene.analysis.error_estimates == "contacts"
    if not whole.closings or asked:
        better["time"] = InTime.of(scene, times, SHARPER, settled=0.0)
    if not whole.closings:
        better["mesh"] = InTime.of(with_halves(scene), times, settled=0.0)
    parts = {name: (quantities(other.positions) - here).largest for name, other in better.items()}
    errors = told(scene, here, parts)
    return replace(errors, remarks=(after_contacts(scene.analysis, "a tenth of"),)) if whole.closings else errors


def collected(whole: InTime, errors: Errors | None) -> Result:
    """Label what was found.

    Parameters
    ----------
    whole
        The motion.
    errors
        Its errors; None where they are not estimated.
    """
    scene, found = whole.scene, whole.positions
    data = read_off(found).assign_attrs(cycle_change=whole.change, time_steps=whole.steps)
    return labelled_in_time(scene, data, [_power(whole, errors), _of_freedoms(found), _of_laws(whole)], errors)


def labelled_in_time(scene: Scene, data: xr.Dataset, known: list[xr.Dataset], errors: Errors | None) -> Result:
    """Add to what is read off a motion in time what follows from it.

    Parameters
    ----------
    scene
        The scene.
    data
        What is read off.
    known
        What else is known of the motion.
    errors
        As of `collected`.
    """
    parts = [
        *known,
        residual_vibration(scene, data),
        mode_speeds(scene),
        *([] if errors is None else [of_errors(errors).dataset()]),
    ]
    data = joined(data, *parts)
    cycle = last_cycle(scene.analysis, scene.drives, data)
    data = joined(data, stress_figures(scene, data, cycle))
    if cycle is not None:
        data = joined(data, of_cycle(data, cycle, scene.period))
    units = effort_units(scene.moved_joints, scene.joints)
    return Result.with_scene(scene, with_units(data, units, scene.springs.values(), scene.dampers.values()))


def _of_freedoms(found: OfTime) -> xr.Dataset:
    """Give angles and strokes of the freedoms, and their rates."""
    scene, (place, rate, _) = found.made.scene, found.places
    if not scene.freedoms:
        return xr.Dataset()
    along = ("theta", "freedom")
    states = xr.Dataset(
        {"freedom_place": (along, place), "freedom_rate": (along, rate)}, {"freedom": list(scene.freedoms)}
    )
    return joined(states, running(scene, found.motion.t, place, rate))


def _of_laws(whole: InTime) -> xr.Dataset:
    """Give what laws of joints exert, and the most of it at the stages of all steps."""
    inside = {name: float(np.abs(effort).max()) for name, effort in whole.inside.laws().items()}
    inside |= {name: max(size, inside[name]) for name, size in whole.peaks.items()}
    found = law_efforts(whole.positions.laws(), whole.positions.depths(), inside, whole.closings)
    return with_law_units(whole.scene, found)


def _power(whole: InTime, errors: Errors | None) -> xr.Dataset:
    """Give the mean power of every cause, by the stages of all steps, and what the machine stores."""
    powers, duration = whole.inside.powers(), float(np.ptp(whole.ends.t))
    mean = {cause: float(whole.weights @ power) / duration for cause, power in powers.items()}
    weight, rotors = energy_of_weight(whole.ends), _of_rotors(whole)
    stored = kinetic_energy(whole.ends) + energy_of_terms(whole.ends) - rotors
    if any(whole.scene.gravity):
        drive = next(iter(mean))
        mean = {drive: mean[drive], Cause.WEIGHT: -float(weight[1] - weight[0]) / duration} | mean
    mean[Cause.STORED] = -float(stored[1] - stored[0]) / duration
    passed = max(float(np.abs(power).mean()) for power in powers.values())
    bound = np.nan
    if errors is not None and whole.scene.drives:
        uncertain = np.sum(list(errors.errors["torque"].values()), axis=0)[: len(whole.scene.drives)]
        bound = float(uncertain @ np.abs(whole.positions.drive_rates()).mean(axis=0))
    exchanged = float(np.ptp(kinetic_energy(whole.inside.motion))) / duration
    return balance_of(mean, max(MEASURE.small_power * passed, exchanged), bound)


def _of_rotors(whole: InTime) -> Array:
    """Give the energy of rotors at freedoms ``(instants,)`` (J): efforts count without what accelerates them."""
    ends = OfPoses(whole.inside.made, whole.ends)
    parts = {name: part.inertia for name, part in whole.scene.freedoms.items() if part.inertia}
    each = (inertia / 2 * ends.rate_of(f"freedoms.{name}") ** 2 for name, inertia in parts.items())
    return sum(each, np.zeros(2))
