"""A step of a motion in time, and states of a machine in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg

from fenics_mech._arrays import Array
from fenics_mech.geometry import PoseMotion
from fenics_mech.machine import Machine
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.measured import Measured
from fenics_mech.solve.newton import newton
from fenics_mech.solve.sparse import Factors, blocks_of
from fenics_mech.solve.stages import Tableau, radau, stage_matrix
from fenics_mech.terms import rubs

CONVERGED = 1e-3  # of the tolerance of a step, where Newton's method ends
UNPRESSED = 1e-9  # of the largest force of inertia: limits of friction below it are rounding
SHORT = 1e-2  # of the first step: one that leads back to the accelerations at the start, to the order of its stages


@dataclass(frozen=True)
class States:
    """Poses of a machine at some instants, and what stands with their accelerations.

    Parameters
    ----------
    t
        Instants ``(instants,)`` (s).
    motion
        All poses there.
    others
        Multipliers, and sizes of modes of stress ``(instants, others)``.
    measures
        Of every term ``(instants, elements, measures)``: whole turns are counted.
    """

    t: Array
    motion: PoseMotion
    others: Array
    measures: Sequence[Array]

    @classmethod
    def joined(cls, parts: Sequence[States]) -> States:
        """Put states one after the other."""
        motion = PoseMotion.joined([x.motion for x in parts])
        t, others = np.concatenate([x.t for x in parts]), np.concatenate([x.others for x in parts])
        return cls(t, motion, others, [np.concatenate(of_term) for of_term in zip(*(x.measures for x in parts))])


@dataclass(frozen=True)
class Step:
    """A step in time from the poses of the machine's chart, which rests.

    Parameters
    ----------
    machine, tableau
        The machine, and the stages.
    t, h
        Start and length (s).
    v
        Rates at the start ``(size,)``.
    tolerance
        Of every coordinate ``(coordinates,)`` (m, rad).
    angles
        Measures of every term at the start; None where the terms know.
    a
        Accelerations at the stages ``(stages, size)``.
    measures
        Measures of every term at the stages.
    shapes
        Gives changes of shape, each over its tolerance, by coordinates ``(shapes, coordinates)``; None where there is
        no other tolerance of them.
    tangents
        M, C and K near the stages ``(stages, entries)`` each; None before it is solved.
    stresses
        Of every term at the stages, as Newton's method predicted them last.
    """

    machine: Machine
    tableau: Tableau
    t: float
    h: float
    v: Array
    tolerance: Array
    angles: Sequence[Array] | None
    a: Array
    measures: Sequence[Array] = ()
    shapes: Array | None = None
    tangents: tuple[Array, Array, Array] | None = None
    stresses: Sequence[Array] | None = None

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """Give coordinates, rates and accelerations at shares of the step ``(shares, size)`` each."""
        tableau, h, n = self.tableau, self.h, self.machine.n
        values, integrals = tableau.at(s)
        q = h * s[:, None] * self.v + h * h * integrals @ (tableau.A @ self.a)
        v = self.v + h * integrals @ self.a
        q[:, n:] = v[:, n:] = 0.0
        return q, v, values @ self.a

    def solved(self) -> Step:
        """Solve it by Newton's method from the accelerations that it has."""
        machine, tableau, h, n = self.machine, self.tableau, self.h, self.machine.n
        a, size, stages = self.a.copy(), machine.size, len(tableau.c)
        if rubs(self.machine.terms):  # from the rates at the start: what sticks is not taken for what slides
            a[:, :n] = 0.0
        instants, blocks = self.t + h * tableau.c, blocks_of(machine.pattern, stages)
        stresses: Sequence[Array] | None = None
        measures: list[Array] = []
        tangents = None

        def step() -> float:
            nonlocal stresses, a, tangents
            q, v, _ = replace(self, a=a).at(tableau.c)
            found = machine.residual(instants, q, v, a, predicted=stresses, angles=machine.turned(self.angles, q))
            measures[:] = [term.x for term in found.terms]
            tangents = found.M, found.C, found.K
            matrix = stage_matrix(tableau, h, *tangents)
            da = Factors(blocks, matrix, f"step at {self.t:.6g} s").solve(-found.force.T.ravel())
            da = da.reshape(size, stages).T
            a = a + da
            dq, dv = h * h * tableau.square @ da, h * tableau.A @ da
            dq[:, n:] = dv[:, n:] = 0.0
            stresses = machine.predicted(found, dq, dv, da)
            return max(self._over(dq[:, :n]), self._slipping(found, stresses) if rubs(self.machine.terms) else 0.0)

        newton(step, CONVERGED, 15, f"step at {self.t:.6g} s")
        return replace(self, a=a, measures=measures, tangents=tangents, stresses=stresses)

    def tangents_there(self) -> tuple[Array, Array, Array]:
        """Give M, C and K at its stages ``(stages, entries)`` each, by the law of friction."""
        q, v, a = self.at(self.tableau.c)
        t, angles = self.t + self.h * self.tableau.c, self.machine.turned(self.angles, q)
        found = self.machine.residual(t, q, v, a, predicted=self.stresses, angles=angles)
        return found.M, found.C, found.K

    def _over(self, change: Array) -> float:
        """Give the largest of some changes of coordinates ``(..., coordinates)`` over what is allowed."""
        largest = float(np.abs(change / self.tolerance).max(initial=0.0))
        return largest if self.shapes is None else max(largest, float(np.abs(change @ self.shapes.T).max(initial=0.0)))

    def _slipping(self, found: Evaluation, predicted: Sequence[Array] | None) -> float:
        """Give how far friction is off its law, and how far a step of Newton's method takes it, over its limit."""
        # Changes of places in a short step do not show it.
        weight, worst = self.machine.inertia.largest(found.at), 0.0
        for k, term in enumerate(self.machine.terms):
            response = found.terms[k].response
            if len(term.rows) and predicted is not None and response.limit:
                change = float(np.abs(predicted[k] - response.stress).max())
                worst = max(worst, (response.off + change) / max(response.limit, UNPRESSED * weight))
        return worst

    def at_stages(self) -> States:
        """Give the poses at its stages."""
        return self._states(self.h * self.tableau.c, *self.at(self.tableau.c), self.measures)

    def at_end(self) -> States:
        """Give the poses at its end."""
        return self._states(np.array([self.h]), *self.at(np.ones(1)), [x[-1:] for x in self.measures])

    def at_start(self) -> States:
        """Give the poses at its start, with the accelerations and multipliers that a short step leads back to."""
        still, back = np.zeros((1, self.machine.size)), self.tableau.back
        short = replace(self, h=SHORT * self.h, a=np.tile(back @ self.a, (len(back), 1))).solved()
        return self._states(np.zeros(1), still, self.v[None], (back @ short.a)[None], short.measures)

    def _states(self, after: Array, q: Array, v: Array, a: Array, measures: Sequence[Array]) -> States:
        machine, chart, poses = self.machine, self.machine.chart, []
        for k, t in enumerate(self.t + after):
            poses.append(now(machine, t, *machine.rebase(q[k], v[k], a[k])))
            machine.chart = chart
        return States(self.t + after, PoseMotion.joined(poses), a[:, machine.n :], [x[: len(after)] for x in measures])

    def measured(self, k: int, shares: Array) -> Measured:
        """Give the measures of a term, by its number, at shares of the step; no response."""
        t, (q, v, a) = self.t + self.h * shares, self.at(shares)
        near = self.machine.terms[k].near(t) if self.angles is None else np.tile(self.angles[k], (len(t), 1, 1))
        return self.machine.groups[k].measure(self.machine.moved(t, q, v, a), near)

    def error(self, before: Array) -> float:
        """Bound its error over the tolerance by what the acceleration misses at its start ``(size,)``."""
        n, tableau = self.machine.n, self.tableau
        missed = self.h**2 * (tableau.back @ self.a - before)[:n]
        inside = tableau.kinked if rubs(self.machine.terms) else tableau.inside
        worst = np.abs(missed / self.tolerance).max(initial=0.0)
        if self.shapes is not None:
            worst = max(worst, np.abs(self.shapes @ self._filtered(missed)).max(initial=0.0))
        return float(inside * worst)

    @property
    def grows(self) -> bool:
        """Whether something grows in it by more than e without vibrating: what is below the tolerance would die out."""
        # Then the stiffness is less than minus the mass over the square of its length, where the rows are held. What
        # the material damps is not symmetric where links turn.
        n, machine = self.machine.n, self.machine
        assert self.tangents is not None
        M, _, K = (machine.pattern.dense(x[:1])[0] for x in self.tangents)
        held = K[n : n + machine.held, :n]
        mass, stiffness = M[:n, :n] / self.h**2, K[:n, :n]
        if machine.held:
            free = np.linalg.qr(held.T, mode="complete")[0][:, machine.held :]
            mass, stiffness = free.T @ mass @ free, free.T @ stiffness @ free
        try:
            np.linalg.cholesky(mass + stiffness + (mass + stiffness).T)
        except np.linalg.LinAlgError:
            over = scipy.linalg.eigvals(stiffness, mass)  # what has no mass is infinitely far
            return bool(over[np.isfinite(over)].real.min(initial=0.0) < -1.0)
        return False

    def _filtered(self, missed: Array) -> Array:
        """Take away from changes of coordinates what rows and stiff parts hold back within the step ``(n,)``."""
        # Source: Hairer and Wanner, Solving ODE II, chapter IV.8.
        n, machine = self.machine.n, self.machine
        assert self.tangents is not None
        M, C, K = (x[:1] for x in self.tangents)
        matrix = stage_matrix(radau(1), self.h * self.tableau.lead, M, C, K)
        forces = machine.pattern.times(M, np.append(missed, np.zeros(machine.size - n))[None])[0]
        forces[n:] = 0.0
        factors = Factors(blocks_of(machine.pattern, 1), matrix, f"error at {self.t:.6g} s")
        return np.asarray(factors.solve(forces)[:n])


def now(machine: Machine, t: float, v: Array, a: Array) -> PoseMotion:
    """Give the motion of the poses of the chart at an instant, with rates and accelerations ``(size,)``."""
    return machine.with_rates(machine.known.at(np.array([t])), v[None], a[None])
