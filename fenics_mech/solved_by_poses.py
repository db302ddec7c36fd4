"""Answers of the equation of poses to a scene: a cycle, exact or linear beside the rigid one, and positions at rest."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.errors import SolverError
from fenics_mech.estimate import finer_chart, finer_mesh, finer_steps
from fenics_mech.geometry import Fourier
from fenics_mech.machine import Machine
from fenics_mech.machine.from_scene import SceneMachine, machine_of
from fenics_mech.machine.laws_from_scene import SHAFT
from fenics_mech.machine.motion import LinearMotion, Motion
from fenics_mech.machine.rigid_from_scene import near_links, rigid_motion
from fenics_mech.recovery.of_linear import OfLinear
from fenics_mech.recovery.of_poses import OfPoses
from fenics_mech.scene import Drive, Scene
from fenics_mech.scene.meshing import with_halves
from fenics_mech.scene.sampling import SAMPLING
from fenics_mech.solve import (
    Cycle,
    Iteration,
    Path,
    StaticIteration,
    axial_forces,
    converged,
    damp_modes,
    periodic,
    quasi_static,
    rigid_cycle,
)
from fenics_mech.solve.last_motions import LastMotions
from fenics_mech.solve.newton import newton

logger = logging.getLogger(__name__)
EXACT, STIFFENED = "large-rotations", "geometric-stiffness"  # effects: Newton's method goes on; axial forces act
Stresses = list[Array]  # of every term


def built(scene: Scene, coarse: Machine | None = None, near: Machine | None = None) -> SceneMachine:
    """Build a machine that is damped, with the motion of its rigid links as chart.

    It is that of a coarse machine, or beside that of a near one, if one of them is given.
    """
    made = machine_of(scene)
    if coarse is not None and isinstance(coarse.chart, Fourier):
        made.machine.chart = finer_chart(coarse.chart, coarse, made.machine)
    elif scene.drives:
        led = made if SHAFT not in made.acting else machine_of(scene.changed(drive=_without_motor(scene.drives[0])))
        known = None if near is None or not isinstance(near.chart, Fourier) else near.chart
        made.machine.chart = rigid_cycle(led.machine, scene.period, near=known)
    if np.any(scene.damping.ratio):
        damp_modes(made.machine, scene.period, scene.damping.ratio)
    return made


def _without_motor(drive: Drive) -> Drive:
    return drive.model_copy(update={"motor": None})


def stiffening(scene: Scene, machine: Machine, t: Array) -> Stresses | None:
    """Give the axial forces of the static answer at some instants, where they act in the scene's linear theory."""
    return axial_forces(machine, quasi_static(machine, t)) if STIFFENED in scene.named_effects else None


def steps_of(scene: Scene) -> Array:
    """Give the instants at which steps of a cycle begin (s): evenly, and where loads jump and impulses act.

    A jump counts to the step after it, which begins by a rounding before it.
    """
    count, rate = scene.analysis.sub_intervals, scene.cycle_rate
    even = np.arange(count) / count * TURN
    jumps = [angle for load in scene.loads.values() for angle in load.jumps]
    jumps += [impulse.angle for impulse in scene.impulses.values() if impulse.angle is not None]
    turned = np.mod(np.sign(rate) * np.array(jumps, dtype=float), TURN)
    near = np.abs(np.mod(even[:, None] - turned + np.pi, TURN) - np.pi).min(axis=1, initial=TURN) < SAMPLING.same
    cut = np.concatenate([even[~near], np.unique(turned) - 2 * SAMPLING.same])
    return np.sort(cut) / abs(rate)


Run = LastMotions[Path]  # motions before that of a scene, from which it is sought


def found_beside(scene: Scene, machine: Machine, run: Run | None) -> Cycle | None:
    """Find the motion of a scene's machine from the last ones of a run; None where that leads to none."""
    like = Path.of_rest(machine, scene.period, steps_of(scene), scene.analysis.stages)
    near = None if run is None else run.near(lambda path: isinstance(path, Path) and like.alike(path))
    if near is None:
        return None
    try:
        return periodic(machine, scene.period, start=near.paced(scene.period))
    except SolverError as error:
        logger.info("no motion is found from the last one: %s", error)
        return None


@dataclass(frozen=True)
class Solved:
    """A periodic motion of a scene's machine.

    Parameters
    ----------
    scene
        The scene.
    made
        Its machine.
    cycle
        The motion.
    """

    scene: Scene
    made: SceneMachine
    cycle: Cycle
    untold = ()  # variables that it has not

    @classmethod
    def of(cls, scene: Scene, run: Run | None = None) -> Solved:
        """Build the machine of a scene, and find its periodic motion.

        Parameters
        ----------
        scene
            The scene.
        run
            Motions before it; None to begin from the rigid motion.

        Raises
        ------
        SolverError
            When there is none near the rigid motion.
        """
        made = built(scene)
        cycle = found_beside(scene, made.machine, run)
        cycle = cycle or periodic(made.machine, scene.period, steps_of(scene), stages=scene.analysis.stages)
        return cls(scene, made, cycle)

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
    """A periodic motion that is linear beside the rigid one: the first step of Newton's method.

    Its cycle holds the tangents of that step.

    Parameters
    ----------
    stresses
        Those of every term at all stages after the step.
    """

    stresses: Stresses

    @classmethod
    def of(cls, scene: Scene, run: Run | None = None) -> LinearCycle:
        """Build the machine of a scene, and find its periodic motion in the linear theory of its effects.

        It is the only one, so that motions before it tell nothing of it.

        Raises
        ------
        SolverError
            When it is at an undamped resonance.
        """
        return cls._by(scene, built(scene), scene.analysis.stages)

    @classmethod
    def _by(cls, scene: Scene, made: SceneMachine, stages: int) -> LinearCycle:
        path = Path.of_rest(made.machine, scene.period, steps_of(scene), stages)
        stiff = stiffening(scene, made.machine, path.at(path.tableau.c)[0].ravel())
        step = Iteration(made.machine, path, stiff)
        step.step()
        assert step.stresses is not None
        return cls(scene, made, Cycle(made.machine, step.path, step.found, 1, step.size), list(step.stresses))

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

    def exact(self, scene: Scene, run: Run | None = None) -> Solved:
        """Go on to the motion that leaves nothing out, from the last ones of a run or from here.

        Parameters
        ----------
        scene
            The same scene with exact strains.
        run
            Motions before it.

        Raises
        ------
        SolverError
            When there is none near.
        """
        cycle = found_beside(scene, self.made.machine, run) or converged(copy(self._next))
        return Solved(scene, replace(self.made, scene=scene), cycle)

    def better(self) -> Iterator[tuple[str, OfPoses]]:
        """Give the same at the positions without most of the error of a source, which is named."""
        yield "time", LinearCycle._by(self.scene, self.made, len(self.cycle.tableau.c) + 1).positions
        yield "mesh", LinearCycle._by(self.scene, self.finer, len(self.cycle.tableau.c)).positions
        yield "theory", self.corrected


TIGHT, MOST = 1e-11, 40  # Newton's change of coordinates (m, rad), and its steps, as of `equilibrium`


@dataclass(frozen=True)
class AtRest:
    """Static answers of a scene's machine at its positions, without rates beside the rigid motion.

    Parameters
    ----------
    scene
        The scene.
    made
        Its machine, without damping of its links: they do not vibrate.
    positions
        What is read off it.
    following
        Newton's method after the first step; None of an exact answer.
    """

    scene: Scene
    made: SceneMachine
    positions: OfPoses
    following: StaticIteration | None

    @classmethod
    def of(cls, scene: Scene) -> AtRest:
        """Build the machine of a scene, and find its static answers.

        Raises
        ------
        SolverError
            When there is none near the rigid motion at a position.
        """
        return cls._by(scene, _undamped(scene), instants_of(scene))

    @classmethod
    def _by(cls, scene: Scene, made: SceneMachine, t: Array) -> AtRest:
        machine, moving, exact = made.machine, scene.analysis.method != "static", EXACT in scene.named_effects
        stiff = None
        if STIFFENED in scene.named_effects:
            first = StaticIteration(machine, t, moving)
            first.step()
            stiff = axial_forces(machine, first.iterate)
        steps = StaticIteration(machine, t, moving, stiff)
        still = np.zeros_like(steps.q)
        if exact:
            newton(steps.step, TIGHT, MOST, "the static answer")
            _refuse_buckled(scene, steps)
            return cls(scene, made, OfPoses(made, Motion(machine, t, steps.q, still, steps.a, moving)), None)
        steps.step()
        _refuse_buckled(scene, steps)
        rigid = Motion(machine, t, still, still, still, moving)
        return cls(scene, made, OfLinear.by(made, LinearMotion(rigid, steps.change, stiff, False)), steps)

    def exact(self, scene: Scene, run: Run | None = None) -> AtRest:
        """Give the answers that leave nothing out.

        Parameters
        ----------
        scene
            The same scene with exact strains.
        run
            Motions before it, of which positions at rest make no use.

        Raises
        ------
        SolverError
            When there are none near.
        """
        made = replace(self.made, scene=self.made.scene.changed(effects=scene.effects))
        return AtRest._by(scene, made, instants_of(scene))

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

    def better(self) -> Iterator[tuple[str, OfPoses]]:
        """Give the same without most of the error of a source, which is named."""
        finer = _undamped(with_halves(self.scene), self.made.machine)
        yield "mesh", AtRest._by(self.scene, finer, instants_of(self.scene)).positions
        if self.following is not None:
            yield "theory", self.corrected

    @cached_property
    def corrected(self) -> OfPoses:
        """The answers after one more step of Newton's method."""
        first = self.following
        assert first is not None
        second = copy(first)
        second.step()
        here = Motion(first.machine, first.t, first.q, 0 * first.q, first.a, first.moving)
        return OfLinear.by(self.made, LinearMotion(here, second.change, first.stresses, False))


def _undamped(scene: Scene, coarse: Machine | None = None) -> SceneMachine:
    """Build a machine whose links are not damped."""
    return built(scene.changed({"damping.material": 0.0, "damping.ratio": 0.0}), coarse)


def _refuse_buckled(scene: Scene, steps: StaticIteration) -> None:
    """Raise `SolverError` where the stiffness about a static answer is not positive."""
    yielding = steps.yielding
    if yielding.any():
        worst = int(np.argmax(yielding))
        angle = np.degrees(scene.cycle_rate * steps.t[worst])
        raise SolverError(
            f"the static answer at drive angle {angle:.6g} deg is unstable: members buckle. Under its axial forces its "
            f"stiffness is not positive in {yielding[worst]} independent ways. Lower the load or the speed, or take "
            "stiffer members"
        )


def instants_of(scene: Scene, share: float = 0.0) -> Array:
    """Give the instants at which the positions of a result are, or at a share of the way to the next (s).

    Parameters
    ----------
    scene
        The scene.
    share
        Of the way.
    """
    if scene.analysis.method == "static":
        return np.array([scene.analysis.position / scene.cycle_rate if scene.drives else 0.0])
    return scene.period / scene.analysis.sub_intervals * (np.arange(scene.analysis.sub_intervals) + share)
