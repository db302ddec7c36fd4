"""Where dry friction holds a linkage of rigid links that has one freedom.

At rest the friction F of a joint is any up to its limit, ``|F| <= m |l|``: m is its coefficient, times the radius of a
pin, and l the joint's force. Just before the freedom slips all joints that move with it are at their limits, each
against the motion. So all take one share s of their limits, and friction holds where ``|s| <= 1``.
Source: Coulomb's law at rest; Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 5.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError
from fenics_mech.joints.dry_friction import coefficient
from fenics_mech.joints.friction_balance import FrictionBalance
from fenics_mech.joints.rubbing import Rubbing
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.freed import Carried, Freed, StrayedError
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.scene import Friction, Prismatic, Slot
from fenics_mech.terms import Response


@dataclass(frozen=True)
class HoldLimits:
    """How far, and in which steps, places that friction holds are looked for."""

    first: float = 1e-4  # rad, or of the linkage's size: first step; what holds less far is bisected out of one
    growth: float = 1.2  # of each step over the last
    longest: float = 0.05  # rad: friction changes with the sine of angles
    turns: float = 4 * math.pi  # rad: what holds over two turns holds at all angles
    strokes: float = 1e3  # of the linkage's size: what holds so far holds at all strokes
    shortest: float = 1e-9  # of the first step, up to which the end of the linkage's reach is approached
    halvings: int = 60  # of a step: to the last digit
    moves: float = 1e-12  # rad or m, by a freedom of 1 rad or 1 m, from which on a joint moves with it
    rounding: float = 1e-9  # of the limit of friction
    unpressed: float = 1e6  # times the limit of friction: that is rounding of a joint's force of 0
    rough: int = 30  # iterations with the last forces of the joints: where these are of friction alone, Newton's fails
    iterations: int = 60  # of these, and then of Newton's method
    converged: float = 1e-13  # of the friction


HOLD = HoldLimits()


@dataclass(frozen=True)
class Held:
    """A place at which friction holds a freedom."""

    place: float  # angle or stroke of the freedom
    # the least and the largest place about it up to which friction holds it all along; infinite where it always does
    range: tuple[float, float]
    friction: dict[str, float]  # friction on the second body (N or N m) by law
    used: dict[str, float]  # share of its limit that each friction takes


def holds(law: object) -> bool:
    """Whether a law is dry friction that may hold its joint at rest: one without a belt that runs."""
    return isinstance(law, Friction) and not law.belt_speed and limit_of(law) > 0


def limit_of(law: Friction) -> float:
    """Give the coefficient of friction at rest."""
    return law.coefficient if law.static is None else law.static


@dataclass
class FrictionAtRest:
    """The friction that a freedom needs to be at rest."""

    made: SceneMachine  # made, freed: the machine, with one freedom and all contacts closed
    freed: Freed
    t: Array  # when its drives are at their position ``(1,)`` (s)

    @cached_property
    def _laws(self) -> dict[str, Rubbing]:
        acting = self.made.acting.items()
        return {place.partition(".")[2]: term for place, term in acting if isinstance(term, Rubbing)}

    @cached_property
    def _limits(self) -> Array:
        """Limit of each law's friction over its joint's force (m of a pin, 1 of a slider), ``(laws,)``."""
        return np.array([(law.radius or 1.0) * limit_of(law) if holds(law) else 0.0 for law in self._stated])

    def at(self, place: float) -> Carried:
        """Give the links at rest."""
        still = np.zeros((1, 1))
        known = self.freed.carried(self.t, np.full((1, 1), place), still, still).resting()
        self.freed.go_back(known)
        return known

    def _balance(self, place: float) -> tuple[FrictionBalance, float]:
        """Give what friction has to fulfil, and what is left of the freedom's equation without it."""
        # Where no multiplier presses, no term of friction acts.
        freed, known = self.freed, self.at(place)
        machine, n = freed.machine, freed.machine.n
        q, none = np.pad(known.Q, ((0, 0), (0, n))), np.zeros((1, 2 * n))
        found = machine.residual(self.t, q, none, none, angles=freed.angles(known.Q), moving=False)
        back = np.linalg.inv(machine.pattern.dense(found.M)[:, :n, n:])
        units = [self._unit(found, term) for term in self._laws.values()]
        shares = [-(x.radius or 1.0) * coefficient(x, np.array([-x.belt_speed])) for x in self._stated]
        alone, by = -(back @ found.force[:, :n, None])[..., 0], -(back @ np.stack(units, axis=-1)).astype(float)
        pressed = [np.array(term.rows) for term in self._laws.values()]
        return FrictionBalance(alone, by, np.stack(shares, axis=-1), pressed), -float(alone[0, freed.own[0]])

    @property
    def _stated(self) -> list[Friction]:
        return [term.stated for term in self._laws.values()]

    def _unit(self, found: Evaluation, term: Rubbing) -> Array:
        """Give the forces on the coordinates by a stress of size 1 ``(1, n)``."""
        machine, number = self.freed.machine, self.freed.terms.index(term)
        here, force = found.terms[number], np.zeros((1, machine.size))
        none = np.zeros((1, machine.pattern.entries))
        stressed = replace(here, response=Response(np.ones_like(here.x)))
        machine.groups[number].spread(stressed, None, machine.pattern, False, (force, none, none, none))
        return force[:, : machine.n]

    def needed(self, place: float) -> tuple[float, Array, Array]:
        """Give the share of the limits that friction needs, each friction, and the share each takes, ``(laws,)``."""
        # A positive share is needed where the freedom is pushed to smaller places.
        balance, left = self._balance(place)
        slopes = self._slopes(balance)
        against = np.where(np.abs(slopes) > HOLD.moves, np.sign(slopes) * self._limits, 0.0)
        if not against.any():
            return math.copysign(math.inf, left) if left else 0.0, np.zeros(len(slopes)), np.zeros(len(slopes))
        share, friction, count = 0.0, np.zeros(len(slopes)), len(slopes)
        for n in range(HOLD.iterations):
            sizes, along = (part[0] for part in balance.sizes(friction[None]))
            if n < HOLD.rough:
                belts = balance.shares[0] * sizes
                share = float((left - slopes @ belts) / (slopes @ (against * sizes)))
                friction = belts + share * against * sizes
                continue
            by = balance.shares[0] + share * against  # the first of belts that run
            tangent = np.eye(count + 1)
            tangent[:count, :count] += by[:, None] * (along @ balance.by_friction[0])
            tangent[:count, count], tangent[count, :count], tangent[count, count] = -against * sizes, -slopes, 0.0
            rest = np.append(friction - by * sizes, left - slopes @ friction)
            change = np.linalg.solve(tangent, -rest)
            friction, share = friction + change[:count], share + float(change[count])
            if np.abs(change[:count]).max() <= HOLD.converged * np.abs(friction).max() + np.finfo(float).tiny and (
                abs(change[count]) <= HOLD.rounding * (abs(share) + HOLD.rounding)
            ):
                return share, friction, np.where(against, abs(share), 0.0)
        if abs(share) > 1:  # friction that would have to be larger than it can may not be determined
            return math.copysign(math.inf, left), friction, np.zeros(count)
        raise SolverError(
            f"the friction that holds the freedom at joint {self._name} is not found: the joints lock each other"
        )

    def _slopes(self, balance: FrictionBalance) -> Array:
        """How far each joint moves against its friction with the freedom, ``(laws,)``: by virtual work."""
        return np.asarray(-balance.by_friction[0, self.freed.own[0]])

    def acts(self, start: float) -> bool:
        """Whether some joint whose friction may hold it moves with the freedom."""
        slopes = self._slopes(self._balance(start + self._steps[0])[0])
        return bool((np.abs(slopes) * self._limits > HOLD.moves * self._limits).any())

    def held_near(self, start: float) -> Held:
        """Give the first place that friction holds, from a start on to where the freedom is pushed."""
        place, ends = self._first_held(start), []
        here = self.at(place)
        for sense in (-1, 1):
            self.freed.go_back(here)
            found = self._up_to(place, sense, lambda at: abs(self.needed(at)[0]) <= 1 + HOLD.rounding)
            ends.append(sense * math.inf if found is None else found[0])
        self.freed.go_back(here)
        share, friction, used = self.needed(place)
        if not HOLD.rounding < abs(share) <= 1 + HOLD.rounding:  # balanced without it, maybe where nothing presses
            friction, used = np.zeros_like(friction), np.zeros_like(used)
        names = list(self._laws)
        return Held(place, (ends[0], ends[1]), dict(zip(names, friction)), dict(zip(names, np.minimum(used, 1.0))))

    def hold(self, held: Held) -> None:
        """Let friction hold the freedom."""
        for name, term in self._laws.items():
            term.held = held.friction[name]

    @property
    def _name(self) -> str:
        return next(iter(self.made.scene.freedoms))

    @cached_property
    def _steps(self) -> tuple[float, float, float]:
        """First and longest step, and how far places are looked for."""
        if isinstance(self.made.scene.joints[self._name], Prismatic | Slot):
            size = self.freed.extent
            return HOLD.first * size, math.inf, HOLD.strokes * size
        return HOLD.first, HOLD.longest, HOLD.turns

    def _first_held(self, start: float) -> float:
        """Place as of `held_near`."""
        if abs(at_start := self.needed(start)[0]) <= 1 + HOLD.rounding:
            return start
        sense = math.copysign(1.0, at_start)
        found = self._up_to(start, -int(sense), lambda place: self.needed(place)[0] * sense > 1 + HOLD.rounding)
        if found is None or found[1] is None:
            rubs = next(name for name, law in self.made.scene.joint_laws.items() if holds(law))
            needs = f"it needs {abs(at_start):.4g} times the most that friction gives"
            if abs(at_start) >= HOLD.unpressed:
                needs = "friction gives far too little, as where no force presses a joint"
            raise SolverError(
                f"no equilibrium of the freedom at joint {self._name} is found. At the start {needs}: see "
                f"joint_laws.{rubs}. On the way on which it is pushed no place holds it. Start elsewhere, or give a "
                "spring, a stop or more friction"
            )
        return found[1]

    def _up_to(self, place: float, sense: int, lasts: Callable[[float], bool]) -> tuple[float, float | None] | None:
        """Give the last place up to which something lasts and the first beyond it; None where it lasts all along."""
        # There is nothing beyond the end of the linkage's reach.
        (first, longest, far), start = self._steps, place
        step = first
        while abs(place - start) < far:
            there = place + sense * step
            try:
                self.at(there)
            except StrayedError:
                longest = step = step / 2
                if step < HOLD.shortest * first:
                    return place, None
                continue
            if not lasts(there):
                for _ in range(HOLD.halvings):
                    middle = (place + there) / 2
                    place, there = (middle, there) if lasts(middle) else (place, middle)
                return place, there
            place, step = there, min(step * HOLD.growth, longest)
        return None
