"""Linear theories as first steps of Newton's method from the rigid motion, and their error by the step after them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError
from fenics_mech.machine import Evaluation, Machine
from fenics_mech.solve.sparse import blocks_of, solutions
from fenics_mech.solve.statics import stiffness
from fenics_mech.terms import Response

REFINED, REFINEMENTS = 1e-9, 3  # estimated loss from which answers are refined, and how often (Wilkinson, 1963)
HELD = 1e-13  # stiffness of a free motion, of that of the links which it moves: below it, it is rounding


@dataclass(frozen=True)
class Iterate:
    """A motion that is linear beside another.

    Parameters
    ----------
    t
        Instants ``(instants,)`` (s).
    found
        The residual of the motion beside which it is linear.
    change
        What it adds to the coordinates, rates and accelerations ``(instants, size)`` each.
    stresses
        Of every term, by its linearised measures: those of the moved poses would hold squares of the change.
    """

    t: Array
    found: Evaluation
    change: tuple[Array, Array, Array]
    stresses: Sequence[Array]


class StaticIteration:
    """Newton's method for the static answers at some instants, step by step, from the rigid motion.

    Their coordinates have no rates beside the chart. Tangents are those at rest: what inertia changes as sections turn
    is left for the next step.

    Parameters
    ----------
    machine
        The machine; its chart is the rigid motion.
    t
        Instants ``(instants,)`` (s).
    moving
        Whether the inertia of the chart's motion acts, and what goes with its rates.
    stresses
        Those of every term that make the geometric stiffness of the first step; None where no axial forces act.
    free
        Motions that strain nothing ``(size, motions)``, in which the machine accelerates as its loads ask for: it bends
        under the rest, without a part of these motions. None where everything is held.
    """

    found: Evaluation
    lost = 0.0  # share of the first step that rounding may take, and at which instant
    lost_at = 0
    unheld = 0.0  # what accelerates it, as large as the largest part on a coordinate (N, N m)
    values: Array  # of the stiffness with the rows, of which the last step was taken (instants, entries)
    change: tuple[Array, Array, Array]  # of coordinates, rates and accelerations (instants, size)

    def __init__(
        self,
        machine: Machine,
        t: Array,
        moving: bool = True,
        stresses: Sequence[Array] | None = None,
        free: Array | None = None,
    ) -> None:
        self.machine, self.t, self.moving, self.stresses = machine, t, moving, stresses
        self.free, self.begun = free, False
        self.q, self.a = np.zeros((2, len(t), machine.size))
        self.unit = machine.units
        self.share = 1.0  # of the loads and of gravity that acts

    def step(self) -> float:
        """Take a step, and give the size of its change."""
        machine, n, zero = self.machine, self.machine.n, np.zeros_like(self.q)
        t, q, a, loads = self.t, self.q, self.a, self.share
        self.found = machine.residual(t, q, zero, a, loads=loads, moving=self.moving, tangents=False)
        if not self.begun:  # the chart meets the rows but for rounding, which is no deflection
            self.found.force[:, n:] = 0.0
        if linear := self.stresses is None:  # it has no axial forces that weight would be in equilibrium with
            self.stresses = stiffening_stresses(machine, self.found)
        held = machine.residual(t, q, zero, a, predicted=self.stresses, loads=loads, moving=False, turning=not linear)
        self.values = stiffness(machine, held)
        if self.free is None or (not self.moving and self._holds()):
            blocks = blocks_of(machine.pattern, 1)
            x = solutions(blocks, self.values[..., None, None], -self.found.force, "the static answer")
            accelerated = np.zeros_like(x)
            if not self.begun:
                self._estimate_loss(np.where(np.arange(machine.size) < n, x, 0.0))
            if linear and not self.begun and self.lost > REFINED:
                for _ in range(REFINEMENTS):
                    left = self.found.force + self._resisted(held, x)
                    x -= solutions(blocks, self.values[..., None, None], left, "the static answer")
        else:
            x, accelerated = self._relieved(held)
        dq = np.where(np.arange(machine.size) < n, x, 0.0)
        da = np.where(np.arange(machine.size) < n, accelerated, x)
        self.begun = True
        self.change = dq, zero, da
        self.stresses = machine.predicted(held, *self.change)
        self.q, self.a = self.q + dq, self.a + da
        most = np.abs(self.q / self.unit).max(initial=0.0)
        return float(np.abs(dq / self.unit).max(initial=0.0) / max(most, 1.0))

    def _holds(self) -> bool:
        """Say whether forces that are there, such as weight, hold the free motions at rest."""
        assert self.free is not None
        return bool(stiffness_along(self.machine.pattern.dense(self.values[0]), self.free)[0].min() > HELD)

    def _relieved(self, held: Evaluation) -> tuple[Array, Array]:
        """Give a step and accelerations ``(instants, size)``, where the machine accelerates in its free motions."""
        # These are made anew at each step by inverse iteration, as what the joints let move turns with the
        # coordinates.
        machine, n, size = self.machine, self.machine.n, self.machine.size
        assert self.free is not None
        count, none = self.free.shape[1], [0 * stress for stress in self.stresses or ()]
        zero = np.zeros_like(self.q)
        straight = machine.residual(self.t, self.q, zero, zero, predicted=none, moving=False, turning=False)
        steps, accelerations = np.zeros((2, *self.q.shape))
        for k in range(len(self.t)):
            K, K0, M = (machine.pattern.dense(x[k]) for x in (self.values, stiffness(machine, straight), held.M))
            M[:, n:] = M[n:] = 0.0
            free = self.free
            for _ in range(2):
                free = np.linalg.solve(_bordered(K0, M @ free), np.pad(np.eye(count), ((size, 0), (0, 0))))[:size]
                free[n:] = 0.0
            beside = free.T @ M @ self.q[k]
            x = np.linalg.solve(_bordered(K, M @ free), np.append(-self.found.force[k], -beside))
            steps[k], accelerations[k] = x[:size], free @ x[size:]
            self.unheld = float(np.abs(M @ accelerations[k]).max(initial=0.0))
        self.border = M @ free
        return steps, accelerations

    def _resisted(self, held: Evaluation, x: Array) -> Array:
        """Multiply the stiffness by a step, beams by the strain of each: sums of their entries lose small strains."""
        machine, k = self.machine, self.machine.terms.index(self.machine.beams)
        group, here, n = machine.groups[k], held.terms[k], machine.n
        dq, by_strain = np.where(np.arange(machine.size) < n, x, 0.0), here.response.by_measure
        assert by_strain is not None
        strain = np.einsum("temn,ten->tem", here.gradient, group.variables(dq))
        force, (M, C, K) = np.zeros_like(x), np.zeros((3, *self.values.shape))
        stress, none = np.einsum("temk,tek->tem", by_strain, strain), np.zeros_like(strain)
        group.spread(replace(here, response=Response(stress)), None, machine.pattern, False, (force, M, C, K))
        alone = replace(here, response=Response(none, by_strain))
        group.spread(alone, None, machine.pattern, True, (np.zeros_like(x), M, C, K))
        return np.asarray(force + machine.pattern.times(self.values - K, x))

    def _estimate_loss(self, dq: Array) -> None:
        """Estimate the share that rounding takes: eps |q| |K| |q| over q K q (Skeel, J. ACM 26, 1979)."""
        n, pattern = self.machine.n, self.machine.pattern
        size, stiff = np.abs(dq), np.where(pattern.indices < n, np.abs(self.values), 0.0)
        rounded = np.finfo(float).eps * np.sum(size * pattern.times(stiff, size), axis=1)
        energy = np.abs(np.sum(dq[:, :n] * self.found.force[:, :n], axis=1))
        lost = np.divide(rounded, energy, out=np.zeros_like(energy), where=energy > 0)
        self.lost_at = int(lost.argmax())
        self.lost = float(lost[self.lost_at])

    def shorten(self, longest: float) -> None:
        """Go back on the last step, to where no coordinate has changed by more (m, rad)."""
        dq, _, da = self.change
        left = 1 - min(1.0, longest / max(np.abs(dq).max(initial=0.0), longest))
        self.q, self.a = self.q - left * dq, self.a - left * da

    def rest(self) -> None:
        """Stay where it begins: at the rigid motion, which no loads bend."""

    def refuse_beyond(self, reached: float) -> None:
        """Raise `SolverError` where the answer is beyond a load that buckles it; `reached` is below that load."""
        if self.yielding.any():
            raise SolverError(
                f"the static answer buckles between {reached:.3g} and {self.share:.3g} of the load. "
                "Lower the loads, or take stiffer members"
            )

    @property
    def yielding(self) -> Array:
        """Independent ways in which every answer gives way to a push, ``(instants,)``: none, where it is stable."""
        # A stiffness that is positive along the rows has as many negative eigenvalues with them as there are rows.
        machine, found = self.machine, []
        for value in self.values:
            matrix, held = machine.pattern.matrix(value).toarray(), machine.held
            if self.free is not None and self.moving:
                matrix, held = _bordered(matrix, self.border), held + self.border.shape[1]
            scale = 1 / np.sqrt(np.abs(matrix).max(axis=1, initial=0.0))
            both = scale[:, None] * (matrix + matrix.T) / 2 * scale
            found.append(int((np.linalg.eigvalsh(both) < -np.finfo(float).eps * len(both)).sum()) - held)
        return np.maximum(found, 0)

    @property
    def iterate(self) -> Iterate:
        """The last step."""
        assert self.stresses is not None
        return Iterate(self.t, self.found, self.change, self.stresses)


def stiffness_along(K: Array, motions: Array) -> tuple[Array, Array]:
    """Give the stiffness along motions, as a share of that of what they move, and the motions that have it."""
    # K (size, size); motions (size, motions)
    held, size = motions.T @ K @ motions, np.abs(motions).T @ np.abs(K) @ np.abs(motions)
    units = 1 / np.sqrt(np.maximum(np.diag(size), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh((held + held.T) / 2 * units * units[:, None])
    return values, motions @ (units[:, None] * vectors)


def _bordered(matrix: Array, border: Array) -> Array:
    """Give a matrix with further rows and columns ``(size, motions)``."""
    count = border.shape[1]
    return np.block([[matrix, border], [border.T, np.zeros((count, count))]])


def quasi_static(machine: Machine, t: Array, moving: bool = True, free: Array | None = None) -> Iterate:
    """Give the static answer to the inertia of the chart's motion and to the loads, with the stiffness at its places.

    Parameters
    ----------
    machine
        The machine; its chart is the rigid motion.
    t
        Instants ``(instants,)`` (s).
    moving
        Whether that inertia acts.
    free
        As of `StaticIteration`.
    """
    iteration = StaticIteration(machine, t, moving, free=free)
    iteration.step()
    return iteration.iterate


def stiffening_stresses(machine: Machine, found: Evaluation, static: Sequence[Array] | None = None) -> list[Array]:
    """Give the stresses that stiffen in a linear theory: of beams the axial forces, of most others the present ones.

    Parameters
    ----------
    machine
        The machine.
    found
        Its residual in the rigid motion.
    static
        Stresses of every term in the static answer; None where axial forces do not act.
    """
    given = [None] * len(machine.terms) if static is None else static
    parts = zip(machine.terms, found.terms, given)
    return [term.stiffening(here.response.stress, stress) for term, here, stress in parts]


def axial_forces(machine: Machine, iterate: Iterate) -> list[Array]:
    """Give the stresses that stiffen in a linear theory: of beams the axial forces, of others the present ones.

    Parameters
    ----------
    machine
        The machine.
    iterate
        Where the axial forces are from: the static answer.
    """
    return stiffening_stresses(machine, iterate.found, iterate.stresses)
