"""Contacts in a motion in time: steps end where they close and open, so that none runs over a kink of its equation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.joints.law_terms import LawTerm
from fenics_mech.machine import Machine
from fenics_mech.solve.step import Step

NODES, BETWEEN = 13, 5  # shares of a step at which it is looked at, and points between two of them, on cubics
AT_END = 1e-7  # of a step, within whose end an event is there
ROUNDING = 1e-15  # of the extent or of 1 rad: places that rows hold
FOUND = 1e-13  # of a step, to which an event is found on its polynomial


class Event(NamedTuple):
    """A contact that closes or opens: the number of its term, its own number, and the share of the step."""

    term: int
    contact: int
    share: float


class Contacts:
    """All contacts of a machine in a march."""

    def __init__(self, machine: Machine, share: float) -> None:
        self.machine, self.share = machine, share
        self.terms = [k for k, term in enumerate(machine.terms) if isinstance(term, LawTerm) and term.contacts]

    def begin(self, t: float, v: Array, angles: Sequence[Array] | None = None) -> None:
        """State which contacts are closed at the start, by an instant (s) and the rates there ``(size,)``."""
        zero, at = np.zeros((1, self.machine.size)), np.array([t])
        for k in self.terms:
            term = self._term(k)
            near = term.near(at) if angles is None else angles[k]
            found = self.machine.groups[k].measure(self.machine.moved(at, zero, v[None], zero), near)
            term.begin(term.depths(found.x, found.rate)[0][:, 0])

    def up_to_event(self, step: Step) -> tuple[Step, Event | None]:
        """Give a step, or the part of it up to its first event, and that event."""
        due = None
        while (event := self._first(step)) is not None and event.share < 1 - AT_END:
            due, shares = event, event.share * step.tableau.c
            step = replace(step, h=event.share * step.h, a=step.at(shares)[2]).solved()
        return step, event or due

    def pass_event(self, step: Step, event: Event) -> None:
        """Close or open the contact of an event at the end of a step, and all others that come to theirs with it."""
        for k in self.terms:
            term, (depths, rates) = self._term(k), self._depths(k, step, np.ones(1))
            signs = np.where(term.closed, -1.0, 1.0)
            away, speeds = signs * depths[:, 0], signs * rates[:, 0]
            due = (speeds > 0) & (away > -AT_END * step.h * speeds)
            due[event.contact] |= k == event.term
            for contact in np.flatnonzero(due):
                term.change(step.t + step.h, int(contact), float(rates[contact, 0]))

    def error(self, step: Step, before: Array) -> float:
        """Bound the errors of rates of indentation over what they may be, by the starting acceleration ``(size,)``."""
        # What it misses there is a rate for the time of the step. In a short one that is rounding of places.
        missed, worst = step.tableau.back @ step.a - before, 0.0
        missed[self.machine.n :] = 0.0
        start, led = replace(step, v=missed), replace(step, v=0 * missed)
        for k in self.terms:
            term = self._term(k)
            if term.closed.any():
                at, rest = (self._depths(k, one, np.zeros(1))[1][:, 0] for one in (start, led))
                rates = at - rest
                allowed = self.share * term.speed + ROUNDING * max(self.machine.extent, 1.0) / step.h
                worst = max(worst, float(np.abs(rates / allowed)[term.closed].max()))
        return step.tableau.inside_rate * step.h * worst

    def _term(self, k: int) -> LawTerm:
        term = self.machine.terms[k]
        assert isinstance(term, LawTerm)
        return term

    def _depths(self, k: int, step: Step, shares: Array) -> tuple[Array, Array]:
        """Give indentations of a term and their rates at shares of a step ``(contacts, shares)`` each."""
        found = step.measured(k, shares)
        return self._term(k).depths(found.x, found.rate)

    def _first(self, step: Step) -> Event | None:
        """Give the first event in a step: an indentation that comes above 0 where the contact is open, or below."""
        shares, found = np.linspace(0, 1, NODES), []
        for k in self.terms:
            depths, rates = self._depths(k, step, shares)
            for contact, closed in enumerate(self._term(k).closed):
                sign = -1.0 if closed else 1.0
                fine, values = _between(shares, sign * depths[contact], sign * step.h * rates[contact])
                for i in np.flatnonzero((values[1:] > 0) & (values[:-1] <= 0)):
                    share = self._crossing(step, k, contact, sign, (float(fine[i]), float(fine[i + 1])))
                    if share is not None:
                        found.append(Event(k, contact, share))
                        break
        return min(found, key=lambda event: event.share, default=None)

    def _crossing(self, step: Step, k: int, contact: int, sign: float, bracket: tuple[float, float]) -> float | None:
        """Give the share of a step at which an indentation changes its sign; None where it only comes near."""
        from scipy.optimize import brentq  # noqa: PLC0415  (slow to import, and few scenes have contacts)

        def depth(share: float) -> float:
            return sign * float(self._depths(k, step, np.array([share]))[0][contact, 0])

        if depth(bracket[0]) > 0 or depth(bracket[1]) <= 0:
            return None
        return float(brentq(depth, *bracket, xtol=FOUND))


def _between(shares: Array, values: Array, slopes: Array) -> tuple[Array, Array]:
    """Give shares and values on cubics between nodes, with the nodes ``(points,)`` each."""
    x = np.arange(BETWEEN + 1) / (BETWEEN + 1)
    step, back = np.diff(shares)[:, None], 1 - x
    one, other = values[:-1, None], values[1:, None]
    fine = back**2 * (1 + 2 * x) * one + x**2 * (3 - 2 * x) * other
    fine += step * x * back * (back * slopes[:-1, None] - x * slopes[1:, None])
    return np.append((shares[:-1, None] + x * step).ravel(), 1.0), np.append(fine.ravel(), values[-1])
