"""Answers of the equation of poses to a scene: a cycle, exact or linear beside the rigid one, and positions at rest."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array, norms
from fenics_mech._guard import ADVICE
from fenics_mech.answers.buckled_links import refuse_folded, weakest_link, with_buckled
from fenics_mech.effects import EFFECTS, active
from fenics_mech.effects.known import COUPLING, EXACT_STRAINS, STIFFENING
from fenics_mech.errors import AssemblyError, DerivativeError, SolverError
from fenics_mech.estimate import finer_chart, finer_mesh, finer_steps, more_stages
from fenics_mech.geometry import Fourier, Given
from fenics_mech.kinematics import Motion as LinkMotion
from fenics_mech.kinematics import coordinates
from fenics_mech.machine import Machine
from fenics_mech.machine.free_motions import describe, nothing_holds
from fenics_mech.machine.from_scene import SceneMachine, machine_of
from fenics_mech.machine.laws_from_scene import SHAFT
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.machine.motion import LinearMotion, Motion
from fenics_mech.machine.motion import coordinates as of_poses
from fenics_mech.machine.rigid_from_scene import near_links, near_motion, poses_of_links, rigid_motion
from fenics_mech.planning.cycle_steps import Steps
from fenics_mech.recovery.of_linear import OfLinear
from fenics_mech.recovery.of_poses import OfPoses
from fenics_mech.scene import Scene
from fenics_mech.scene.meshing import with_halves
from fenics_mech.scene.sampling import SAMPLING
from fenics_mech.scene.springs_dampers import Line
from fenics_mech.solve import (
    Beside,
    Cycle,
    Iteration,
    Path,
    RunningModes,
    StaticIteration,
    axial_forces,
    cycle_change,
    damp_modes,
    periodic,
    quasi_static,
    rest_change,
    running_change,
    running_modes,
    stiffening_stresses,
)
from fenics_mech.solve.last_motions import LastMotions
from fenics_mech.solve.linear import stiffness_along
from fenics_mech.solve.newton import converge, newton
from fenics_mech.solve.rigid import FEWEST, enough
from fenics_mech.solve.rigid import MOST as MOST_POSITIONS
from fenics_mech.solve.stability_limits import STABILITY
from fenics_mech.solve.statics import stiffness

logger = logging.getLogger(__name__)
FREE = ("shear", "rotary-inertia")  # what the equation has at no cost, where the scene lets the program choose
Stresses = list[Array]  # of every term
SHORTEST = 1e-9  # length of a spring or damper, of the largest that is known: below it, it has no direction
LOWERED = 0.95  # share of axial forces that buckle, whose powers do not
MOST_DOWN, FARTHEST_DOWN = 60, 0.3  # steps from an unstable answer, and the longest change in each (rad, m)
UNHELD = 1e-10  # stiffness of a free motion, of that of the links which it moves: below it, it is rounding
LARGEST_LOSS = 5e-3  # of an answer by rounding; the estimate is 1/7 to 20 times the true loss
BLAMED = 1e6  # times the softest stiffness of an element: a damper that resists as much is as good as rigid
FARTHEST = 1.0  # rad, or of an element's length: a cantilever's end at 1 rad in linear theory turns by 0.78
SIGNS = 1.0, -1.0  # of what is ahead of an answer and of what is behind it


def with_effects(scene: Scene) -> Scene:
    """Choose the effects of a scene for the equation of poses, or refuse those that it has not."""
    if scene.effects == "auto":
        lacking = {name for name in FREE if EFFECTS[name].missing_data(scene)}
        scene = scene.changed(effects=(COUPLING, EXACT_STRAINS, *(name for name in FREE if name not in lacking)))
    elif EXACT_STRAINS in scene.named_effects and COUPLING not in scene.named_effects:  # which exact strains come with
        scene = scene.changed(effects=(*scene.named_effects, COUPLING))
    active(scene)  # which says what is wrong with its effects
    return scene


def built(scene: Scene, coarse: Machine | None = None, near: Machine | None = None) -> SceneMachine:
    """Build a machine that is damped, with the motion of its rigid links as chart."""
    # It is that of a machine with a coarser mesh, or found beside that of one which differs a little, if they are
    # given.
    made = machine_of(scene)
    if coarse is not None and isinstance(coarse.chart, Fourier):
        made.machine.chart = finer_chart(coarse.chart, coarse, made.machine)
    elif scene.drives and scene.analysis.method == "static":
        made.machine.chart = _rigid_at(made, instants_of(scene))
    elif scene.drives:
        known = None if near is None else near.chart
        made.machine.chart = _rigid_cycle(made, len(known.r) if isinstance(known, Fourier) else None)
    _refuse_meeting(made)
    if np.any(scene.damping.ratio):
        damp_modes(made.machine, scene.period, scene.damping.ratio)
    return made


def _rigid_at(made: SceneMachine, t: Array) -> Given:
    """Give the motion of all poses at some instants, where links do not bend."""
    scene, size = made.scene, made.bodies.machine.size
    motion = solve_motion(scene, scene.cycle_rate * t)
    near = near_motion(made, coordinates(motion.position, motion.angle))
    return rigid_motion(made, t, np.pad(near, ((0, 0), (0, size - near.shape[1]))), (np.zeros((len(t), 0)),) * 3)


def _rigid_cycle(made: SceneMachine, count: int | None = None) -> Fourier:
    """Give the periodic motion of all poses where links do not bend."""
    # Its positions are as many as its laws and harmonics ask for, unless their number is given.
    scene, least = made.scene, FEWEST
    for drive in scene.drives:
        if drive.law is not None:
            least = max(least, min(drive.enough_angles(FEWEST, scene.cycle_rate), MOST_POSITIONS))
    positions = FEWEST if count is None else count
    while True:
        motion = _rigid_at(made, scene.period / positions * np.arange(positions)).motion
        chart = Fourier(made.machine.geometry, scene.period, motion.r, motion.R)
        if count is not None or enough(chart, made.machine, least):
            return chart
        positions *= 2


def _refuse_meeting(made: SceneMachine) -> None:
    """Raise `AssemblyError` where the ends of a spring or damper meet at a position: it has no direction there."""
    scene, lines = made.scene, {}
    for kind in ("springs", "dampers"):
        for name, part in getattr(scene, kind).items():
            if isinstance(part, Line) and getattr(part, "length", None) != 0.0:  # else it pulls as it is long
                lines[f"{kind}.{name}"] = part.between
    if not lines:
        return
    t = instants_of(scene)
    at = made.machine.known.at(t)
    for name, points in lines.items():
        one, other = (at.r[:, end.pose] + at.R[:, end.pose] @ end.offset for end in map(made.end, points))
        length = np.linalg.norm(other - one, axis=1)
        k = int(length.argmin())
        if length[k] <= SHORTEST * max(length.max(), made.machine.extent):
            raise AssemblyError(
                f"the ends of {name} meet at drive angle {np.degrees(scene.cycle_rate * t[k]):.6g} deg, where it has "
                "no direction: put them elsewhere"
            )


def stiffening(scene: Scene, machine: Machine, t: Array, free: Array | None = None) -> Stresses | None:
    """Give the axial forces of the static answer at some instants, where they act in the scene's linear theory."""
    if STIFFENING not in scene.named_effects:
        return None
    return axial_forces(machine, quasi_static(machine, t, scene.analysis.method != "static", free))


Run = LastMotions[Path]  # motions before that of a scene, from which it is sought


def found_beside(scene: Scene, machine: Machine, run: Run | None) -> Cycle | None:
    """Find the motion of a scene's machine from the last ones of a run; None where that leads to none."""
    like = Path.of_rest(machine, scene.period, Steps.of(scene).times, scene.analysis.stages)
    near = None if run is None else run.near(lambda path: isinstance(path, Path) and like.alike(path))
    if near is None:
        return None
    try:
        return periodic(machine, scene.period, start=near.paced(scene.period))
    except SolverError as error:
        logger.info("no motion is found from the last one: %s", error)
        return None


def left_out_by_linear(changes: Sequence[float]) -> float | None:
    """Give the share of the coordinates that linear strains leave out, by Newton's steps from the rigid motion."""
    # The first step gives the linear answer. Where it changes nothing there is no second one, and None is given.
    return changes[1] / changes[0] if len(changes) > 1 else None


@dataclass(frozen=True)
class Solved:
    """A periodic motion of a scene's machine."""

    scene: Scene
    made: SceneMachine
    cycle: Cycle
    # small ones of it; None for those that its steps tell
    disturbances: RunningModes | None = field(default=None, kw_only=True)
    # share of the coordinates that linear strains leave out; None where it is not known
    left_out: float | None = field(default=None, kw_only=True)
    untold = ()  # variables that it has not

    @classmethod
    def of(cls, scene: Scene, run: Run | None = None) -> Solved:
        """Build the machine of a scene, and find its periodic motion."""
        made = built(scene)
        if (beside := found_beside(scene, made.machine, run)) is not None:
            refuse_folded(made, beside.evaluation, beside.t.ravel())
            _refuse_lost_cycle(made, beside)
            return cls(scene, made, beside)
        try:
            cycle = periodic(made.machine, scene.period, Steps.of(scene).times, stages=scene.analysis.stages)
        except SolverError as error:
            if stiff := _as_good_as_rigid(made):
                raise SolverError(f"{error}. {stiff}") from error
            raise with_buckled(made, instants_of(scene), True, error) from error
        refuse_folded(made, cycle.evaluation, cycle.t.ravel())
        _refuse_lost_cycle(made, cycle)
        return cls(scene, made, cycle, left_out=left_out_by_linear(cycle.changes))

    @property
    def lost(self) -> float:
        """Share that rounding may take."""
        return self.cycle.lost

    def _read(self, t: Array, q: Array, v: Array, a: Array) -> OfPoses:
        motion = Motion(self.made.machine, t, q, v, a)
        if SHAFT in self.made.acting:  # deflections are measured from where the crank is, and not its drive
            crank = motion.jet(self.made.acting[SHAFT])
            near, none = near_links(self.made, motion.poses), (np.zeros((len(t), 0)),) * 3
            drives = crank[0][:, None], crank[1][:, None], crank[2][:, None]
            motion = motion.beside(rigid_motion(self.made, t, near, none, drives))
        return OfPoses(replace(self.made, machine=motion.machine), motion)

    def _at(self, share: float) -> tuple[Array, Array, Array, Array]:
        """Give instants, coordinates, rates and accelerations at a share of every sub-interval."""
        t = instants_of(self.scene, share)
        return t, *self.cycle.path.when(t)

    def at(self, share: float) -> OfPoses:
        """Give the motion at a share of every sub-interval."""
        return self._read(*self._at(share))

    @property
    def at_stages(self) -> OfPoses:
        """Give the motion at the stages of all steps, over which a mean is of the order of the steps."""
        q, v, a = (x.reshape(self.cycle.t.size, -1) for x in (self.cycle.q, self.cycle.v, self.cycle.a))
        return self._read(self.cycle.t.ravel(), q, v, a)

    @property
    def weighed(self) -> tuple[OfPoses, Array]:
        """Instants by which means over the cycle are taken, and their shares of it."""
        path = self.cycle.path
        return self.at_stages, np.outer(path.h / path.period, path.tableau.A[-1]).ravel()

    @cached_property
    def positions(self) -> OfPoses:
        """The motion at the positions of the result."""
        return self.at(0.0)

    def _with(self, scene: Scene) -> tuple[SceneMachine, Beside]:
        """Build the machine of a scene that differs a little."""
        made = _alike(self.made, built(scene, near=self.made.machine))
        path, pace = self.cycle.path, scene.cycle_rate / self.scene.cycle_rate
        starts = Steps.of(scene).times * pace
        if len(starts) != len(path.starts) or np.abs(starts - path.starts).max() > SAMPLING.same * path.period:
            raise DerivativeError("a variable moves an instant at which a load jumps or an impulse acts")
        return made, Beside(made.machine, pace)

    def beside(self, *scenes: Scene) -> list[Solved]:
        """Give the motions of two scenes that lie as far to both sides of this one, to first order."""
        made, sides = zip(*map(self._with, scenes))
        change, found = cycle_change(self.cycle, *sides), []
        for scene, machine, other, sign in zip(scenes, made, sides, SIGNS):
            path = other.path(self.cycle.path.moved(change, sign))
            cycle = Cycle(other.machine, path, [], other.linear)
            found.append(replace(self, scene=scene, made=machine, cycle=cycle))
        if not self.scene.analysis.stability:
            return found
        log = running_change(self.cycle, self.running, *((other, one.cycle) for other, one in zip(sides, found)))
        before = self.scene.period
        return [
            replace(one, disturbances=self.running.changed(sign * log, before, one.scene.period))
            for one, sign in zip(found, SIGNS)
        ]

    @cached_property
    def running(self) -> RunningModes:
        """Small disturbances of the motion, the slowest to decay first."""
        return running_modes(self.cycle, 2 * STABILITY.kept) if self.disturbances is None else self.disturbances

    def better(self) -> Iterator[tuple[str, OfPoses]]:
        """Give the same at the positions without most of the error of a source, which is named."""
        yield "time", replace(self, cycle=finer_steps(self.cycle)).at(0.0)
        yield "mesh", Solved(self.scene, self.finer, finer_mesh(self.cycle, self.finer.machine)).at(0.0)

    @cached_property
    def finer(self) -> SceneMachine:
        """The machine with halved elements."""
        return built(with_halves(self.scene), self.made.machine)


@dataclass(frozen=True)
class LinearCycle(Solved):
    """A periodic motion that is linear beside the rigid one: the first step of Newton's method."""

    # Its cycle holds the tangents of that step.

    stresses: Stresses  # those of every term at all stages after the step

    @classmethod
    def of(cls, scene: Scene, run: Run | None = None) -> LinearCycle:
        """Build the machine of a scene, and find its periodic motion in the linear theory of its effects."""
        # It is the only one, so that motions before it tell nothing of it.
        made = built(scene)
        try:
            found = cls._by(scene, made, scene.analysis.stages)
            _refuse_lost_cycle(made, found.cycle)
        except np.linalg.LinAlgError as error:
            if stiff := _as_good_as_rigid(made):
                raise SolverError(f"a matrix of the cycle cannot be solved with ({error}). {stiff}") from error
            raise
        return found

    @classmethod
    def _by(cls, scene: Scene, made: SceneMachine, stages: int) -> LinearCycle:
        path = Path.of_rest(made.machine, scene.period, Steps.of(scene).times, stages)
        stiff = stiffening(scene, made.machine, path.at(path.tableau.c)[0].ravel())
        step = Iteration(made.machine, path, stiff, turning=stiff is not None)
        change = step.step()
        return cls(scene, made, Cycle(made.machine, step.path, [change], step.found), list(step.predicted))

    def _with(self, scene: Scene) -> tuple[SceneMachine, Beside]:
        made, other = super()._with(scene)
        path, machine = other.path(self.cycle.path), other.machine
        t = path.at(path.tableau.c)[0].ravel()
        zero = np.zeros((len(t), machine.size))
        stiff = stiffening(scene, machine, t)
        found = machine.residual(t, zero, zero, zero, predicted=stiff, turning=stiff is not None)
        return made, replace(other, linear=found)

    def _read(self, t: Array, q: Array, v: Array, a: Array) -> OfPoses:
        rigid = Motion(self.made.machine, t, 0 * q, 0 * v, 0 * a)
        return OfLinear.by(self.made, LinearMotion(rigid, (q, v, a), stiffening(self.scene, self.made.machine, t)))

    @cached_property
    def _next(self) -> Iteration:
        """Newton's method after one more step, whose change is what the linear theory leaves out."""
        iteration = Iteration(self.made.machine, self.cycle.path, self.stresses)
        iteration.step()
        return iteration

    @cached_property
    def corrected(self) -> OfPoses:
        """The motion at the positions after one more step."""
        path, here = self.cycle.path, Motion(self.made.machine, *self._at(0.0))
        off = path.starts + path.h - here.t[:, None]
        ending = np.abs(off - path.period * np.round(off / path.period)).argmin(axis=1)  # the step before each position
        last = len(path.tableau.c) * (ending + 1) - 1
        dq, dv, da, *stiff = (x[last] for x in (*self._next.change, *self.stresses))
        return OfLinear.by(self.made, LinearMotion(here, (dq, dv, da), stiff))

    def better(self) -> Iterator[tuple[str, OfPoses]]:
        """Give the same at the positions without most of the error of a source, which is named."""
        yield "time", LinearCycle._by(self.scene, self.made, more_stages(len(self.cycle.tableau.c))).positions
        yield "mesh", LinearCycle._by(self.scene, self.finer, len(self.cycle.tableau.c)).positions
        yield "theory", self.corrected


TIGHT, MOST = 1e-11, 40  # Newton's change of coordinates (m, rad), and its steps, as of `equilibrium`


@dataclass(frozen=True)
class AtRest:
    """Static answers of a scene's machine at its positions, without rates beside the rigid motion."""

    scene: Scene
    made: SceneMachine  # its machine, without damping of its links: they do not vibrate
    positions: OfPoses
    following: StaticIteration | None  # Newton's method after the first step; None of an exact answer
    left_out: float | None = None  # as of `Solved`
    lost: float = 0.0  # share that rounding may take

    @classmethod
    def of(cls, scene: Scene) -> AtRest:
        """Build the machine of a scene, and find its static answers."""
        return cls._by(scene, _undamped(scene), instants_of(scene))

    @classmethod
    def _by(cls, scene: Scene, made: SceneMachine, t: Array) -> AtRest:
        machine, moving, exact = made.machine, scene.analysis.method != "static", EXACT_STRAINS in scene.named_effects
        free = free_motions_of(made)
        stiff = stiffening(scene, machine, t, free)
        steps = StaticIteration(machine, t, moving, stiff, free)
        still = np.zeros_like(steps.q)
        if exact:
            try:
                changes = converge(steps, TIGHT, MOST, "the static answer")
            except SolverError as error:
                _refuse_accelerated(made, steps)
                raise with_buckled(made, steps.t, steps.moving, error) from error
            _refuse_accelerated(made, steps)
            if steps.yielding.any() and (bent := _beyond_buckling(machine, t, moving, free)) is not None:
                steps, changes = bent, []
            _refuse_buckled(made, steps)
            refuse_folded(made, steps.found, t)
            _refuse_lost(made, steps)
            motion = Motion(machine, t, steps.q, still, steps.a, moving)
            return cls(scene, made, OfPoses(made, motion), None, left_out_by_linear(changes), lost=steps.lost)
        steps.step()
        _refuse_accelerated(made, steps)
        _refuse_buckled(made, steps)
        _refuse_lost(made, steps)
        if not scene.analysis.allow_large:
            _refuse_far(made, steps)
        rigid = Motion(machine, t, still, still, still, moving)
        stresses = steps.stresses if stiff is None else None
        linear = OfLinear.by(made, LinearMotion(rigid, steps.change, stiff, False, stresses))
        return cls(scene, made, linear, steps, lost=steps.lost)

    def _with(self, scene: Scene) -> tuple[SceneMachine, Beside, Stresses | None]:
        """Build the machine of a scene that differs a little, with the axial forces that act in its linear theory."""
        made = _alike(self.made, _undamped(scene, near=self.made.machine))
        machine, moving, t = made.machine, self.positions.motion.moving, instants_of(scene)
        pace = scene.cycle_rate / self.scene.cycle_rate if scene.drives else 1.0
        if self.following is None:
            return made, Beside(machine, pace), None
        zero, stiff = np.zeros((len(t), machine.size)), stiffening(scene, machine, t)
        found = machine.residual(t, zero, zero, zero, moving=moving, tangents=False)
        stresses = stiffening_stresses(machine, found) if stiff is None else stiff
        held = machine.residual(t, zero, zero, zero, predicted=stresses, moving=False, turning=stiff is not None)
        return made, Beside(machine, pace, replace(held, force=found.force)), stiff

    def beside(self, *scenes: Scene) -> list[AtRest]:
        """Give the answers of two scenes that lie as far to both sides of this one, to first order."""
        motion, sides = self.positions.motion, [self._with(scene) for scene in scenes]
        t, q, a, moving = motion.t, motion.q, motion.a, motion.moving
        if self.following is None:
            values = stiffness(motion.machine, motion.with_tangents)
        else:
            (q, _, a), values = self.following.change, self.following.values
        dq, da = rest_change(motion.machine, t, q, a, sides[0][1], sides[1][1], values, moving)
        found = []
        for scene, (made, other, stiff), sign in zip(scenes, sides, SIGNS):
            at, still = instants_of(scene), np.zeros_like(q)
            change = q + sign * dq, still, a + sign * da
            if self.following is None:
                positions = OfPoses(made, Motion(other.machine, at, *change, moving))
            else:
                rigid = Motion(other.machine, at, still, still, still, moving)
                positions = OfLinear.by(made, LinearMotion(rigid, change, stiff, False))
            found.append(replace(self, scene=scene, made=made, positions=positions))
        return found

    @property
    def untold(self) -> tuple[str, ...]:
        """Variables that it has not: rates of bent links, and where the links rest, of all."""
        rates = ("velocity", "acceleration")
        bent = tuple(f"point_{rate}_bent" for rate in rates)
        return bent if self.positions.motion.moving else (*bent, *(f"point_{rate}" for rate in rates))

    def at(self, share: float) -> OfPoses:
        """Give the answers at a share of the way from each position to the next."""
        return AtRest._by(self.scene, self.made, instants_of(self.scene, share)).positions

    @property
    def weighed(self) -> tuple[OfPoses, Array]:
        """Instants by which means over the cycle are taken, and their shares of it."""
        count = len(self.positions.motion.t)
        return self.positions, np.full(count, 1 / count)

    def better(self) -> Iterator[tuple[str, OfPoses | None]]:
        """Give the same without most of the error of a source, which is named; None where there is no such answer."""
        finer = _undamped(with_halves(self.scene), self.made.machine)
        yield "mesh", AtRest._by(self.scene, finer, instants_of(self.scene)).positions
        if self.following is not None:
            yield "theory", self.exact

    @cached_property
    def exact(self) -> OfPoses | None:
        """The answers with exact strains, to which Newton's method goes on; None where there are none near by."""
        assert self.following is not None
        steps = copy(self.following)
        try:
            newton(steps.step, TIGHT, MOST, "the static answer")
            _refuse_buckled(self.made, steps)
        except SolverError as error:
            logger.info("with exact strains there is no answer: %s", error)
            return None
        motion = Motion(steps.machine, steps.t, steps.q, np.zeros_like(steps.q), steps.a, steps.moving)
        return OfPoses(self.made, motion)


def _undamped(scene: Scene, coarse: Machine | None = None, near: Machine | None = None) -> SceneMachine:
    """Build a machine whose links are not damped."""
    return built(scene.changed({"damping.material": 0.0, "damping.ratio": 0.0}), coarse, near)


def _alike(known: SceneMachine, made: SceneMachine) -> SceneMachine:
    """Give a machine, unless it has other coordinates or rows than a known one."""
    one, other = known.machine, made.machine
    if not (np.array_equal(one.places, other.places) and one.held == other.held):
        raise DerivativeError("the coordinates change with a variable")
    return made


def _refuse_buckled(made: SceneMachine, steps: StaticIteration) -> None:
    """Raise `SolverError` where the stiffness about a static answer is not positive."""
    yielding, rate = steps.yielding, made.scene.cycle_rate
    if yielding.any():
        worst = int(np.argmax(yielding))
        raise SolverError(
            f"the mechanism buckles at drive angle {np.degrees(rate * steps.t[worst]):.6g} deg: under its axial forces "
            f"its stiffness is not positive in {yielding[worst]} independent ways, and link "
            f"{weakest_link(made, steps, worst)} gives way. Lower the load or the speed, or take stiffer members"
        )


def _beyond_buckling(machine: Machine, t: Array, moving: bool, free: Array | None) -> StaticIteration | None:
    """Give the answer to which members buckle, where a load across them tells the side; None where none is found."""
    # It goes down in energy from the straight members: each step has as much of the axial forces as does not buckle.
    axial = axial_forces(machine, quasi_static(machine, t, moving, free))
    steps = StaticIteration(machine, t, moving, axial, free)
    for _ in range(MOST_DOWN):
        for power in (0, *2 ** np.arange(12)):
            bent = copy(steps)
            bent.stresses = [LOWERED**power * stress for stress in axial]
            size = bent.step()
            if not bent.yielding.any():
                break
        else:
            return None
        if power == 0 and size < TIGHT:
            return bent
        bent.shorten(FARTHEST_DOWN)
        steps = bent
        found = machine.residual(t, steps.q, 0 * steps.q, steps.a, moving=moving, tangents=False)
        axial = [here.response.stress for here in found.terms]
    return None


def moves_of(made: SceneMachine) -> tuple[LinkMotion, Array] | None:
    """Give motions that joints let pass to rigid links, and their coordinates ``(size, motions)``; None without any."""
    if made.scene.drives:
        return None
    motion = solve_motion(made.scene, np.zeros(1))
    near, whole = near_motion(made, coordinates(motion.position, motion.angle)), []
    for free in motion.free:
        poses = poses_of_links(made, near, free.reshape(1, -1), 0 * near)
        whole.append(of_poses(made.machine, poses.v, poses.w)[0])
    return (motion, np.array(whole).T) if whole else None


def free_motions_of(made: SceneMachine) -> Array | None:
    """Give coordinates of the motions in which nothing is strained ``(size, motions)``; None where all is held."""
    if (moves := moves_of(made)) is None:
        return None
    machine, none = made.machine, np.zeros((1, made.machine.size))
    straight = [0 * here.response.stress for here in machine.residual(np.zeros(1), none, none, none).terms]
    found = machine.residual(np.zeros(1), none, none, none, predicted=straight, moving=False, turning=False)
    values, free = stiffness_along(machine.pattern.dense(stiffness(machine, found)[0]), moves[1])
    loose = values < UNHELD
    return free[:, loose] if loose.any() else None


def _refuse_accelerated(made: SceneMachine, steps: StaticIteration) -> None:
    """Raise `SceneError` where a scene asks for its rest, and its loads move what nothing holds."""
    scene, force = made.scene, steps.found.force[:, : made.machine.n]
    if scene.analysis.method == "static" and steps.unheld > UNHELD * np.abs(force).max(initial=0.0):
        motion = solve_motion(scene, np.zeros(1))
        links = coordinates(motion.position, motion.angle)
        raise nothing_holds(describe(scene, links[0], motion.free))


def _refuse_lost(made: SceneMachine, steps: StaticIteration) -> None:
    """Raise `SolverError` where rounding takes too much of an answer."""
    if steps.lost <= LARGEST_LOSS:
        return
    assert made.links is not None
    k, machine = steps.lost_at, made.machine
    moved = np.pad(steps.q[k], (0, 1))[machine.places[made.node_pose, :2]]
    point = made.links.mesh.node_name[int(np.hypot(*moved.T).argmax())]
    raise SolverError(
        f"the static answer is lost to rounding at drive angle {np.degrees(made.scene.cycle_rate * steps.t[k]):.10g} "
        f"deg: {steps.lost:.1e} of it, by estimate, largest at {point}. Keep away from dead centres, where the links "
        "do not hold that point. Or take members less stiff along than across, or fewer elements"
    )


def _refuse_lost_cycle(made: SceneMachine, cycle: Cycle) -> None:
    """Raise `SolverError` where rounding takes too much of a periodic motion."""
    if not cycle.lost <= LARGEST_LOSS:
        raise SolverError(
            f"the periodic motion is lost to rounding: {cycle.lost:.1e} of it, by estimate. "
            f"{_as_good_as_rigid(made) or ADVICE}"
        )


def _as_good_as_rigid(made: SceneMachine) -> str:
    """Tell of a damper that holds links as if it were rigid; nothing where there is none."""
    machine, rate = made.machine, abs(made.scene.cycle_rate)
    held = BLAMED * np.diagonal(machine.beams.stiffness, axis1=1, axis2=2).min()
    for name, damper in made.scene.dampers.items():
        arm, unit = (machine.extent, "N s/m") if isinstance(damper, Line) else (1.0, "N m s/rad")
        if damper.damping * arm**2 * rate > held:
            return (
                f"The damper {name!r} of {damper.damping:.3g} {unit} is as good as rigid, and behind it the links "
                "hardly settle in a cycle. Take a smaller one, or a weld or a rigid link in its place"
            )
    return ""


def _refuse_far(made: SceneMachine, steps: StaticIteration) -> None:
    """Raise `SolverError` where sections turn by more, or places move by more, than small deflections do."""
    assert made.links is not None
    machine, mesh = made.machine, made.links.mesh
    node = np.pad(steps.change[0], ((0, 0), (0, 1)))[:, machine.places[made.node_pose]]
    nodes = mesh.cell_nodes
    turned, moved = np.abs(node[:, nodes, 2]).max(axis=2), norms(node[:, nodes[:, 1], :2] - node[:, nodes[:, 0], :2])
    largest = np.maximum(turned, moved / mesh.cell_length)
    k, e = np.unravel_index(int(largest.argmax()), largest.shape)
    if largest[k, e] > FARTHEST:
        raise SolverError(
            f"elastic deflection turns member {mesh.members[mesh.cell_member[e]]!r} by {largest[k, e]:.3g} rad or "
            f"moves it as far at drive angle {np.degrees(made.scene.cycle_rate * steps.t[k]):.6g} deg. The theory of "
            f"small deflections does not hold near {FARTHEST:g}. Lower loads or speed, keep away from buckling and "
            f"dead centres, or take stiffer members; {EXACT_STRAINS!r} holds it, and analysis.allow_large lets it pass"
        )


def instants_of(scene: Scene, share: float = 0.0) -> Array:
    """Give the instants at which the positions of a result are, or at a share of the way to the next (s)."""
    if not scene.drives:  # a structure: it has one position
        return np.zeros(1)
    if scene.analysis.method == "static":
        return np.array([scene.analysis.position / scene.cycle_rate])
    return scene.period / scene.analysis.sub_intervals * (np.arange(scene.analysis.sub_intervals) + share)
