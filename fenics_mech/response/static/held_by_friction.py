"""Where dry friction holds a linkage of rigid links that has one freedom.

At rest the friction F of a joint is any up to its limit, ``|F| <= m |l|``: m is its coefficient, times the radius of a
pin, and l the joint's force. Just before the freedom slips all joints that move with it are at their limits, each
against the motion. So all take one share s of their limits, and friction holds where ``|s| <= 1``.
Source: Coulomb's law at rest; Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 5.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import AssemblyError, SolverError
from fenics_mech.joints.friction_balance import FrictionBalance
from fenics_mech.kinematics.free_linkage import FreeLinkage
from fenics_mech.mechanism.rigid_dynamics import RigidStates
from fenics_mech.response.transient.rigid_state import RigidState
from fenics_mech.scene import Friction, Prismatic, Scene, Slot


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
    """A place at which friction holds a freedom.

    Parameters
    ----------
    place
        Angle or stroke of the freedom.
    range
        The least and the largest place about it up to which friction holds it all along; infinite where it always does.
    friction
        Friction on the second body (N or N m) by law.
    used
        Share of its limit that each friction takes.
    """

    place: float
    range: tuple[float, float]
    friction: dict[str, float]
    used: dict[str, float]


def holds(law: object) -> bool:
    """Whether a law is dry friction that may hold its joint at rest: one without a belt that runs.

    Parameters
    ----------
    law
        Any joint law that a scene states.
    """
    return isinstance(law, Friction) and not law.belt_speed and limit_of(law) > 0


def limit_of(law: Friction) -> float:
    """Give the coefficient of friction at rest.

    Parameters
    ----------
    law
        The law.
    """
    return law.coefficient if law.static is None else law.static


@dataclass
class FrictionAtRest:
    """The friction that a freedom needs to be at rest.

    Parameters
    ----------
    scene
        The scene, with one freedom.
    """

    scene: Scene

    def __post_init__(self) -> None:
        """Begin at the start, with all contacts closed."""
        self.state = RigidState(self.scene, FreeLinkage(self.scene))
        self.state.contacts = self.state.dynamics.all_closed()

    @cached_property
    def _limits(self) -> Array:
        """Limit of each law's friction over its joint's force (m of a pin, 1 of a slider), ``(laws,)``."""
        rubbing = self.state.dynamics.rubbing.values()
        return np.array([law.arm * limit_of(law.stated) if holds(law.stated) else 0.0 for law in rubbing])

    def states(self, place: float) -> RigidStates:
        """Give the links at rest.

        Parameters
        ----------
        place
            Angle or stroke of the freedom.
        """
        still = np.zeros((1, 1))
        return self.state.states(np.zeros(1), (np.full((1, 1), place), still, still))

    def needed(self, place: float) -> tuple[float, Array, Array]:
        """Give the share of the limits that friction needs, each friction, and the share each takes, ``(laws,)``.

        A positive share is needed where the freedom is pushed to smaller places.

        Parameters
        ----------
        place
            Angle or stroke of the freedom.

        Raises
        ------
        SolverError
            When Newton's method for the friction of several joints does not converge.
        """
        still, dynamics, states = np.zeros((1, 1)), self.state.dynamics, self.states(place)
        balance = dynamics.unsolved(states, self.state.contacts)[0]
        left = self.state.left(np.zeros(1), (np.full((1, 1), place), still, still), balance.alone)[0, 0]
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
        efforts = self.state.dynamics.efforts
        return np.array([efforts(balance.by_friction[..., k])[0, -1] for k in range(len(self._limits))])

    def acts(self, start: float) -> bool:
        """Whether some joint whose friction may hold it moves with the freedom.

        Parameters
        ----------
        start
            Angle or stroke of the freedom, which may be a dead centre of that joint.
        """
        beside = self.states(start + self._steps[0])
        slopes = self._slopes(self.state.dynamics.unsolved(beside, self.state.contacts)[0])
        return bool((np.abs(slopes) * self._limits > HOLD.moves * self._limits).any())

    def share(self, place: float) -> float:
        """Give the share of the limits that friction needs.

        Parameters
        ----------
        place
            Angle or stroke of the freedom.
        """
        return self.needed(place)[0]

    def held_near(self, start: float) -> Held:
        """Give the first place that friction holds, from a start on to where the freedom is pushed.

        Parameters
        ----------
        start
            Angle or stroke of the freedom.

        Raises
        ------
        SolverError
            When there is none.
        """
        place, ends = self._first_held(start), []
        here = self.states(place)
        for sense in (-1, 1):
            self.state.move_on(here)
            ends.append(self._last_held(place, sense))
        self.state.move_on(here)
        share, friction, used = self.needed(place)
        if not HOLD.rounding < abs(share) <= 1 + HOLD.rounding:  # balanced without it, maybe where nothing presses
            friction, used = np.zeros_like(friction), np.zeros_like(used)
        names = list(self.state.dynamics.rubbing)
        return Held(place, (ends[0], ends[1]), dict(zip(names, friction)), dict(zip(names, np.minimum(used, 1.0))))

    @property
    def _name(self) -> str:
        return next(iter(self.scene.freedoms))

    @cached_property
    def _steps(self) -> tuple[float, float, float]:
        """First and longest step, and how far places are looked for."""
        if isinstance(self.scene.joints[self._name], Prismatic | Slot):
            size = self.state.linkage.loops.size
            return HOLD.first * size, math.inf, HOLD.strokes * size
        return HOLD.first, HOLD.longest, HOLD.turns

    def _first_held(self, start: float) -> float:
        """Place as of `held_near`."""
        if abs(at_start := self.share(start)) <= 1 + HOLD.rounding:
            return start
        sense = math.copysign(1.0, at_start)
        found = self._up_to(start, -int(sense), lambda place: self.share(place) * sense > 1 + HOLD.rounding)
        if found is None or found[1] is None:
            rubs = next(name for name, law in self.scene.joint_laws.items() if holds(law))
            needs = f"it needs {abs(at_start):.4g} times the most that friction gives"
            if abs(at_start) >= HOLD.unpressed:
                needs = "friction gives far too little, as where no force presses a joint"
            raise SolverError(
                f"no equilibrium of the freedom at joint {self._name} is found. At the start {needs}: see "
                f"joint_laws.{rubs}. On the way on which it is pushed no place holds it. Start elsewhere, or give a "
                "spring, a stop or more friction"
            )
        return found[1]

    def _last_held(self, place: float, sense: int) -> float:
        """Last place in a sense up to which friction holds; infinite where it always does, or the end of the reach."""
        found = self._up_to(place, sense, lambda place: abs(self.share(place)) <= 1 + HOLD.rounding)
        return sense * math.inf if found is None else found[0]

    def _up_to(self, place: float, sense: int, lasts: Callable[[float], bool]) -> tuple[float, float | None] | None:
        """Give the last place up to which something lasts and the first beyond it; None where it lasts all along.

        There is nothing beyond the end of the linkage's reach.
        """
        (first, longest, far), start = self._steps, place
        step = first
        while abs(place - start) < far:
            there = place + sense * step
            try:
                self.state.move_on(self.states(there))
            except AssemblyError:
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
