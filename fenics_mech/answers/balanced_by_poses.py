"""Answers of the equation of poses as Fourier series: harmonic balance, exact or linear beside the rigid motion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from fenics_mech._arrays import Array
from fenics_mech.answers.solved_by_poses import (
    LinearCycle,
    Run,
    Solved,
    built,
    instants_of,
    left_out_by_linear,
    stiffening,
)
from fenics_mech.estimate import finer_mesh
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.planning.cycle_steps import Steps
from fenics_mech.recovery.of_poses import OfPoses
from fenics_mech.scene import Scene
from fenics_mech.solve import Cycle, Iteration, Path, periodic
from fenics_mech.solve.harmonic_balance import Balance, Series, balanced


@dataclass(frozen=True)
class Balanced(Solved):
    """A periodic motion as a Fourier series; its cycle is the same by steps."""

    series: Series
    lost = 0.0  # harmonics have no steps through which rounding grows

    @classmethod
    def of(cls, scene: Scene, run: Run | None = None) -> Balanced:
        """Build the machine of a scene, and find its periodic motion."""
        # A series begins from the rigid motion, whatever motions were before it.
        made, analysis = built(scene), scene.analysis
        series, changes = balanced(made.machine, scene.period, analysis.harmonics, analysis.sub_intervals)
        path = series.path(Steps.of(scene).times, analysis.stages)
        cycle = Cycle(made.machine, path, changes)
        return cls(scene, made, cycle, series, left_out=left_out_by_linear(changes))

    def _at(self, share: float) -> tuple[Array, Array, Array, Array]:
        t = instants_of(self.scene, share)
        return t, *self.series.at(t)

    def better(self) -> Iterator[tuple[str, OfPoses]]:
        """Give the same at the positions without most of the error of a source, which is named."""
        path = self.cycle.path
        yield "harmonics", Solved(self.scene, self.made, periodic(self.made.machine, path.period, start=path)).at(0.0)
        yield "mesh", Solved(self.scene, self.finer, finer_mesh(self.cycle, self.finer.machine)).at(0.0)


@dataclass(frozen=True)
class LinearBalanced(LinearCycle):
    """A periodic motion that is linear beside the rigid one, as a Fourier series."""

    series: Series
    lost = 0.0

    @classmethod
    def of(cls, scene: Scene, run: Run | None = None) -> LinearBalanced:
        """Build the machine of a scene, and find its periodic motion in the linear theory of its effects."""
        return cls._balanced(scene, built(scene))

    @classmethod
    def _balanced(cls, scene: Scene, made: SceneMachine) -> LinearBalanced:
        machine, analysis = made.machine, scene.analysis
        balance = Balance(machine, scene.period, analysis.harmonics, analysis.sub_intervals)
        balance.stresses = stiffening(scene, machine, balance.t)
        balance.turning = balance.stresses is not None
        balance.step()
        rest = Path.of_rest(machine, scene.period, Steps.of(scene).times, analysis.stages)
        stiff = stiffening(scene, machine, rest.at(rest.tableau.c)[0].ravel())
        step = Iteration(machine, rest, stiff, turning=balance.turning)
        step.found = step.evaluated(step.stresses)
        path = balance.series.path(rest.starts, analysis.stages)
        step.predict(path)
        cycle = Cycle(machine, path, [1.0], step.found)
        return cls(scene, made, cycle, list(step.predicted), balance.series)

    def _at(self, share: float) -> tuple[Array, Array, Array, Array]:
        t = instants_of(self.scene, share)
        return t, *self.series.at(t)

    def better(self) -> Iterator[tuple[str, OfPoses]]:
        """Give the same at the positions without most of the error of a source, which is named."""
        yield "harmonics", LinearCycle._by(self.scene, self.made, len(self.cycle.tableau.c)).positions
        yield "mesh", self._balanced(self.scene, self.finer).positions
        yield "theory", self.corrected
