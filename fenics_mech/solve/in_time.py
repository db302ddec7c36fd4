"""Motion in time by Radau IIA, with steps that an error bound chooses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError
from fenics_mech.geometry import PoseMotion
from fenics_mech.machine import Machine
from fenics_mech.solve.newton import newton, predicted
from fenics_mech.solve.sparse import Factors, blocks_of
from fenics_mech.solve.stages import Tableau, radau, stage_matrix

SAFETY, LEAST, MOST = 0.9, 0.2, 4.0  # of a step's change: Hairer and Wanner, Solving ODE II, chapter IV.8


@dataclass
class Course:
    """A motion in time at the ends of its steps.

    Parameters
    ----------
    t
        Instants (s).
    motion
        Places, rotations, velocities and spins of all poses at these instants.
    multipliers
        ``(instants, rows)``.
    steps, refused
        Steps taken and refused.
    """

    t: Array
    motion: list[PoseMotion]
    multipliers: Array
    steps: int
    refused: int


def march(
    machine: Machine,
    v: Array,
    duration: float,
    *,
    h: float | None = None,
    tolerance: float = 1e-6,
    stages: int = 3,
    start: float = 0.0,
) -> Course:
    """Follow a motion from the poses of the machine's chart, which moves along.

    Parameters
    ----------
    machine
        The machine; its chart is at rest.
    v
        Rates at the start ``(size,)``.
    duration
        s.
    h
        Length of all steps (s); None to choose them.
    tolerance
        Largest error of a coordinate in a step (m, rad), where steps are chosen.
    stages
        Stages of a step.
    start
        First instant (s).

    Raises
    ------
    SolverError
        When a step has no solution.
    """
    tableau, n = radau(stages), machine.n
    fixed, t, end = h is not None, start, start + duration
    step = h if h is not None else min(duration / 100, 1e-3 * duration)
    before: Array | None = None  # acceleration at the end of the last step
    times, motion, multipliers = [t], [_now(machine, t, v)], [np.zeros(len(machine.rows))]
    refused, angles = 0, None
    while t < end - 1e-12 * duration:
        step = min(step, end - t)
        try:
            a, q1, v1, ahead = _step(
                machine, tableau, t, step, v, before, 1e-3 * tolerance if not fixed else 1e-12, angles
            )
            error = 0.0 if fixed else _error(tableau, step, a, before, n)
        except SolverError:
            if fixed or step < 1e-9 * duration:
                raise
            error = np.inf
        if error > tolerance:
            step *= max(LEAST, SAFETY * (tolerance / error) ** (1 / (stages + 2)))
            refused += 1
            continue
        t, angles = t + step, ahead
        v, before = machine.rebase(q1, v1, a[-1])
        times.append(t)
        motion.append(_now(machine, t, v))
        multipliers.append(before[n : n + len(machine.rows)])
        if not fixed:
            step *= min(MOST, SAFETY * (tolerance / max(error, 1e-300)) ** (1 / (stages + 2)))
    return Course(np.array(times), motion, np.array(multipliers), len(times) - 1, refused)


def _step(
    machine: Machine,
    tableau: Tableau,
    t: float,
    h: float,
    v: Array,
    before: Array | None,
    tolerance: float,
    angles: list[Array] | None,
) -> tuple[Array, Array, Array, list[Array]]:
    """Solve a step from the chart: accelerations at its stages, coordinates and rates at its end."""
    n, size, stages = machine.n, machine.size, len(tableau.c)
    a = np.tile(np.zeros(size) if before is None else before, (stages, 1))
    instants, stresses = t + h * tableau.c, None
    ends: list[Array] = []

    def step() -> float:
        nonlocal stresses, a
        q = h * tableau.c[:, None] * v + h * h * tableau.square @ a
        rate = v + h * tableau.A @ a
        q[:, n:] = rate[:, n:] = 0.0
        near = None if angles is None else [np.broadcast_to(x, (stages, *x.shape[1:])) for x in angles]
        found = machine.residual(instants, q, rate, a, predicted=stresses, angles=near)
        ends[:] = [term.x[-1:] for term in found.terms]
        matrix = stage_matrix(tableau, h, found.M, found.C, found.K)
        factors = Factors(blocks_of(machine.pattern, stages), matrix, f"step at {t:.6g} s")
        da = factors.solve(-found.force.T.ravel()).reshape(size, stages).T
        a = a + da
        dq, dv = h * h * tableau.square @ da, h * tableau.A @ da
        dq[:, n:] = dv[:, n:] = 0.0
        stresses = predicted(machine, found, dq, dv, da)
        return float(np.abs(dq).max())

    newton(step, tolerance, 15, f"step at {t:.6g} s")
    q, rate = h * v + h * h * (tableau.square @ a)[-1], v + h * (tableau.A @ a)[-1]
    q[n:] = rate[n:] = 0.0
    return a, q, rate, ends


def _error(tableau: Tableau, h: float, a: Array, before: Array | None, n: int) -> float:
    """Bound the error of the coordinates inside a step by what the acceleration misses at its start."""
    if before is None:
        return 0.0
    return float(tableau.inside * h * h * np.abs(tableau.back @ a[:, :n] - before[:n]).max())


def _now(machine: Machine, t: float, v: Array) -> PoseMotion:
    """Give places, rotations, velocities and spins of the poses of the chart."""
    at = machine.known.at(np.array([t]))
    V = np.append(v, 0.0)[machine.places]
    d = machine.geometry.d
    return PoseMotion(at.r[0], at.R[0], at.v[0] + V[:, :d], at.w[0] + V[:, d:], at.a[0], at.al[0])
