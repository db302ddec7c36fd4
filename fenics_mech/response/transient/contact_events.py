"""Where contacts of a motion open and close: steps end there, so that no step runs over a kink of its equation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Protocol

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.joints.joint_state import JointLaw, Touching
from fenics_mech.joints.link_states import LinkStates
from fenics_mech.response.transient.course import ContactCount
from fenics_mech.response.transient.stepping import Curve


@dataclass(frozen=True)
class EventLimits:
    """Limits of the search for contacts in a step."""

    nodes: int = 13  # at which a step is looked at
    between: int = 5  # points between two nodes, on cubics
    at_end: float = 1e-7  # of a step, before whose end an event counts as there, and after its start
    found: float = 1e-13  # of a step, to which its time is found


EVENT = EventLimits()


class TouchingState(Protocol):
    """An equation of motion whose joints may touch; it knows which contacts are closed."""

    contacts: dict[str, Touching]

    @property
    def laws(self) -> dict[str, JointLaw]:
        """The joint laws, by name."""

    def joint_links(self, time: Array, place: Array, rate: Array) -> LinkStates:
        """Give the bodies that the laws act on, at coordinates and their rates, ``(times, coordinates)`` each."""


@dataclass
class ContactEvents:
    """Watches the contacts of a motion.

    Parameters
    ----------
    state
        The equation, which knows which contacts are closed.
    """

    state: TouchingState
    laws: dict[str, JointLaw] = field(init=False)
    count: ContactCount = field(default_factory=ContactCount, init=False)  # of what closed and opened so far
    _due: tuple[float, str, int] | None = field(default=None, init=False)  # time (s), law and contact of an event

    def __post_init__(self) -> None:
        """Look at the laws that have contacts."""
        self.laws = {name: law for name, law in self.state.laws.items() if law.contacts}

    def depths(self, time: Array, place: Array, rate: Array) -> dict[str, tuple[Array, Array]]:
        """Indentation and its rate by law, ``(contacts, times)`` each.

        Parameters
        ----------
        time
            Times (s), ``(times,)``.
        place, rate
            Coordinates of the motion, and their rates, ``(times, coordinates)`` each.
        """
        links = self.state.joint_links(time, place, rate)
        return {name: law.depths(law.joint.state(links)) for name, law in self.laws.items()}

    def begin(self, time: float, place: Array, rate: Array) -> None:
        """Close the contacts that may be closed at the start; raise `SceneError` where another one is.

        Parameters
        ----------
        time
            Of the start (s).
        place, rate
            Coordinates of the motion there, and their rates, ``(coordinates,)`` each.
        """
        if not self.laws:
            return
        for name, (depth, _) in self.depths(np.array([time]), place[None], rate[None]).items():
            if not self.laws[name].begins_open:
                self.state.contacts[name] = Touching(depth[:, 0] > 0, np.ones(len(depth)))
            elif depth.max() > 0:
                raise SceneError(
                    f"at the start the bodies of joint {self.laws[name].joint.name!r} overlap by {depth.max():.3g}",
                    place=f"joint_laws.{name}",
                    hint="Start from another place, where they do not touch",
                )

    def next_event(self, start: float, end: float, curve: Curve) -> float | None:
        """Give the time (s) of the first event in a step; None where there is none before its end.

        Parameters
        ----------
        start, end
            Of the step (s).
        curve
            Coordinates of the motion over time, and their rates.
        """
        before, self._due = self._due, None
        if not self.laws:
            return None
        times, early = np.linspace(start, end, EVENT.nodes), start + EVENT.at_end * (end - start)
        depths, found = self.depths(times, *curve(times)), []
        for name, contact, sign in self._signed():
            depth, rate = (sign * part[contact] for part in depths[name])
            fine, values = _between_nodes(times, depth, rate)
            crossed = np.flatnonzero((values[1:] > 0) & (values[:-1] <= 0))
            if len(crossed):
                bracket = fine[crossed[0]], fine[crossed[0] + 1]
                time = self._crossing(curve, bracket, (name, contact, sign))
                known = before is not None and before[1:] == (name, contact)  # for which the step was cut short already
                if time is not None and not (known and time <= early):
                    found.append((max(time, early), name, contact))  # at the start itself a step would have no length
        if not found:
            if before is not None and abs(end - before[0]) <= EVENT.at_end * (end - start):  # the step was cut there
                self._due = end, *before[1:]
            return None
        self._due = min(found)
        if self._due[0] >= end - EVENT.at_end * (end - start):
            self._due = end, *self._due[1:]
            return None
        return self._due[0]

    def _signed(self) -> Iterator[tuple[str, int, float]]:
        """Each law and contact, with the sign of an indentation that is an event."""
        for name, law in self.laws.items():
            for contact in range(law.contacts):
                yield name, contact, -1.0 if self.state.contacts[name].closed[contact] else 1.0

    def _crossing(self, curve: Curve, bracket: tuple[float, float], which: tuple[str, int, float]) -> float | None:
        """Time at which a contact opens or closes; None where it only comes near."""
        name, contact, sign = which

        @cache  # near 0 rounding gives a second sign to the same time, as poses begin from the last one
        def depth(time: float) -> float:
            at = np.array([time])
            return float(sign * self.depths(at, *curve(at))[name][0][contact, 0])

        ends = depth(bracket[0]), depth(bracket[1])
        if ends[0] > 0 or ends[1] <= 0:
            return None
        from scipy.optimize import brentq  # noqa: PLC0415  (slow to import, and few scenes have contacts)

        return float(brentq(depth, *bracket, xtol=EVENT.found * (bracket[1] - bracket[0]) + 1e-300, rtol=1e-15))

    def settle(self, time: float, place: Array, rate: Array) -> None:
        """Open and close contacts at the end of a step.

        Parameters
        ----------
        time
            Time (s).
        place, rate
            Coordinates of the motion there, and their rates, ``(coordinates,)`` each.
        """
        if not self.laws:
            return
        depths = self.depths(np.array([time]), place[None], rate[None])
        for name, contact, sign in list(self._signed()):
            depth, speed = (float(part[contact, 0]) for part in depths[name])
            due = self._due is not None and self._due[1:] == (name, contact)  # in the step that ends here
            if (due or sign * depth > 0) and sign * speed > 0:
                known = self.state.contacts[name]
                closed, speeds = known.closed.copy(), known.speed.copy()
                closed[contact] = sign > 0
                if sign > 0:
                    speeds[contact] = speed
                self.count = ContactCount(self.count.closed + int(sign > 0), self.count.opened + int(sign < 0))
                self.state.contacts[name] = replace(known, closed=closed, speed=speeds)
        self._due = None


def _between_nodes(times: Array, values: Array, rates: Array) -> tuple[Array, Array]:
    """Times and values on cubics between nodes, ``(points,)`` each, with the nodes."""
    share = np.arange(EVENT.between + 1) / (EVENT.between + 1)
    step = np.diff(times)[:, None]
    first, second = values[:-1, None], values[1:, None]
    slope, bend = step * rates[:-1, None], step * rates[1:, None]
    back = 1 - share
    fine = back**2 * (1 + 2 * share) * first + share**2 * (3 - 2 * share) * second
    fine += back**2 * share * slope - share**2 * back * bend
    places = times[:-1, None] + share * step
    return np.append(places.ravel(), times[-1]), np.append(fine.ravel(), values[-1])
