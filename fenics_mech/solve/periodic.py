"""Periodic motion by collocation: Newton's method over the whole cycle, closed by a PETSc KSP."""

from __future__ import annotations

from collections.abc import Callable
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
        The next Newton correction of the coordinates, relative to the largest: what a further step would change.
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
    tableau, n, size, h = radau(stages), machine.n, machine.size, period / steps
    t = h * (np.arange(steps)[:, None] + tableau.c)
    q0, v0, a = np.zeros((steps, size)), np.zeros((steps, size)), np.zeros((steps, stages, size))
    coordinates = np.arange(size) < n
    stresses = None
    linear: LinearSteps
    found: Evaluation

    def at_stages(q0: Array, v0: Array, a: Array) -> tuple[Array, Array]:
        q = q0[:, None] + h * tableau.c[:, None] * v0[:, None] + h * h * np.einsum("ij,kjn->kin", tableau.square, a)
        v = v0[:, None] + h * np.einsum("ij,kjn->kin", tableau.A, a)
        return (q * coordinates).reshape(-1, size), (v * coordinates).reshape(-1, size)

    def step() -> float:
        nonlocal stresses, linear, found
        q, v = at_stages(q0, v0, a)
        found = machine.residual(t.ravel(), q, v, a.reshape(-1, size), predicted=stresses)
        linear = LinearSteps(machine, tableau, h, found)
        end_q = (q0 + h * v0 + h * h * np.einsum("j,kjn->kn", tableau.square[-1], a))[:, :n]
        end_v = (v0 + h * np.einsum("j,kjn->kn", tableau.A[-1], a))[:, :n]
        gaps = np.concatenate(
            [end_q - np.roll(q0, -1, axis=0)[:, :n], h * (end_v - np.roll(v0, -1, axis=0)[:, :n])], axis=1
        )
        states, da = linear.closed(-found.force.reshape(steps, stages, size), gaps)
        dq0, dv0 = np.zeros((steps, size)), np.zeros((steps, size))
        dq0[:, :n], dv0[:, :n] = states[:, :n], states[:, n:] / h
        dq, dv = at_stages(dq0, dv0, da)
        stresses = predicted(machine, found, dq, dv, da.reshape(dq.shape))
        q0[:] += dq0
        v0[:] += dv0
        a[:] += da
        return float(np.abs(dq).max() / max(np.abs(q + dq).max(), 1e-12))

    changes: list[float] = []

    def counted() -> float:
        changes.append(step())
        return changes[-1]

    iterations = newton(counted, tolerance, most, "the periodic motion")
    q, v = at_stages(q0, v0, a)
    final = machine.residual(t.ravel(), q, v, a.reshape(-1, size))
    shape = (steps, stages, size)
    return Cycle(machine, t, q.reshape(shape), v.reshape(shape), a, final, tableau, iterations, changes[-1], linear)
