"""Analysis of a motion in time by the equation of poses: a start, steps up to each position, errors, energy, a result.

The links are followed from poses that move along. Afterwards they are measured against the rigid motion: that of links
that do not bend, whose drives and freedoms are where those of the bent ones are.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._progress import reached
from fenics_mech.answers.by_poses import judged_errors, planned, read_off, with_assumed_shear
from fenics_mech.answers.mode_speeds import mode_speeds
from fenics_mech.errors import AssemblyError, SceneError, SolverError, shortened
from fenics_mech.estimate.error_sources import Errors
from fenics_mech.estimate.quantities import MEASURE
from fenics_mech.estimate.remarks import after_contacts
from fenics_mech.geometry import PLANE, Given, PoseMotion, Rest
from fenics_mech.joints.law_terms import LawTerm
from fenics_mech.machine import Machine
from fenics_mech.machine.along_members import along_members
from fenics_mech.machine.assembly import led
from fenics_mech.machine.drawn_from_scene import clock_of
from fenics_mech.machine.energy import energy_of_terms, energy_of_weight, kinetic_energy
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.from_scene import SceneMachine, lead, machine_of
from fenics_mech.machine.motion import Motion, coordinates
from fenics_mech.machine.rigid_from_scene import Places, driven, links_of_poses, near_links, rigid_motion, values_at
from fenics_mech.machine.section_forces import Sections
from fenics_mech.planning.cycle_steps import corners_to_cut
from fenics_mech.planning.discretisation import refuse_unknown
from fenics_mech.planning.sampling_checks import refuse_hidden_peaks, require_positions
from fenics_mech.planning.start_state import GoneOn, poses_to_go_on_from
from fenics_mech.recovery.balance import balance_of, given_by
from fenics_mech.recovery.beside_motion import Beside, beside_motion
from fenics_mech.recovery.dataset import joined, of_errors
from fenics_mech.recovery.freedoms_and_laws import law_efforts, of_freedoms, running
from fenics_mech.recovery.of_poses import OfPoses
from fenics_mech.recovery.result import Result
from fenics_mech.recovery.rigid_places import between_ends
from fenics_mech.recovery.signal import last_cycle, of_cycle, residual_vibration
from fenics_mech.recovery.strains import without_modes
from fenics_mech.recovery.stress_figures import stress_figures
from fenics_mech.recovery.variables import with_units
from fenics_mech.scene import Prismatic, Scene, Slot
from fenics_mech.scene.analysis_options import MOST_POSITIONS, refuse_rough
from fenics_mech.scene.free_motion_checks import NO_DURATION
from fenics_mech.scene.meshing import with_halves
from fenics_mech.scene.sampling import SAMPLING
from fenics_mech.scene.strikes import passages, strikes_between
from fenics_mech.solve import States, Step, damp_modes, equilibria, held_damping, quasi_static, steps_in_time
from fenics_mech.solve.blows import struck
from fenics_mech.solve.held_modes import POSITIONS
from fenics_mech.solve.repeated import RepeatedMotion
from fenics_mech.terms import HeldDamping, ModalDamping
from fenics_mech.terms.causes import Cause

logger = logging.getLogger(__name__)
LONGEST = 1 / 40, 1 / 20  # step of a cycle, and of a motion that nothing drives: loads may act between stages
PEAKS = 60  # places in a step at which the peaks of contacts are looked for, which 8 steps in a contact tell to 1e-4
SMALL = 1e-4  # of the machine's extent, and rad: deflections below it are to be as exact as it. Their motion is stiff
LEAST = (
    1e-11  # of the extent, and rad, that a step may miss by: Newton's method ends at a thousandth of it, at rounding
)
MISSED = 1e-3  # of the tolerance, which a step may miss places of rigid motions by: forces lose digits to them
SHARPER = 0.1  # of the tolerance of steps: its motion is the exact one beside that of the tolerance
STAGES = 5  # of a step, at least: with 3 strains are 3 to 10 times as far off in the same time
UNSEEN = 2.0  # times the difference from it: of what a start excites it has resolved 40 % at a tolerance of 0.02
SHORTER = 0.5  # the same of the longest step
SLOWLY = 3e-3  # rad, by which a slow motion is differentiated: its square is the error, and rounding is as small
AHEAD = 0.5  # of a step, at which its modes are found: the error of their damping is of second order
FELT = 1e-8  # of accelerations of freedoms at a start, below which a correction is rounding
BESIDE = 1e-3  # of that spacing, by which rates of rows are differences
SLOW = 4  # corrections of a start: accelerations of freedoms take two, and three derivatives of a slow motion four


def in_time_by_poses(scene: Scene) -> Result:
    """Analyse a motion in time."""
    refuse_rough(scene.analysis)
    if not scene.drives and scene.analysis.duration is None:
        raise SceneError(NO_DURATION, place="analysis.duration")
    chosen, scene = scene.effects == "auto", planned(scene)
    if scene.tolerance is not None:
        refuse_unknown(scene)
    start = poses_to_go_on_from(scene, machine_of(scene).machine.n)
    whole = InTime.of(scene, times_of(scene, start.time if start else 0.0), start=start)
    errors = estimated(whole, start, chosen) if scene.analysis.error_estimates else None
    return collected(whole, errors)


def times_of(scene: Scene, begin: float = 0.0) -> Array:
    """Give the instants of the result (s): equal parts of a cycle, which follow the run-up, or of the whole motion."""
    analysis = scene.analysis
    count = _lead(scene, begin) + (analysis.cycles if scene.drives else 1) * analysis.sub_intervals
    if count >= MOST_POSITIONS:
        raise SceneError(
            f"{shortened(count + 1)} positions are more than a result holds, {MOST_POSITIONS}",
            place="analysis.cycles",
            hint="Give fewer cycles or sub_intervals, and go on from the result with analysis.start",
        )
    require_positions(scene, count + 1)
    return begin + scene.period / analysis.sub_intervals * np.arange(count + 1.0)


def _stops(scene: Scene, times: Array) -> Array:
    """Give where steps end (s): at positions, where loads jump, and at corners of loads that steps do not show."""
    # A jump counts to the step after it, which begins by a rounding before it.
    near = SAMPLING.same / abs(scene.cycle_rate)
    cut = [np.array([strike.time for strike in strikes_between(scene, float(times[0]), float(times[-1]))])]
    if scene.drives:
        least = math.ceil(1 / LONGEST[0])
        longest = scene.changed({"analysis.sub_intervals": max(least, scene.analysis.sub_intervals)})
        refuse_hidden_peaks(longest.changed({"analysis.sub_intervals": least * scene.analysis.stages}))
        jumps = [angle for load in scene.loads.values() for angle in load.jumps]
        cut += [passages(scene, angle, times[0], times[-1]) - 2 * near for angle in jumps]
        cut += [passages(scene, angle, times[0], times[-1]) for angle in corners_to_cut(longest)]
    found = np.concatenate(cut)
    apart = (np.abs(found[:, None] - times).min(axis=1) > near) & (found > times[0])
    found = np.sort(found[apart])
    return np.union1d(found[np.diff(found, prepend=-np.inf) > near], times)


def _lead(scene: Scene, begin: float) -> int:
    """Give the number of positions from an instant (s) on before cycles count: run-ups where no freedom moves."""
    if not scene.drives or scene.freedoms or scene.drives[0].run_up is None:
        return 0
    return max(0, math.ceil((scene.drives[0].run_up - begin) / scene.period * scene.analysis.sub_intervals - 1e-6))


@dataclass(frozen=True)
class OfTime(OfPoses):
    """A motion in time at its positions, with freedoms."""

    # angles (rad) and strokes (m) of the freedoms, and two derivatives by time, ``(instants, freedoms)`` each
    freed: Places

    @cached_property
    def elastic(self) -> Evaluation:  # type: ignore[override]
        """The residual without what damps modes and the material."""
        return without_modes(self.motion, material=True)

    @cached_property
    def bare(self) -> Sections:  # type: ignore[override]
        """Forces in sections without what damps, which is no strain."""
        beams = self.motion.machine.beams
        if beams.modal is None and not beams.damping.any():
            return self.sections
        return along_members(self.made, self.elastic, self.motion.a, self.stations, self.bent)

    @cached_property
    def deflection(self) -> Array:  # type: ignore[override]
        """Displacement of the members' axes from the rigid motion ``(instants, members, stations, 2)`` (m)."""
        ends = np.stack([self._places(which) for which in (0, -1)], axis=2)
        return self.bare.place - between_ends(ends, self.stations)

    @cached_property
    def theta(self) -> Array:
        """Drive angles (rad); of the first freedom, where it turns and nothing is driven; else a phase."""
        scene = self.made.scene
        free = next(iter(scene.freedoms), None)
        if scene.drives or free is None or isinstance(scene.joints[free], Slot | Prismatic):
            return super().theta
        return self.freed[0][:, 0]


@dataclass(frozen=True)
class InTime:
    """A motion in time of a scene's machine."""

    scene: Scene
    positions: OfTime  # the motion at the positions of the result, beside the rigid one
    # inside, weights: the motion at the stages of all steps, and their weights in an integral over time (s)
    inside: OfPoses
    ends: Motion  # the motion at its start, and at the end of its last step
    weights: Array
    # difference of the last two cycles relative to the largest coordinate; infinite where there is only one
    change: float
    steps: int
    peaks: dict[str, float]  # the most that each law of contact exerts, between the stages too (N or N m)
    struck: Array  # what impulses, and what drives give at them (J)
    beside: Beside | None = None  # what was followed beside it

    @property
    def closings(self) -> int:
        """How often contacts closed."""
        return sum(term.closings for term in self.inside.made.machine.terms if isinstance(term, LawTerm))

    @classmethod
    def of(
        cls,
        scene: Scene,
        times: Array,
        sharper: float = 1.0,
        settled: float | None = None,
        start: GoneOn | None = None,
        also: Callable[[Step], None] | None = None,
        ends: Array | None = None,
    ) -> InTime:
        """Follow the motion of a scene from its start."""
        # times: instants of the positions (s); ends: its start, and instants at which its steps end, with the
        # positions (s); None where they are chosen
        angles = None if start is None else start.angles
        made, tolerance, damped = _built(_freed_where(scene, start.freedoms) if start and angles is None else scene)
        machine, analysis = made.machine, scene.analysis
        share = sharper * analysis.time_tolerance
        v = start_of(made) if start is None else going_on(made, start.state)
        made = replace(made, scene=scene)
        longest = scene.period * LONGEST[0 if scene.drives else 1]
        if sharper < 1:  # of steps that are as long as they may be, or end at positions, the tolerance tells nothing
            longest = SHORTER * min(longest, scene.period / analysis.sub_intervals)
        allowed = np.maximum(share * tolerance, LEAST * machine.extent)
        stages = max(analysis.stages, STAGES if machine.beams.modal is None else 1)  # ratios couple all elements
        turns = np.isin(np.arange(machine.n), machine.places[:, machine.geometry.d :])
        stops = _stops(scene, times) if ends is None else ends
        struck = _Struck.of(made, stops) if scene.impulses else None
        beside = Beside.of_poses(made, times, v)
        taken = _Taken(made, times, analysis.settled if settled is None else settled, struck)
        steps = steps_in_time(
            machine,
            v,
            stops,
            tolerance=np.maximum(MISSED * share * np.where(turns, 1.0, machine.extent), allowed),
            shapes=partial(_shapes, made, allowed),
            share=share,
            stages=stages,
            longest=longest if ends is None else math.inf,
            h=None if ends is None else float(np.ptp(ends)),
            struck=struck,
            angles=angles or None,
        )
        for step in steps:
            over = taken.over(step)
            beside.take(step)
            if also is not None:
                also(step)
            if over:
                break
            if damped is not None:
                damped.after(step)
        return replace(taken.whole(), beside=beside)


def _built(scene: Scene) -> tuple[SceneMachine, Array, _ModesDamped | None]:
    """Build a machine, give the size of each coordinate, and what damps its modes as freedoms move on."""
    # The size is that of static answers: drives are at even positions of a cycle, and freedoms are held where they
    # start.
    made, held, damped = machine_of(scene), machine_of(scene), None
    ratio = scene.damping.ratio
    for name, part in scene.freedoms.items():
        lead(held, name, partial(np.full_like, fill_value=part.start or 0.0))
    cyclic = scene.drives and not scene.freedoms
    if cyclic:
        held.machine.chart, times = _over_cycle(held)
    else:
        held.machine.chart, times = _rigid_at(held, np.zeros(1)), np.zeros(1)
    sizes = _sizes(made.machine, quasi_static(held.machine, times).change[0])
    if np.any(ratio) and cyclic:
        damp_modes(held.machine, scene.period, ratio, times=times, fastest=math.inf)  # fast ones would ring on
        modal = held.machine.beams.modal
        assert isinstance(modal, ModalDamping)
        made.machine.beams.modal = replace(modal, clock=clock_of(scene))
    elif np.any(ratio):
        damped = _ModesDamped.of(made, held)
    made.machine.forget_plan()
    return made, sizes, damped


@dataclass
class _ModesDamped:
    """Damps the modes that a machine has where its freedoms are held, anew after each step."""

    # They are those of the middle of the next step, which is taken to be as the last one.

    made: SceneMachine  # made, held: the machine, and one whose freedoms are led
    held: SceneMachine
    damping: HeldDamping

    @classmethod
    def of(cls, made: SceneMachine, held: SceneMachine) -> _ModesDamped:
        """Begin where the chart of the held machine is."""
        roots = held_damping(held.machine, 0.0, made.scene.damping.ratio)
        made.machine.beams.modal = found = HeldDamping([0.0], [roots])
        return cls(made, held, found)

    def after(self, step: Step) -> None:
        """Find them after a step; where links do not come together, or are not held, the last ones hold on."""
        made, freedoms = self.made, self.made.scene.freedoms
        if not freedoms:
            return
        t, middle = step.t + step.h, np.array([1 + AHEAD])
        terms = [made.machine.terms.index(made.acting[f"freedoms.{name}"]) for name in freedoms]
        place: Array = np.array([[step.measured(k, middle).x[0, 0, 0] for k in terms]])
        still = np.zeros_like(place)
        near = near_links(made, step.at_end().motion)
        try:
            at = step.t + step.h * middle
            self.held.machine.chart = rigid_motion(self.held, at, near, (place, still, still))
            roots = held_damping(self.held.machine, float(at[0]), made.scene.damping.ratio)
        except (AssemblyError, SolverError) as error:
            logger.info("modes at %g s are damped as before: %s", t, error)
            return
        self.damping.starts.append(t)
        self.damping.roots.append(roots)


def _sizes(machine: Machine, q: Array) -> Array:
    """Give the largest change of a place, or of a turn, for each coordinate ``(coordinates,)``."""
    turns = np.isin(np.arange(machine.n), machine.places[:, machine.geometry.d :])
    most = np.abs(q[:, : machine.n]).max(axis=0)
    return np.where(turns, most[turns].max(initial=SMALL), most[~turns].max(initial=SMALL * machine.extent))


def _shapes(made: SceneMachine, allowed: Array) -> Array:
    """Give what links change beside their nearest rigid motion, over what is allowed ``(shapes, coordinates)``."""
    # allowed: of every coordinate ``(coordinates,)`` (m, rad)
    machine, r, found = made.machine, made.machine.known.at(np.zeros(1)).r[0], []
    for link in range(len(made.scene.links)):
        poses = np.flatnonzero(links_of_poses(made) == link)
        x, y = (r[poses] - r[poses].mean(axis=0)).T
        arm = max(float(np.hypot(x, y).max()), SMALL * machine.extent)
        rigid = np.zeros((len(poses), 3, 3))  # place and turn, times the arm, of each pose by two ways and a turn
        rigid[:, 0, 0] = rigid[:, 1, 1] = 1.0
        rigid[:, 0, 2], rigid[:, 1, 2], rigid[:, 2, 2] = -y / arm, x / arm, 1.0
        own = np.linalg.qr(rigid.reshape(-1, 3))[0]
        places = machine.places[poses].ravel()
        scale = np.tile([1.0, 1.0, arm], len(poses))
        beside = (np.eye(len(places)) - own @ own.T) * scale / (scale * np.append(allowed, np.inf)[places])[:, None]
        moved = np.zeros((len(places), machine.n + 1))
        np.add.at(moved.T, places, beside.T)
        found.append(moved[:, :-1])
    return np.concatenate(found)


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
    freedoms = freedoms or _freedoms_at(made.scene, t, np.zeros((len(t), len(made.scene.freedoms))), 0)
    return rigid_motion(made, t, np.repeat(made.bodies.q[None], len(t), axis=0), freedoms)


def _freedoms_at(scene: Scene, t: Array, seconds: Array, start: int) -> Places:
    """Give the freedoms about the start by their accelerations, which are those of its instant all along."""
    freedoms = scene.freedoms.values()
    place, rate = (np.array([getattr(x, name) or 0.0 for x in freedoms]) for name in ("start", "rate_at_start"))
    at, there = t[:, None], seconds[start]
    return place + at * rate + at**2 / 2 * there, rate + at * there, seconds


def start_of(made: SceneMachine) -> Array:
    """Let the chart rest where the motion starts, and give the rates there ``(size,)``."""
    machine = made.machine
    if made.scene.analysis.start == "rigid":
        known, q = _rigid_at(made, np.zeros(1)).motion, np.zeros(machine.size)
    else:
        known, q = _slow_start(made)
    machine.chart = Rest(PLANE, known.r[0], known.R[0])
    v = coordinates(machine, known.v, known.w)[0]
    return machine.rebase(q, v, np.zeros_like(v))[0]


def _freed_where(scene: Scene, freedoms: Array) -> Scene:
    """Give a scene whose freedoms start at places, with rates ``(2, freedoms)``."""
    moved: dict[str, float] = {}
    for name, place, rate in zip(scene.freedoms, *freedoms):
        moved |= {f"freedoms.{name}.start": float(place), f"freedoms.{name}.speed": float(rate)}
    return scene.changed(moved)


def going_on(made: SceneMachine, state: Array) -> Array:
    """Let the chart rest at coordinates of poses, and give the rates there ``(size,)``."""
    # state: coordinates and their rates ``(2, n)``
    machine, d = made.machine, made.machine.geometry.d
    there = machine.places >= 0
    found = np.column_stack([np.array(machine.r), PLANE.vector(np.array(machine.R))[:, 0]])
    found[there] = state[0][machine.places[there]]
    machine.chart = Rest(PLANE, found[:, :d], PLANE.turn(found[:, d:]))
    v = np.append(state[1], np.zeros(machine.size - machine.n))
    return machine.rebase(np.zeros_like(v), v, np.zeros_like(v))[0]


def _state_of(end: Motion) -> xr.Dataset:
    """Label coordinates of the poses and their rates at the end of a motion."""
    machine, motion = end.machine, end.machine.known.at(end.t)
    last = motion.part(slice(-1, None))
    places = coordinates(machine, last.r, PLANE.vector(last.R))[0, : machine.n]
    rates = coordinates(machine, last.v, last.w)[0, : machine.n]
    return xr.Dataset({"state": (("dof", "derivative"), np.stack([places, rates], axis=1))})


@dataclass
class _Struck:
    """Impulses that strike in a motion, with what they give."""

    made: SceneMachine
    due: dict[float, list[int]]  # numbers of the impulses by their instants, which are ends of steps
    begin: float
    # what impulses, and what drives give at them, after the start (J)
    given: Array = field(default_factory=lambda: np.zeros(2))

    @classmethod
    def of(cls, made: SceneMachine, stops: Array) -> _Struck:
        """Find the impulses of a motion whose steps end at instants (s)."""
        names, begin = list(made.scene.impulses), float(stops[0])
        found = strikes_between(made.scene, begin, float(stops[-1]))
        near = (stops[int(np.abs(stops - strike.time).argmin())] for strike in found)
        return cls(made, {float(t): [names.index(name) for name in x.names] for t, x in zip(near, found)}, begin)

    def __call__(self, t: float, v: Array) -> Array:
        """Give the rates after what strikes at an instant ``(size,)``."""
        if t not in self.due:
            return v
        made, n = self.made, self.made.machine.n
        jumps, works = struck(made.machine, self.due[t], t, v)
        if t != self.begin:  # what is stored at the start has it
            rates = driven(made, np.array([t]))[1][0]
            self.given += works.sum(), -jumps[:, n + np.array(made.driven, dtype=int)].sum(axis=0) @ rates
        return np.asarray(v + np.where(np.arange(len(v)) < n, jumps.sum(axis=0), 0.0))


def _slow_start(made: SceneMachine) -> tuple[PoseMotion, Array]:
    """Give a start that is bent by loads and the rigid motion: its rates, and the coordinates beside it ``(size,)``."""
    # Freedoms go on as nothing holds them. A "static" start keeps its shape at first. A "smooth" start is that of the
    # slow motion, which does not vibrate: each correction knows one more of its derivatives by time.
    scene, held = made.scene, machine_of(made.scene)
    smooth, count = scene.analysis.start in ("smooth", "periodic"), len(scene.freedoms)
    rates = [abs(scene.cycle_rate)] if scene.drives else []
    spacing = SLOWLY / max(1.0, *rates, *(abs(part.rate_at_start) for part in scene.freedoms.values()))
    t, start = (spacing * np.array([-1.0, 0.0, 1.0]), 1) if smooth else (BESIDE * spacing * np.array([0.0, 1.0]), 0)
    seconds, value = np.zeros((len(t), count)), np.zeros((len(t), count))
    for k, name in enumerate(scene.freedoms):
        lead(held, name, values_at(t, value[:, k]))
    first = second = np.zeros((1, held.machine.n))

    def bent(seconds: Array) -> tuple[PoseMotion, Array, Array]:
        """Give the chart, the coordinates beside it, and what holds the freedoms."""
        freedoms = _freedoms_at(scene, t, seconds, start)
        value[:] = freedoms[0]
        known = held.machine.with_rates(_rigid_at(held, t, freedoms).motion, first, second)
        held.machine.chart = Given(t, known)
        q, a = equilibria(held.machine, t, np.zeros((len(t), held.machine.size)), what="the start")
        rows = held.machine.n + len(held.machine.rows)
        return known, q, a[:, rows - count : rows]

    def freely(seconds: Array) -> tuple[PoseMotion, Array, Array]:
        """Give the chart, the coordinates beside it, and accelerations with which nothing holds the freedoms."""
        for _ in range(SLOW if count else 0):
            *_, pull = bent(seconds)
            by = np.stack([bent(seconds + one)[2] - pull for one in np.eye(count)], axis=-1)
            change = np.linalg.solve(by, pull[..., None])[..., 0]
            seconds = seconds - change
            if np.abs(change).max() <= FELT * np.abs(seconds).max():
                break
        return *bent(seconds)[:2], seconds

    known, q, seconds = freely(seconds)
    for _ in range(SLOW - 1 if smooth else 0):  # beside answers that are found, else derivatives would be of others
        coordinates = q[:, : held.machine.n]
        first = (coordinates[2:] - coordinates[:1]) / (2 * spacing)
        second = (coordinates[2:] - 2 * coordinates[1:2] + coordinates[:1]) / spacing**2
        known, q, seconds = freely(seconds)
    for _ in range(0 if smooth else SLOW):  # rates of shapes are viscous stress too
        change = _rates_of_shapes(held.machine, t, q[0])
        first = first + change
        known, q, seconds = freely(seconds)
        if np.abs(change).max() <= FELT * np.abs(first).max(initial=LEAST):
            break
    at_start = np.append(q[start, : held.machine.n], np.zeros(made.machine.size - held.machine.n))
    return known.part(slice(start, start + 1)), at_start


def _rates_of_shapes(machine: Machine, t: Array, q: Array) -> Array:
    """Give the rates with which links that keep their shape follow all rows: they strain least ``(n,)``."""
    # t: an instant and one just after it (s); q: coordinates at the first ``(size,)``
    n, rows, still = machine.n, slice(machine.n, machine.n + machine.held), np.zeros((2, machine.size))
    found = machine.residual(t, np.tile(q, (2, 1)), still, still)
    passing = np.diff(found.force[:, rows], axis=0)[0] / np.diff(t)  # rates of the rows where the coordinates rest
    number = machine.terms.index(machine.beams)
    here, variables = found.terms[number], machine.groups[number].variables(np.eye(n, machine.size))
    strains = np.einsum("emn,ken->emk", here.gradient[0], variables)
    stresses = np.einsum("eij,ejk->eik", machine.beams.stiffness, strains)
    stiffness, force = np.einsum("emk,eml->kl", strains, stresses), np.einsum("em,emk->k", here.rate[0], stresses)
    largest, by = np.abs(stiffness).max(), machine.pattern.dense(found.K)[0, rows, :n]
    whole = np.block([[stiffness / largest, by.T], [by, np.zeros((len(by), len(by)))]])
    right = -np.concatenate([force / largest, passing])
    return np.asarray(np.linalg.lstsq(whole, right, rcond=None)[0][:n])


def noted_peaks(peaks: dict[str, float], step: Step, scene: Scene) -> None:
    """Note the most that contacts exert in a step, which places and rates tell between its stages too."""
    # peaks: the most by law so far, which is added to (N or N m)
    shares = np.linspace(0, 1, PEAKS)
    for k, term in enumerate(step.machine.terms):
        if isinstance(term, LawTerm) and term.closed.any():
            found = step.measured(k, shares)
            alone = term.law.joint.name in scene.open_joints
            size = term.size(step.t + step.h * shares, found.x, found.rate, alone)
            peaks[term.name] = max(peaks.get(term.name, 0.0), float(np.abs(size).max()))


class _Taken:
    """Takes the positions of the result as steps come to them, and says whether cycles have settled."""

    def __init__(self, made: SceneMachine, times: Array, settled: float, struck: _Struck | None) -> None:
        self.made, self.times, self.settled, self.change = made, times, settled, math.inf
        self.struck = struck
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
        elif self.struck is not None and step.t in self.struck.due and step.t == self.positions[-1].t[0]:
            self.positions[-1] = step.at_start()  # after what strikes
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
        count, samples = len(self.positions) - 1 - _lead(scene, float(self.times[0])), scene.analysis.sub_intervals
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
            np.zeros(2) if self.struck is None else self.struck.given,
        )


def estimated(whole: InTime, start: GoneOn | None = None, chosen: bool = False) -> Errors:
    """Estimate the errors of a motion: by sharper steps, by halved elements, and between stations."""
    # Where the program chose the effects, what those change that lack data is an error too. Contacts let nearly the
    # same motions part. After one, halved elements tell nothing, and sharper steps where asked. What goes on from a
    # result has no state of halved elements either.
    scene, times, here = whole.scene, whole.positions.motion.t, whole.positions.quantities
    better, asked = {}, scene.analysis.error_estimates == "contacts"
    if not whole.closings or asked:
        better["time"] = InTime.of(scene, times, SHARPER, settled=0.0, start=start)
    if not whole.closings and start is None:
        better["mesh"] = InTime.of(with_halves(scene), times, settled=0.0)
        if chosen and (fuller := with_assumed_shear(scene)) is not None:
            better["effects"] = InTime.of(fuller, times, settled=0.0)
    parts = {name: other.positions.quantities.minus(here).largest for name, other in better.items()}
    if "time" in parts:
        parts["time"] = {name: UNSEEN * error for name, error in parts["time"].items()}
    errors = judged_errors(scene, here, parts)
    touched = (after_contacts(scene.analysis, "a tenth of"),) if whole.closings else ()
    return replace(errors, remarks=(*errors.remarks, *touched))


def collected(whole: InTime, errors: Errors | None, repeated: RepeatedMotion | None = None) -> Result:
    """Label what was found."""
    scene, found = whole.scene, whole.positions
    data = read_off(found).assign_attrs(cycle_change=whole.change, time_steps=whole.steps)
    known = [_power(whole, errors), _state_of(whole.ends), beside_motion(whole.beside, found.motion.t, repeated)]
    known.append(law_efforts(found, whole.inside, whole.peaks, whole.closings))
    if scene.freedoms:
        place, rate, _ = found.freed
        known += [of_freedoms(scene, place, rate), running(scene, found.motion.t, place, rate)]
    return labelled_in_time(scene, data, known, errors)


def labelled_in_time(scene: Scene, data: xr.Dataset, known: list[xr.Dataset], errors: Errors | None) -> Result:
    """Add to what is read off a motion in time what follows from it."""
    parts = [
        *known,
        residual_vibration(scene, data),
        mode_speeds(scene),
        *([] if errors is None else [of_errors(errors)]),
    ]
    data = joined(data, *parts)
    cycle = last_cycle(scene.analysis, scene.drives, data)
    data = joined(data, stress_figures(scene, data, cycle))
    if cycle is not None:
        data = joined(data, of_cycle(data, cycle, scene.period))
    return Result.with_scene(scene, with_units(scene, data))


def _power(whole: InTime, errors: Errors | None) -> xr.Dataset:
    """Give the mean power of every cause, by the stages of all steps, and what the machine stores."""
    powers, duration = whole.inside.powers(), float(np.ptp(whole.ends.t))
    mean = {cause: float(whole.weights @ power) / duration for cause, power in powers.items()}
    if whole.scene.impulses:
        by_impulses, by_drives = whole.struck / duration
        mean[Cause.IMPULSES] = by_impulses
        if whole.scene.drives:
            mean[next(iter(mean))] += by_drives
    weight, stored = energy_of_weight(whole.ends), kinetic_energy(whole.ends) + energy_of_terms(whole.ends)
    ends = OfPoses(whole.inside.made, whole.ends)
    for name, part in whole.scene.freedoms.items():  # efforts count without what accelerates their rotors
        stored = stored - part.inertia / 2 * ends.rate_of(f"freedoms.{name}") ** 2
    if any(whole.scene.gravity):
        drive = next(iter(mean))
        mean = {drive: mean[drive], Cause.WEIGHT: given_by(weight, duration)} | mean
    mean[Cause.STORED] = given_by(stored, duration)
    bound = np.nan
    if errors is not None and whole.scene.drives:
        bound = errors.of_power(whole.positions.drive_rates())
    exchanged = float(np.ptp(kinetic_energy(whole.inside.motion))) / duration
    return balance_of(mean, powers, bound, MEASURE.small_power, exchanged)
