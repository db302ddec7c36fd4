"""A machine of rigid links as one of its freedoms: rows lead these, and all links follow.

With the gradients J of all rows, the links go with the freedoms' values r by W = J^-1 E. The multipliers l of all rows
balance the machine, F + G l = 0. Those of the freedoms' rows are what would hold the freedoms, so that they are 0:

    left = -l,  d left = E^T G^-1 (M da + C dv + K dq),  dq = W dr,  dv = W dr' + W' dr,
    da = W dr'' + 2 W' dr' + W'' dr.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np

from fenics_mech._arrays import Array, Index, solved
from fenics_mech.errors import SolverError
from fenics_mech.geometry import PoseMotion
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.groups import Group, InertiaPlan, Moved
from fenics_mech.machine.machine import Machine
from fenics_mech.machine.measured import Measured
from fenics_mech.machine.pattern import Pattern
from fenics_mech.terms import rubs

CLOSED, CLOSINGS = 1e-9, 20  # of Newton's method for the links (m, rad), whose next step squares that, and its steps
EXACT = 1e-13  # the same (m, rad), where derivatives of before are those of now
LONGEST = 0.5  # rad in one of them
BALANCED, BALANCES = 1e-12, 30  # of the multipliers, or of inertia, where they press bodies that rub, and steps
APART = 1e-4  # of a radian or of the extent, by which J' is differentiated along the motion


class StrayedError(SolverError):
    """The links do not follow, or go on in another way: the freedoms' rows hardly lead them."""

    def __init__(self, t: float) -> None:
        super().__init__(f"the links do not follow the freedoms at {t:.6g} s")
        self.t = t


class Driven(NamedTuple):
    """What laws of drives demand: rates of the rows' values, and second rates ``(instants, rows)``."""

    first: Array
    second: Array


@dataclass(frozen=True)
class Carried:
    """Coordinates, rates and accelerations of all links, with the gradients of all rows."""

    t: Array  # instants (instants,) (s), and values of the freedoms' rows and second rates (instants, freedoms)
    r: Array
    a: Array
    Q: Array  # of the links (instants, n)
    V: Array
    A: Array
    J: Array  # gradients of the rows, and their rates (instants, rows, n)
    J1: Array

    @classmethod
    def joined(cls, parts: Sequence[Carried]) -> Carried:
        """Put motions one after the other."""
        return cls(*(np.concatenate([getattr(x, one.name) for x in parts]) for one in fields(cls)))

    def part(self, instants: Index | slice) -> Carried:
        """Give some instants."""
        return Carried(*(getattr(self, one.name)[instants] for one in fields(self)))

    def last(self) -> Carried:
        """Give the last instant alone."""
        return self.part(slice(-1, None))

    def resting(self) -> Carried:
        """Give the links at rest."""
        return replace(self, a=0 * self.a, V=0 * self.V, A=0 * self.A, J1=0 * self.J1)

    def predicted(self, t: Array) -> tuple[Array, Index]:
        """Give coordinates to which its nearest instants lead at others, and the numbers of these."""
        k = np.abs(t[:, None] - self.t).argmin(axis=1)
        dt = (t - self.t[k])[:, None]
        return self.Q[k] + dt * self.V[k] + dt**2 / 2 * self.A[k], k


@dataclass(frozen=True)
class Balanced:
    """What holds a motion: the residual beside it, all multipliers, and the inverse of its derivatives by these."""

    found: Evaluation  # the residual at multipliers of before
    pulls: Array  # multipliers that balance it to first order, and what that changed (instants, rows)
    change: Array
    back: Array  # the inverse (instants, rows, rows)

    def settled(self, machine: Machine, change: Array) -> bool:
        """Say whether a change of forces is rounding of the largest force of a row, of inertia or of a term."""
        inertia = machine.inertia.largest(self.found.at)
        stresses = [np.abs(term.response.stress).max(initial=0.0) for term in self.found.terms]
        return bool(np.abs(change).max() <= BALANCED * max(np.abs(self.pulls).max(), inertia, *stresses))


def reacted(
    machine: Machine,
    t: Array,
    motion: tuple[Array, Array, Array],
    pulls: Array,
    *,
    predicted: Sequence[Array] | None = None,
    angles: Sequence[Array] | None = None,
    moving: bool = True,
) -> Balanced:
    """Make a step of Newton's method for the multipliers; arguments as of `balanced`."""
    n = machine.n
    q, v, a = (np.concatenate([x, y], axis=1) for x, y in zip(motion, (0 * pulls, 0 * pulls, pulls)))
    found = machine.residual(t, q, v, a, predicted=predicted, angles=angles, moving=moving)
    back = np.linalg.inv(machine.pattern.dense(found.M)[:, :n, n:])
    change = -(back @ found.force[:, :n, None])[..., 0]
    return Balanced(found, pulls + change, change, back)


def balanced(
    machine: Machine,
    t: Array,
    motion: tuple[Array, Array, Array],
    *,
    pulls: Array | None = None,
    angles: Sequence[Array] | None = None,
    moving: bool = True,
) -> Balanced:
    """Find the multipliers that balance all forces in a motion that rows lead."""
    # motion (instants, n); pulls (instants, rows)
    n, known = machine.n, pulls is not None
    if machine.size != 2 * n:
        raise ValueError(f"{machine.size - n} rows do not hold {n} coordinates")
    pulls = np.zeros((len(t), n)) if pulls is None else pulls
    for k in range(BALANCES):
        held = reacted(machine, t, motion, pulls, angles=angles, moving=moving)
        pulls = held.pulls
        if not rubs(machine.terms) and (known or k):  # linear in them: geometric stiffness alone takes those of before
            return held
        if rubs(machine.terms) and held.settled(machine, held.change):
            return held
    raise SolverError("the friction of the joints locks the linkage: their forces are not determined")


class Freed:
    """A machine of rigid links whose coordinates are the values of some rows beside `place`."""

    # It is a machine to what solves equations of motion: residual, tangents and terms.

    rows: tuple[()] = ()
    held = 0

    def __init__(
        self,
        machine: Machine,
        own: Sequence[int],
        driven: Callable[[Array], Driven],
        place: Array,
        t: float,
        near: Array,
    ) -> None:
        # place (freedoms,); t, near (n,) (s)
        self.machine, self.own, self.driven, self.place = machine, np.array(own, dtype=int), driven, place
        self.n = self.size = len(self.own)
        self.terms, self.geometry, self.extent = machine.terms, machine.geometry, machine.extent
        self.pattern = Pattern.of(self.n, [np.arange(self.n, dtype=np.int32)[None]])
        self._turns = np.isin(np.arange(machine.n), machine.places[:, machine.geometry.d :])
        self._drawn = machine.angles_as_drawn()
        self.side = 0.0
        self.pulls: Array | None = None  # multipliers at the end of the last step ``(1, rows)``
        self._held: Balanced  # and those of Newton's method
        still = np.zeros((1, self.n))
        zero, none = np.zeros((1, machine.n)), np.zeros((1, 0, 0))
        self._here = self.stages = Carried(np.array([t]), place[None], still, near[None], zero, zero, none, none)
        self._here = self.stages = self.carried(self._here.t, place[None], still, still)

    @property
    def groups(self) -> list[Group]:
        """Elements of every term, where they lie."""
        return self.machine.groups

    def rebase(self, q: Array, v: Array, a: Array) -> tuple[Array, Array]:
        """Move on to other values, beside which all others then are."""
        self.place = self.place + q
        self._here = self.stages = self.stages.last()
        self.pulls = self._held.pulls[-1:]
        return v, a

    def go_back(self, known: Carried) -> None:
        """Take links as those that others are near to."""
        self._here = self.stages = known

    def turned(self, angles: Sequence[Array] | None, q: Array) -> None:
        """Give no angles: it knows those of its terms, as it knows the way of every link from the start."""

    @property
    def inertia(self) -> InertiaPlan:
        """The constant mass."""
        return self.machine.inertia

    # ---- how links follow ----
    def _looked(self, t: Array, value: Array, Q: Array) -> Measured:
        """Measure the rows, whose angles are near to their values."""
        return self.machine.row_group.measure(self.machine.placed(t, Q), value[..., None])

    def _moving(self, found: Measured, V: Array) -> Measured:
        return replace(found, ways=self.machine.row_group.variables(V))

    def carried(self, t: Array, r: Array, v: Array, a: Array, near: Array | None = None) -> Carried:
        """Find the links by the freedoms' rows, their rates and second rates ``(instants, freedoms)`` each."""
        # near (instants, n)
        machine, demanded = self.machine, self.driven(t)
        given = [row.at(t) for row in machine.rows]
        value, first, second = np.stack(given, axis=1), demanded.first.copy(), demanded.second.copy()
        value[:, self.own], first[:, self.own], second[:, self.own] = r, v, a
        Q = self._guess(t, r) if near is None else near
        turns = self._turns
        for _ in range(CLOSINGS):
            found = self._looked(t, value, Q)
            J = self.machine.rows_by_coordinates(found.gradient)
            try:
                change = solved(J, found.x[..., 0] - value)
            except np.linalg.LinAlgError as error:
                raise self._strayed(t[0]) from error
            most = np.abs(change[:, turns]).max(axis=1, initial=0.0)
            Q = Q - change * np.minimum(1.0, LONGEST / np.maximum(most, LONGEST))[:, None]
            if np.abs(change).max(initial=0.0) < CLOSED:
                break
        else:
            raise self._strayed(t[int(np.abs(change).max(axis=1).argmax())])
        if np.abs(change).max(initial=0.0) > EXACT:
            found = self._looked(t, value, Q)
            J = self.machine.rows_by_coordinates(found.gradient)
        back = np.linalg.inv(J)
        V = (back @ first[..., None])[..., 0]
        rates = self._moving(found, V)
        by_rate = rates.rate_by_variables
        convective = np.einsum("tran,trn->tr", by_rate, rates.ways)
        A = (back @ (second - convective)[..., None])[..., 0]
        sides = np.linalg.slogdet(J)[0]
        self.side = self.side or float(sides[0])
        if (sides != self.side).any():
            raise self._strayed(t[int((sides != self.side).argmax())])
        return Carried(t, r, a, Q, V, A, J, self.machine.rows_by_coordinates(by_rate))

    def _guess(self, t: Array, r: Array) -> Array:
        """Give coordinates near to those at some instants, by what was found last."""
        known = self.stages if len(self.stages.t) > 1 or len(t) == 1 else self._here
        Q, k = known.predicted(t)
        if not known.J.size:
            return Q
        dt, J = (t - known.t[k])[:, None], known.J[k]
        rate = (J @ known.V[k][..., None])[:, self.own, 0]
        led = known.r[k] + dt * rate + dt**2 / 2 * known.a[k]
        return Q + solved(J, self._on_rows(r - led))

    def _on_rows(self, values: Array) -> Array:
        found = np.zeros((len(values), self.machine.n))
        found[:, self.own] = values
        return found

    def _strayed(self, t: float) -> StrayedError:
        self.stages = self._here
        return StrayedError(float(t))

    def _ways(self, known: Carried) -> tuple[Array, Array, Array]:
        """Give W and two derivatives by time ``(instants, n, freedoms)`` each."""
        back = np.linalg.inv(known.J)
        W = back[:, :, self.own]
        W1 = -back @ (known.J1 @ W)
        fastest = max(np.abs(known.V).max(initial=0.0), np.sqrt(np.abs(known.A).max(initial=0.0)))
        if not fastest:
            return W, W1, 0 * W
        step, value = APART / fastest, np.zeros((len(known.t), len(self.machine.rows)))
        beside = [known.Q + dt * known.V + dt**2 / 2 * known.A for dt in (step, -step)]
        rates = np.concatenate([known.V + dt * known.A for dt in (step, -step)])
        found = self._looked(np.tile(known.t, 2), np.tile(value, (2, 1)), np.concatenate(beside))
        one, other = np.split(self.machine.rows_by_coordinates(self._moving(found, rates).rate_by_variables), 2)
        J2 = (one - other) / (2 * step)
        return W, W1, -back @ (J2 @ W + 2 * known.J1 @ W1)

    def moved(self, t: Array, q: Array, v: Array, a: Array) -> Moved:
        """Move all poses; arguments as of `residual`."""
        known = self.carried(t, self.place + q, v, a)
        size = ((0, 0), (0, self.machine.size - self.machine.n))
        return self.machine.moved(t, *(np.pad(x, size) for x in (known.Q, known.V, known.A)))

    def motion(self, known: Carried) -> PoseMotion:
        """Give the motion of all poses."""
        machine, size = self.machine, ((0, 0), (0, self.machine.size - self.machine.n))
        q, v, a = (np.pad(x, size) for x in (known.Q, known.V, known.A))
        at = machine.moved(known.t, q, v, a)
        return replace(machine.with_rates(machine.known.at(known.t), v, a), r=at.r, R=at.R)

    def angles(self, Q: Array) -> list[Array]:
        """Give the angles near those of every term where the links are, whole turns and all."""
        found = self.machine.turned(self._drawn, Q)
        assert found is not None
        return found

    # ---- the equation ----
    def residual(
        self,
        t: Array,
        q: Array,
        v: Array,
        a: Array,
        *,
        predicted: Sequence[Array] | None = None,
        angles: Sequence[Array] | None = None,
        moving: bool = True,
    ) -> Evaluation:
        """Evaluate the equation of motion of the freedoms."""
        # q, v, a (instants, freedoms)
        known = self.carried(t, self.place + q, v, a)
        self.stages = known = known if moving else known.resting()
        if predicted is not None:
            pulls = self._held.pulls
        elif self.pulls is not None:
            pulls = np.tile(self.pulls, (len(t), 1))
        else:
            pulls = self._balanced(known, moving=moving).pulls
        motion = known.Q, known.V, known.A
        angles = self.angles(known.Q)
        self._held = reacted(self.machine, t, motion, pulls, predicted=predicted, angles=angles, moving=moving)
        return self._condensed(known, self._held)

    def _condensed(self, known: Carried, held: Balanced) -> Evaluation:
        """Give the residual of the freedoms, by that of all coordinates."""
        n, t, (W, W1, W2) = self.machine.n, known.t, self._ways(known)
        M, C, K = (self.machine.pattern.dense(x)[:, :n, :n] for x in (held.found.M, held.found.C, held.found.K))
        self._by = by = M @ W, C @ W + 2 * M @ W1, K @ W + C @ W1 + M @ W2
        self._led = W, W1
        M, C, K = (np.reshape(held.back[:, self.own] @ x, (len(t), -1)) for x in by)
        return replace(held.found, force=-held.pulls[:, self.own], M=M, C=C, K=K, pattern=self.pattern)

    def _balanced(self, known: Carried, pulls: Array | None = None, moving: bool = True) -> Balanced:
        motion, angles = (known.Q, known.V, known.A), self.angles(known.Q)
        return balanced(self.machine, known.t, motion, pulls=pulls, angles=angles, moving=moving)

    def predicted(self, found: Evaluation, dq: Array, dv: Array, da: Array) -> Sequence[Array]:
        """Predict the stresses of all terms after a step of Newton's method, and move the multipliers on."""
        (W, W1), held = self._led, self._held
        given = [x[..., None] for x in (da, dv, dq)]
        pulls = -(held.back @ np.sum([by @ x for by, x in zip(self._by, given)], axis=0))[..., 0]
        dQ, dV = (W @ given[2])[..., 0], (W @ given[1] + W1 @ given[2])[..., 0]
        none = np.zeros_like(dQ)
        whole = (np.concatenate(pair, axis=1) for pair in ((dQ, none), (dV, none), (none, held.change + pulls)))
        self._held = replace(held, pulls=held.pulls + pulls)
        return self.machine.predicted(found, *whole)

    def freely(self, known: Carried, v: Array) -> tuple[Carried, Balanced]:
        """Give a motion with the accelerations that nothing holds, and what acts in it."""
        # v (instants, freedoms)
        machine, n, a = self.machine, self.machine.n, np.zeros_like(v)
        at = self.carried(known.t, known.r, v, a, known.Q)
        W, angles, pulls = np.linalg.inv(at.J)[:, :, self.own], self.angles(at.Q), np.zeros((len(v), n))
        for k in range(BALANCES):
            moved = replace(at, a=a, A=at.A + (W @ a[..., None])[..., 0])
            held = reacted(machine, at.t, (moved.Q, moved.V, moved.A), pulls, angles=angles)
            by_a = -held.back @ machine.pattern.dense(held.found.M)[:, :n, :n] @ W
            da = self.by_mass(-by_a[:, self.own], held.pulls[:, self.own])
            change = (by_a @ da[..., None])[..., 0]
            if k and (not rubs(machine.terms) or held.settled(machine, np.abs(held.change) + np.abs(change))):
                return moved, held
            a, pulls = a + da, held.pulls + change
        raise SolverError(
            f"the friction of the joints leaves no acceleration of the freedoms near {known.t[0]:.6g} s: a pin jams in "
            "motion where its coefficient times its radius exceeds the arm of what it carries. Give a smaller one"
        )

    def by_mass(self, mass: Array, force: Array) -> Array:
        """Give accelerations by the mass of the freedoms ``(instants, freedoms, freedoms)``, and a force."""
        for k in range(self.n):
            if mass[0, k, k] == 0:
                name = self.machine.rows[int(self.own[k])].name
                raise SolverError(f"the freedom at joint {name} moves no mass: give its links mass or inertia")
        return solved(mass, force)

    # ---- as an equation of motion at many states ----
