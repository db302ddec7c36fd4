"""A motion of a machine at some instants, and what is read off it there."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.geometry import End, Given, PoseMotion
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.machine import Machine
from fenics_mech.machine.measured import Measured
from fenics_mech.terms import Term


@dataclass(frozen=True)
class Motion:
    """Coordinates of a machine at some instants, as its residual takes them."""

    machine: Machine  # the machine
    t: Array  # instants (instants,) (s)
    q: Array  # coordinates, rates and accelerations (instants, size); multipliers stand in the last of `a`
    v: Array
    a: Array
    moving: bool = True  # whether the chart moves; else only its places count
    # stresses of every term beside those by its measures; None where there are none
    added: Sequence[Array] | None = None
    # angles near to those of every term, as the residual takes them; None where the terms know
    angles: Sequence[Array] | None = None

    @cached_property
    def found(self) -> Evaluation:
        """The residual, without tangents; the added stresses are those of its terms, and no forces."""
        return self._evaluated(tangents=False)

    def _evaluated(self, tangents: bool) -> Evaluation:
        found = self.machine.residual(
            self.t, self.q, self.v, self.a, moving=self.moving, angles=self.angles, known=True, tangents=tangents
        )
        if self.added is None:
            return found
        stressed = [
            replace(here, response=replace(here.response, stress=here.response.stress + stress))
            for here, stress in zip(found.terms, self.added)
        ]
        return replace(found, terms=stressed)

    @property
    def with_tangents(self) -> Evaluation:
        """The residual with tangents, by the stresses of its measures."""
        return self._evaluated(tangents=True)

    @cached_property
    def chart(self) -> Motion:
        """The motion of the chart."""
        if not (self.q.any() or self.v.any() or self.a[:, : self.machine.n].any()):
            return self
        return Motion(self.machine, self.t, 0 * self.q, 0 * self.v, 0 * self.a, self.moving, angles=self.angles)

    @cached_property
    def poses(self) -> PoseMotion:
        """Places, rotations and their rates of all poses in the plane, where rates of turns add up."""
        moved, at = self.machine.with_rates(self.machine.known.at(self.t), self.v, self.a), self.found.at
        return replace(moved, r=at.r, R=at.R)

    def beside(self, chart: Given) -> Motion:
        """Give the same motion in the plane beside another chart."""
        machine, mine, other = copy(self.machine), self.poses, chart.motion
        machine.chart = chart
        turned = machine.geometry.vector(mine.R @ np.swapaxes(other.R, -1, -2))
        q = coordinates(machine, mine.r - other.r, turned)
        v = coordinates(machine, mine.v - other.v, mine.w - other.w)
        a = coordinates(machine, mine.a - other.a, mine.al - other.al)
        a[:, machine.n :] = self.a[:, machine.n :]
        return Motion(machine, self.t, q, v, a, angles=self.angles)

    def of_term(self, term: Term) -> Measured:
        """Give the measures and stresses of a term."""
        return self.found.terms[self.machine.terms.index(term)]

    def jet(self, term: Term) -> tuple[Array, Array, Array]:
        """Give the measure of a term of one element in the plane, and two derivatives by time ``(instants,)`` each."""
        here, seconds = self.of_term(term), np.concatenate([self.poses.a, self.poses.al], axis=-1)
        group = self.machine.groups[self.machine.terms.index(term)]
        by_seconds = np.einsum("tn,tn->t", here.gradient[:, 0, 0], group.variables_of(seconds)[:, 0])
        by_rates = np.einsum("tn,tn->t", here.rate_by_variables[:, 0, 0], here.ways[:, 0])
        return here.x[:, 0, 0], here.rate[:, 0, 0], by_seconds + by_rates

    def of_end(self, end: End) -> tuple[Array, ...]:
        """Give place (m), velocity and acceleration of an end, ``(instants, d)`` each."""
        at = self.found.at
        place, rate, second = at.r[:, end.pose], at.rates[:, end.pose], at.acc[:, end.pose]
        moved = place + at.R[:, end.pose] @ end.offset
        acceleration = second[:, 0] + self.machine.gravity + end.offset @ second[:, 1:]
        return tuple(map(np.asarray, (moved, rate[:, 0] + end.offset @ rate[:, 1:], acceleration)))

    def axes(self, end: End) -> Array:
        """Give the axes of an end ``(instants, d, d)``."""
        return np.asarray(self.found.at.R[:, end.pose] @ end.turn)


def coordinates(machine: Machine, places: Array, turns: Array) -> Array:
    """Give the coordinates, or their rates, by those of all poses ``(instants, poses, d)`` and ``(..., turns)``."""
    found, there = np.zeros((len(places), machine.size)), machine.places >= 0
    found[:, machine.places[there]] = np.concatenate([places, turns], axis=-1)[:, there]
    return found


# of the machine's extent, or rad, of a change, by which differences are taken: at rest, and where rates are
ROUNDED, VIBRATING = 1e-5, 1e-4
MOST, MOST_OF_RATES = 1e6, 0.5  # of a change at rest, and of one that vibrates, which are taken for it


@dataclass(frozen=True)
class LinearMotion:
    """A motion that is linear beside another: a step of Newton's method."""

    # What is read off it is the derivative of what is read off exact motions, so every quantity is linear in the
    # change.

    base: Motion  # the motion beside which it is linear
    change: tuple[Array, Array, Array]  # what it adds to the coordinates, rates and accelerations (instants, size) each
    # stresses of every term that act as the change turns them; None for those of the base
    stiffening: Sequence[Array] | None = None
    moving: bool = True  # whether the change feels the chart's motion
    # of every term, by its linearised measures, where nothing else of the change acts; None where more does
    stresses: Sequence[Array] | None = None

    @property
    def acting(self) -> Motion | None:
        """What the change exerts at the places of the base, where nothing else of it acts; None where more does."""
        if self.stresses is None:
            return None
        base, (_, _, a) = self.base, self.change
        at_rest = replace(base, moving=False).found.terms  # as the change is: what rates exert is that of the base
        added = [stress - here.response.stress for stress, here in zip(self.stresses, at_rest)]
        return replace(base, a=base.a + a, added=added)

    @cached_property
    def step(self) -> float:
        """Share of the change by which differences are taken: their squares, and rounding over them, are small."""
        dq, dv, _ = self.change
        reach, most = (VIBRATING, MOST_OF_RATES) if dv.any() else (ROUNDED, MOST)
        return reach / max(float(np.abs(dq / self.base.machine.units).max(initial=0.0)), reach / most)

    def beside(self, share: float) -> Motion:
        """Give the exact motion by a share of the change; the stiffening stresses give way to those by its measures."""
        base, added = self.base, None
        if self.stiffening is None and share == 0.0:
            return base
        if self.stiffening is not None:
            present = (here.response.stress for here in base.found.terms)
            added = [(1 - share) * (stress - own) for stress, own in zip(self.stiffening, present)]
        q, v, a = (x + share * change for x, change in zip((base.q, base.v, base.a), self.change))
        return Motion(base.machine, base.t, q, v, a, base.moving and (self.moving or share in (0, 1)), added)
