"""Periodic motion by collocation: Newton's method over the whole cycle, closed by a PETSc KSP."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._petsc import PETSc, SLEPc
from fenics_mech.errors import SolverError
from fenics_mech.machine import Evaluation, Machine
from fenics_mech.solve.newton import newton, predicted
from fenics_mech.solve.sparse import Factors, blocks_of
from fenics_mech.solve.stages import Tableau, radau, stage_matrix


@dataclass
class Cycle:
    """A periodic motion at the stages of its steps.

    Parameters
    ----------
    machine
        Its machine, whose chart is a cycle.
    t
        Instants of the stages ``(steps, stages)`` (s).
    q, v, a
        Coordinates, rates, accelerations with multipliers ``(steps, stages, size)``.
    evaluation
        The residual at these instants.
    tableau
        Of a step.
    iterations
        Newton steps.
    change
        Size of the last Newton step, relative to the largest coordinate.
    steps
        Linear steps of the converged cycle, for closing and multipliers.
    """

    machine: Machine
    t: Array
    q: Array
    v: Array
    a: Array
    evaluation: Evaluation
    tableau: Tableau
    iterations: int
    change: float
    steps: LinearSteps

    def multipliers(self, count: int = 6) -> Array:
        """Give the largest Floquet multipliers: factors on a small disturbance in one cycle.

        Parameters
        ----------
        count
            How many.
        """
        return self.steps.multipliers(count)


class LinearSteps:
    """The linearised steps of a cycle: factors of every step, and how a state goes through them.

    A state is (coordinates, rates times h), ``(2 n,)``.
    """

    def __init__(self, machine: Machine, tableau: Tableau, h: float, found: Evaluation) -> None:
        self.n, self.size, self.h, self.tableau = machine.n, machine.size, h, tableau
        self.stages = len(tableau.c)
        self.count = len(found.force) // self.stages
        self.pattern = machine.pattern
        by_step = [x.reshape(self.count, self.stages, -1) for x in (found.M, found.C, found.K)]
        self.C, self.K = by_step[1], by_step[2]
        blocks = blocks_of(machine.pattern, self.stages)
        self.factors = [
            Factors(blocks, stage_matrix(tableau, h, *(x[k] for x in by_step)), f"step {k + 1} of the cycle")
            for k in range(self.count)
        ]

    def through(self, k: int, state: Array, right: Array | None = None) -> tuple[Array, Array]:
        """Take a state through step `k` under forces ``(stages, size)``: accelerations, and the state after it."""
        n, h, tableau = self.n, self.h, self.tableau
        x, y = np.zeros(self.size), np.zeros(self.size)
        x[:n], y[:n] = state[:n], state[n:]
        force = np.zeros((self.stages, self.size)) if right is None else right.copy()
        at_stages = x + tableau.c[:, None] * y
        force -= self.pattern.times(self.K[k], at_stages)
        force -= self.pattern.times(self.C[k], np.broadcast_to(y / h, at_stages.shape))
        a = self.factors[k].solve(force.T.ravel()).reshape(self.size, self.stages).T
        end = np.concatenate(
            [x[:n] + y[:n] + h * h * (tableau.square[-1] @ a)[:n], y[:n] + h * h * (tableau.A[-1] @ a)[:n]]
        )
        return a, end

    def cycle(self, state: Array) -> Array:
        """Take a state through the whole cycle."""
        for k in range(self.count):
            state = self.through(k, state)[1]
        return state

    def closed(self, right: Array, gaps: Array) -> tuple[Array, Array]:
        """Solve for periodic states under forces ``(steps, stages, size)`` and gaps between steps ``(steps, 2 n)``."""
        state = np.zeros(2 * self.n)
        for k in range(self.count):
            state = self.through(k, state, right[k])[1] + gaps[k]
        start = self._ksp(state)
        states, accelerations = [start], []
        for k in range(self.count):
            a, end = self.through(k, states[-1], right[k])
            accelerations.append(a)
            states.append(end + gaps[k])
        return np.array(states[:-1]), np.array(accelerations)

    def _ksp(self, right: Array) -> Array:
        """Solve (1 - cycle) x = right by GMRES."""
        operator = _shell(len(right), lambda x: x - self.cycle(x))
        ksp = PETSc.KSP().create(PETSc.COMM_SELF)
        ksp.setOptionsPrefix("fenics_mech_closing_")
        ksp.setOperators(operator)
        ksp.setType("gmres")
        ksp.setGMRESRestart(len(right))
        ksp.getPC().setType("none")
        ksp.setTolerances(rtol=1e-11, atol=1e-300, max_it=len(right) + 10)
        ksp.setFromOptions()
        b, x = operator.createVecs()
        b.setArray(right)
        ksp.solve(b, x)
        if ksp.getConvergedReason() < 0:
            raise SolverError("the cycle does not close: the linearised motion is at a resonance that nothing damps")
        return np.array(x.getArray())

    def multipliers(self, count: int) -> Array:
        """Give the largest multipliers."""
        if 2 * self.n <= 60:  # a dense matrix costs no more marches than Arnoldi's method takes
            whole = np.array([self.cycle(column) for column in np.eye(2 * self.n)]).T
            values = np.linalg.eigvals(whole)
        else:
            solver = SLEPc.EPS().create(PETSc.COMM_SELF)
            solver.setOptionsPrefix("fenics_mech_multipliers_")
            solver.setOperators(_shell(2 * self.n, self.cycle))
            solver.setProblemType(SLEPc.EPS.ProblemType.NHEP)
            solver.setDimensions(count)
            solver.setWhichEigenpairs(SLEPc.EPS.Which.LARGEST_MAGNITUDE)
            solver.setFromOptions()
            solver.solve()
            values = np.array([solver.getEigenvalue(i) for i in range(solver.getConverged())])
        return values[np.argsort(-np.abs(values))][:count]


class _Operator:
    def __init__(self, apply: Callable[[Array], Array]) -> None:
        self.apply = apply

    def mult(self, matrix: object, x: object, y: object) -> None:
        y.setArray(self.apply(x.getArray(readonly=True)))  # type: ignore[attr-defined]


def _shell(size: int, apply: Callable[[Array], Array]):  # type: ignore[no-untyped-def]
    matrix = PETSc.Mat().createPython([size, size], _Operator(apply), comm=PETSc.COMM_SELF)
    matrix.setUp()
    return matrix


def periodic(
    machine: Machine, period: float, steps: int = 60, *, stages: int = 3, tolerance: float = 1e-7, most: int = 25
) -> Cycle:
    """Find the periodic motion beside the machine's chart.

    Parameters
    ----------
    machine
        The machine; its chart is a periodic motion, such as that of rigid members.
    period
        s.
    steps, stages
        Of a cycle, and of a step.
    tolerance
        Of the last change, relative to the largest coordinate.
    most
        Newton steps that may be taken.

    Raises
    ------
    SolverError
        When there is none near by, or it is at an undamped resonance.
    """
    iteration = Iteration(machine, period, steps, stages)
    iterations = newton(iteration.step, tolerance, most, "the periodic motion")
    shape = (steps, stages, machine.size)
    q, v = iteration.at_stages(iteration.q0, iteration.v0, iteration.a)
    final = machine.residual(iteration.t.ravel(), q, v, iteration.a.reshape(q.shape))
    return Cycle(
        machine,
        iteration.t,
        q.reshape(shape),
        v.reshape(shape),
        iteration.a,
        final,
        iteration.tableau,
        iterations,
        iteration.size_of_change,
        iteration.linear,
    )


class Iteration:
    """Newton's method over a cycle, step by step, from the chart.

    Parameters
    ----------
    machine
        The machine; its chart is a periodic motion.
    period
        s.
    steps, stages
        Of a cycle, and of a step.
    predicted
        Stresses of every term that make the geometric stiffness of the first step; None for the present ones.
    """

    found: Evaluation
    linear: LinearSteps
    change: tuple[Array, Array, Array]  # of coordinates, rates and accelerations at the stages (instants, size)
    size_of_change: float  # relative to the largest coordinate

    def __init__(
        self, machine: Machine, period: float, steps: int, stages: int, predicted: Sequence[Array] | None = None
    ) -> None:
        self.machine, self.tableau, self.h, self.stresses = machine, radau(stages), period / steps, predicted
        self.t = self.h * (np.arange(steps)[:, None] + self.tableau.c)
        self.q0, self.v0 = np.zeros((steps, machine.size)), np.zeros((steps, machine.size))
        self.a = np.zeros((steps, stages, machine.size))

    def at_stages(self, q0: Array, v0: Array, a: Array) -> tuple[Array, Array]:
        """Give coordinates and rates at the stages ``(instants, size)``, by those at the starts of the steps."""
        h, tableau, size = self.h, self.tableau, self.machine.size
        q = q0[:, None] + h * tableau.c[:, None] * v0[:, None] + h * h * np.einsum("ij,kjn->kin", tableau.square, a)
        v = v0[:, None] + h * np.einsum("ij,kjn->kin", tableau.A, a)
        coordinates = np.arange(size) < self.machine.n
        return (q * coordinates).reshape(-1, size), (v * coordinates).reshape(-1, size)

    def _gaps(self) -> Array:
        """Give what the end of each step misses of the start of the next ``(steps, 2 n)``."""
        h, tableau, q0, v0, a, n = self.h, self.tableau, self.q0, self.v0, self.a, self.machine.n
        end_q = (q0 + h * v0 + h * h * np.einsum("j,kjn->kn", tableau.square[-1], a))[:, :n]
        end_v = (v0 + h * np.einsum("j,kjn->kn", tableau.A[-1], a))[:, :n]
        next_q, next_v = (np.roll(x, -1, axis=0)[:, :n] for x in (q0, v0))
        return np.concatenate([end_q - next_q, h * (end_v - next_v)], axis=1)

    def step(self) -> float:
        """Take a step, and give its size relative to the largest coordinate."""
        machine, n = self.machine, self.machine.n
        q, v = self.at_stages(self.q0, self.v0, self.a)
        a = self.a.reshape(q.shape)
        self.found = machine.residual(self.t.ravel(), q, v, a, predicted=self.stresses)
        self.linear = LinearSteps(machine, self.tableau, self.h, self.found)
        states, da = self.linear.closed(-self.found.force.reshape(self.a.shape), self._gaps())
        dq0, dv0 = np.zeros_like(self.q0), np.zeros_like(self.v0)
        dq0[:, :n], dv0[:, :n] = states[:, :n], states[:, n:] / self.h
        dq, dv = self.at_stages(dq0, dv0, da)
        self.change = dq, dv, da.reshape(dq.shape)
        self.stresses = predicted(machine, self.found, *self.change)
        self.q0 += dq0
        self.v0 += dv0
        self.a += da
        self.size_of_change = float(np.abs(dq).max() / max(np.abs(q + dq).max(), 1e-12))
        return self.size_of_change
