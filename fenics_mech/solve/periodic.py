"""Periodic motion by collocation: Newton's method over the whole cycle, closed by a PETSc KSP."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._petsc import PETSc, SLEPc, configured
from fenics_mech.errors import SolverError
from fenics_mech.geometry import Fourier
from fenics_mech.machine import Evaluation, Machine
from fenics_mech.solve.blows import Blows, blows_of, gaps_between
from fenics_mech.solve.compiled_steps import CompiledSteps, order_of
from fenics_mech.solve.newton import converge
from fenics_mech.solve.operators import by_gmres, shell
from fenics_mech.solve.path import Path
from fenics_mech.solve.sparse import Factors, blocks_of
from fenics_mech.solve.stages import stage_matrix

logger = logging.getLogger(__name__)
MOTION = "the periodic motion"  # what Newton's method seeks here, in its messages
MOST = 25  # of its steps
DENSE = 60  # unknowns of a state: a dense matrix costs no more marches than Arnoldi's method takes
CLOSED, CLOSING = 1e-11, "fenics_mech_closing_"  # what GMRES may leave of a right side, and the prefix of its options
RESONANT = "the cycle does not close: the linearised motion is at a resonance that nothing damps"
TINY = 1e-10  # of the machine's extent, and rad: motions below it are as exact as Newton's method finds them
OTHERWISE = 3.0  # by which a state is divided and multiplied again, so that its marches are rounded in another way


@dataclass
class Cycle:
    """A periodic motion.

    Parameters
    ----------
    machine
        Its machine, whose chart is a cycle.
    path
        The motion beside the chart.
    changes
        Newton corrections of the coordinates, relative to the largest. From the motion of a chart, the first gives the
        linear answer, and the second is what that leaves out.
    linear
        The residual of the motion beside which this one is linear; None of an exact one.
    """

    machine: Machine
    path: Path
    changes: list[float]
    linear: Evaluation | None = None

    def __post_init__(self) -> None:
        self.tableau = self.path.tableau
        self.t, self.q, self.v, self.a = self.path.at(self.tableau.c)

    @cached_property
    def evaluation(self) -> Evaluation:
        """The residual at the stages, with the tangents by which small disturbances go."""
        if self.linear is not None:
            return self.linear
        return Iteration(self.machine, self.path).evaluated()

    @cached_property
    def steps(self) -> LinearSteps:
        """Linear steps of the converged cycle: made where they are asked for, as their factors take memory."""
        return LinearSteps(self.machine, self.path if self.linear is None else self.path.resting, self.evaluation)

    @cached_property
    def blows(self) -> dict[int, Blows]:
        """The impulses, by the step at whose end they act."""
        return blows_of(self.machine, self.path)

    @cached_property
    def lost(self) -> float:
        """Share of the motion that rounding takes, by estimate: by how much one more solution changes the start.

        It is for what the steps miss of the start, and for the difference of two ways to round them. Where a part of
        the motion hardly settles, as behind a damper that is as good as rigid, both count many times.
        """
        steps, path, n = self.steps, self.path, self.machine.n
        state = np.concatenate([path.q0[0, :n], steps.unit * path.v0[0, :n]])
        start = state if self.linear is not None else 0 * state
        right, gaps = -self.evaluation.force.reshape(path.a.shape), gaps_between(steps.path, steps.blows)
        missed = steps.through(start[None], right, gaps)[0][0] - start
        missed += OTHERWISE * steps.cycle(state / OTHERWISE) - steps.cycle(state)
        if len(state) <= DENSE:
            change = np.linalg.solve(np.eye(len(state)) - steps.whole, missed)
        else:  # by GMRES, which may overlook a part that hardly settles
            change = by_gmres(lambda x: x - steps.cycle(x), missed, CLOSED, len(state), CLOSING, RESONANT)
        size, off = (float(np.linalg.norm(x / np.tile(self.machine.units[:n], 2))) for x in (state, change))
        return off / max(size, TINY)

    def multipliers(self, count: int = 6) -> Array:
        """Give the largest Floquet multipliers: factors on a small disturbance in one cycle."""
        return self.steps.multipliers(count)[0]


class LinearSteps:
    """The linearised steps of a cycle: factors of every step, and how states go through them."""

    # A state is (coordinates, rates times the mean step), (2 n,).

    def __init__(self, machine: Machine, path: Path, found: Evaluation) -> None:
        self.tableau, self.pattern = path.tableau, machine.pattern
        self.path, self.n, self.h, self.period = path, machine.n, path.h, path.period
        self.unit, self.ends = path.period / len(path.starts), path.starts + path.h
        self.blows = blows_of(machine, path)
        M, self.C, self.K = np.stack([found.M, found.C, found.K]).reshape(3, *path.a.shape[:2], -1)
        march = CompiledSteps(order_of(self.pattern, self.n), self.n, self.tableau, self.h, M, self.C, self.K)
        self.march = march if march.holds else None
        if self.march is None:
            blocks = blocks_of(self.pattern, path.a.shape[1])
            matrices = (stage_matrix(self.tableau, *of_step) for of_step in zip(self.h, M, self.C, self.K))
            self.factors = [Factors(blocks, x, f"step {k + 1} of the cycle") for k, x in enumerate(matrices)]

    def through(
        self, states: Array, right: Array | None = None, gaps: Array | None = None, along: bool = False
    ) -> tuple[Array, Array | None, Array | None]:
        """Take states through all steps."""
        # states (states, 2 n)
        if self.march is not None:
            return self.march.through(states, self.unit, self.blows, right, gaps, along)
        a, after, ends = [], [], states
        for k in range(len(self.h)):
            steps = [self._through(k, state, None if right is None else right[k]) for state in ends]
            ends = np.array([end if gaps is None else end + gaps[k] for _, end in steps])
            a.append(steps[0][0])
            after.append(ends)
        return ends, np.array(a), np.array(after)

    def _through(self, k: int, state: Array, right: Array | None) -> tuple[Array, Array]:
        """Take a state through step `k` under forces ``(stages, size)``: accelerations, and the state after it."""
        n, h, unit, tableau = self.n, self.h[k], self.unit, self.tableau
        x, y = state[:n], state[n:]
        at_stages = np.zeros((2, len(tableau.c), self.pattern.size))
        at_stages[0, :, :n], at_stages[1, :, :n] = x + h / unit * tableau.c[:, None] * y, y / unit
        force = -self.pattern.times(self.K[k], at_stages[0]) - self.pattern.times(self.C[k], at_stages[1])
        force += 0.0 if right is None else right
        a = self.factors[k].solve(force.T.ravel()).reshape(-1, len(tableau.c)).T
        end = [x + h / unit * y + h * h * (tableau.square[-1] @ a)[:n], y + h * unit * (tableau.A[-1] @ a)[:n]]
        if k in self.blows:
            end[1] = end[1] + unit * self.blows[k].by_q @ end[0]
        return a, np.concatenate(end)

    def cycle(self, state: Array) -> Array:
        """Take a state through the whole cycle."""
        return self.through(state[None])[0][0]

    @cached_property
    def whole(self) -> Array:
        """The matrix that takes a state through the cycle ``(2 n, 2 n)``."""
        return self.through(np.eye(2 * self.n))[0].T

    def change(self, right: Array, gaps: Array) -> Path:
        """Give by what the path changes, periodic again."""
        # GMRES solves (1 - cycle) x = b for the state at the start.
        b = self.through(np.zeros((1, 2 * self.n)), right, gaps)[0][0]
        start = by_gmres(lambda x: x - self.cycle(x), b, CLOSED, len(b), CLOSING, RESONANT)
        return self.along(start, right, gaps)

    def along(self, start: Array, right: Array | None = None, gaps: Array | None = None) -> Path:
        """Give what a state at the start of the cycle becomes, as a change of the path; arguments as of `change`."""
        _, a, after = self.through(start[None], right, gaps, along=True)
        assert a is not None
        assert after is not None
        states, path, n = np.concatenate([start[None], after[:-1, 0]]), self.path, self.n
        q0, v0 = np.zeros_like(path.q0), np.zeros_like(path.v0)
        q0[:, :n], v0[:, :n] = states[:, :n], states[:, n:] / self.unit
        return replace(path, q0=q0, v0=v0, a=a)

    def multipliers(self, count: int) -> tuple[Array, Array]:
        """Give the largest multipliers, and the states that they multiply ``(2 n, multipliers)``."""
        if 2 * self.n <= DENSE:
            values, vectors = np.linalg.eig(self.whole)
        else:
            eps = SLEPc.EPS().create(PETSc.COMM_SELF)
            eps.setProblemType(SLEPc.EPS.ProblemType.NHEP)
            eps.setDimensions(count)
            eps.setWhichEigenpairs(SLEPc.EPS.Which.LARGEST_MAGNITUDE)
            with shell(2 * self.n, self.cycle) as (operator, real, imaginary):
                eps.setOperators(operator)
                with configured(eps, "fenics_mech_multipliers_", {}, {}):
                    eps.solve()
                    values = np.zeros(eps.getConverged(), complex)
                    vectors = np.zeros((2 * self.n, len(values)), complex)
                    for i in range(len(values)):
                        values[i] = eps.getEigenpair(i, real, imaginary)
                        vectors[:, i] = real.getArray() + 1j * imaginary.getArray()
        order = np.argsort(-np.abs(values))[:count]
        return values[order], vectors[:, order]


def periodic(
    machine: Machine,
    period: float,
    steps: int | Array = 60,
    *,
    stages: int = 3,
    tolerance: float = 1e-7,
    most: int = MOST,
    start: Path | None = None,
) -> Cycle:
    """Find the periodic motion beside the machine's chart.

    Where Newton's method does not lead to one, inertia and loads are increased from none, and no sizes of changes are
    given.

    Parameters
    ----------
    machine
        The machine; its chart is a periodic motion, such as that of rigid members.
    period
        s.
    steps, stages
        Of a cycle, and of a step. Steps are so many even ones, or the instants at which they begin (s): loads may jump
        there.
    tolerance
        Of the last change, relative to the largest coordinate.
    most
        Newton steps that may be taken.
    start
        Where to begin, with its own steps; None for the chart.

    Raises
    ------
    SolverError
        When there is none near by, or it is at an undamped resonance.
    """
    chart = machine.known
    if isinstance(chart, Fourier) and abs((cycles := period / chart.period) - round(cycles)) > 1e-9:
        raise SolverError(
            f"the period of {period:.6g} s is no multiple of that of the rigid motion, {chart.period:.6g} s"
        )
    iteration = Iteration(machine, Path.of_rest(machine, period, steps, stages) if start is None else start)
    changes = converge(iteration, tolerance, most, MOTION)
    logger.debug("Newton %d iterations", len(changes))
    return Cycle(machine, iteration.path, changes)


LEAST = 1e-6  # of the machine's extent: coordinates below it are rounding of places, 1e-16, within the tolerance


class Iteration:
    """Newton's method over a cycle, step by step.

    Parameters
    ----------
    machine
        The machine; its chart is a periodic motion.
    path
        Where it begins.
    stresses
        Those of every term that make the geometric stiffness of the first step; None for the present ones, of all
        terms or of one.
    turning
        As of `Machine.residual`.
    """

    found: Evaluation
    change: tuple[Array, Array, Array]  # of coordinates, rates and accelerations at the stages (instants, size)
    predicted: Sequence[Array]  # stresses of every term after the last step

    def __init__(
        self, machine: Machine, path: Path, stresses: Sequence[Array | None] | None = None, turning: bool = True
    ) -> None:
        self.machine, self.path, self.stresses, self.turning = machine, path, stresses, turning
        self.share, self.without = 1.0, np.zeros(1)  # of the forces that act in the chart's motion, and the others

    def rest(self) -> None:
        """Go back to the chart's motion, of whose forces a share may act."""
        self.path, self.stresses = self.path.resting, None
        self.without = self.evaluated(tangents=False).force

    def refuse_beyond(self, reached: float) -> None:
        """Refuse nothing: a motion goes on with the loads, whether it is stable or not."""

    def evaluated(self, predicted: Sequence[Array | None] | None = None, tangents: bool = True) -> Evaluation:
        """Give the residual at the stages of the path, with modes of stress as large as the rates say."""
        t, q, v, a = self.path.at(self.path.tableau.c)
        size = self.machine.size
        flat = q.reshape(-1, size), v.reshape(-1, size), a.reshape(-1, size)
        residual, turning = self.machine.residual, self.turning
        return residual(t.ravel(), *flat, predicted=predicted, turning=turning, tangents=tangents, known=True)

    def linearised(self) -> LinearSteps:
        """Give the steps linearised about the path, whose residual is then `found`."""
        self.found = self.evaluated(self.stresses)
        return LinearSteps(self.machine, self.path, self.found)

    def predict(self, change: Path) -> None:
        """Predict the stresses after a change of the path, for the next step."""
        _, q, v, a = change.at(self.path.tableau.c)
        size = self.machine.size
        self.change = q.reshape(-1, size), v.reshape(-1, size), a.reshape(-1, size)
        self.stresses = self.predicted = self.machine.predicted(self.found, *self.change)

    def step(self) -> float:
        """Take a step, and give the size of its change."""
        path, linear = self.path, self.linearised()
        force = self.found.force - (1.0 - self.share) * self.without
        change = linear.change(-force.reshape(path.a.shape), gaps_between(path, linear.blows))
        self.predict(change)
        self.path = path.moved(change)
        unit = self.machine.units
        largest = max(np.abs(self.path.at(path.tableau.c)[1] / unit).max(), LEAST)
        return float(np.abs(self.change[0] / unit).max() / largest)
