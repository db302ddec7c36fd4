"""Where the equation of freedoms is in equilibrium, and small motions about that.

The equilibrium is found by Newton's method. Where the stiffness is not positive, a share of the mass is added to it, so
that each step gives way to the forces (Levenberg). No step is so long that they push back harder than they pushed.
Source of the small motions: Meirovitch, Fundamentals of Vibrations (2001), chapters 7 and 8.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.linalg import eigh

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError

ADVICE = "Give rough angles nearer to it, or leave out what drives the freedoms on"


@dataclass(frozen=True)
class RestLimits:
    """Limits of the search for an equilibrium."""

    most_steps: int = 200
    longest: float = 0.4  # rad or m, of all freedoms together in a step
    found: float = 1e-9  # m or rad, of a step of Newton's method after which the equilibrium is found
    most_bends: int = 30  # steps of Newton's method in which the links bend
    shorter: int = 60  # times that a step is halved at most
    back: float = 0.9  # of what pushed along a step, with which forces may push back at its end
    least: float = 1e-5  # 1/s^2, of stiffness over mass, up to which it counts as none
    basis: int = 3  # modes of the links for each small motion that is given
    shift: float = 2.0  # times the negative eigenvalue that is added to the stiffness
    rounding: float = 1e-6  # of the fastest rate of a small motion, by which one may seem to grow
    still: float = 1e-9  # of the fastest rate, below which there is no oscillation


REST = RestLimits()


class RestEquation(Protocol):
    """An equation of motion as the solver of `stepping` knows it."""

    def residuals(self, time: Array, place: Array, rate: Array, second: Array) -> Array:
        """What is left of it, ``(times, coordinates)``."""

    def tangents_at(self, time: Array, place: Array, rate: Array, second: Array) -> tuple[Array, Array, Array]:
        """Tangents by the second derivative, the rate and the place, ``(times, coordinates, coordinates)`` each."""


@dataclass(frozen=True)
class SmallMotions:
    """Small motions about an equilibrium, the slowest first.

    Parameters
    ----------
    frequency
        Natural frequency with damping (Hz), 0 where it does not oscillate, ``(motions,)``.
    decay
        Rate at which it decays (1/s), negative where it grows, ``(motions,)``.
    """

    frequency: Array
    decay: Array

    @classmethod
    def of(cls, mass: Array, damping: Array, stiffness: Array) -> SmallMotions:
        """Solve ``M y'' + C y' + K y = 0`` for all motions that go as ``exp(s t)``.

        Parameters
        ----------
        mass, damping, stiffness
            M, C and K, ``(coordinates, coordinates)`` each.
        """
        n = len(mass)
        moved = np.linalg.solve(mass, np.hstack([stiffness, damping]))
        roots = np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [-moved]]))
        still = np.abs(roots.imag) <= REST.still * np.abs(roots).max(initial=0.0)
        damped = np.abs(roots.real) > REST.still * np.abs(roots)
        roots = np.where(still, 0, roots.imag) * 1j + np.where(damped, roots.real, 0)  # without rounding
        roots = roots[still | (roots.imag > 0)]
        roots = roots[np.lexsort((np.abs(roots.real), np.abs(roots)))]
        return cls(roots.imag / (2 * np.pi), -roots.real)

    @property
    def grows(self) -> bool:
        """Whether some motion grows."""
        fastest = max(2 * np.pi * self.frequency.max(initial=0.0), np.abs(self.decay).max(initial=0.0))
        return bool((self.decay < -REST.rounding * fastest).any())

    def first(self, count: int) -> SmallMotions:
        """Give the slowest motions.

        Parameters
        ----------
        count
            How many, at most.
        """
        return SmallMotions(self.frequency[:count], self.decay[:count])


@dataclass(frozen=True)
class Condensed:
    """What is left of an equation at rest, and its tangents, with links that give way at once to their freedoms.

    Parameters
    ----------
    left
        What is left, ``(coordinates,)``.
    mass, damping, stiffness
        Tangents by the second derivative, the rate and the place, ``(coordinates, coordinates)`` each.
    bend
        How the links bend by what is left and by each freedom, ``(links' coordinates, 1 + freedoms)``.
    """

    left: Array
    mass: Array
    damping: Array
    stiffness: Array
    bend: Array

    @classmethod
    def of(cls, left: Array, tangents: tuple[Array, ...], freedoms: int) -> Condensed:
        """Let the links give way.

        Parameters
        ----------
        left, tangents
            What is left, and tangents as of `RestEquation`.
        freedoms
            Their number: they are the last coordinates.
        """
        n, stiffness = len(left) - freedoms, tangents[2]
        bend = np.linalg.solve(stiffness[:n, :n], np.column_stack([left[:n], stiffness[:n, n:]]))
        return cls(left, tangents[0], tangents[1], stiffness, -np.asarray(bend, dtype=np.float64))

    @cached_property
    def _moved(self) -> Array:
        """How all coordinates move with each freedom, ``(coordinates, freedoms)``."""
        return np.vstack([self.bend[:, 1:], np.eye(self.bend.shape[1] - 1)])

    @cached_property
    def _own(self) -> tuple[Array, Array, Array]:
        """What is left of the freedoms' equations, their mass and their stiffness."""
        n, moved = len(self.bend), self._moved
        onto = self.stiffness[n:, :n] @ self.bend
        return (
            self.left[n:] + onto[:, 0],
            moved.T @ (self.mass + self.mass.T) @ moved / 2,
            self.stiffness[n:, n:] + onto[:, 1:],
        )

    @property
    def own_left(self) -> Array:
        """What is left of the freedoms' equations, ``(freedoms,)``."""
        return self._own[0]

    def least(self) -> float:
        """Least eigenvalue of the freedoms' stiffness over their mass (1/s^2)."""
        _, mass, stiffness = self._own
        return float(eigh((stiffness + stiffness.T) / 2, mass, eigvals_only=True, subset_by_index=(0, 0))[0])

    def change(self, least: float) -> Array:
        """Give a step of Newton's method, with as much mass in the stiffness as makes it positive.

        Parameters
        ----------
        least
            The least eigenvalue.
        """
        left, mass, stiffness = self._own
        accelerated = float(np.abs(np.linalg.solve(mass, left)).max())
        shift = 0.0 if least > REST.least else max(-REST.shift * least, accelerated / REST.longest)
        still = not shift and least <= REST.least  # nothing pushes, and nothing holds
        own = np.zeros_like(left) if still else -np.linalg.solve(stiffness + shift * mass, left)
        own = own * min(1.0, REST.longest / max(np.abs(own).sum(), REST.found))
        return np.append(self.bend @ np.append(1.0, own), own)

    def small_motions(self, modes: int) -> SmallMotions:
        """Give the small motions, of the freedoms and of the links' lowest modes beside them.

        Parameters
        ----------
        modes
            How many modes of the links at most.
        """
        n = len(self.bend)
        shapes = np.zeros((len(self.left), min(n, modes)))
        if shapes.size:
            held = (self.stiffness + self.stiffness.T)[:n, :n] / 2, (self.mass + self.mass.T)[:n, :n] / 2
            shapes[:n] = eigh(*held, subset_by_index=(0, shapes.shape[1] - 1))[1]
        basis = np.hstack([self._moved, shapes])
        return SmallMotions.of(*(basis.T @ part @ basis for part in (self.mass, self.damping, self.stiffness)))


@dataclass(frozen=True)
class RestSearch:
    """Searches the equilibrium of an equation of motion, whose last coordinates are the freedoms.

    Parameters
    ----------
    equation
        The equation.
    freedoms
        Names of the freedoms.
    move_on
        Takes coordinates ``(coordinates,)`` as those that others are near to.
    allow_unstable
        Whether an equilibrium from which small disturbances grow is one.
    modes
        Modes of the links in the small motions.
    """

    equation: RestEquation
    freedoms: tuple[str, ...]
    move_on: Callable[[Array], None]
    allow_unstable: bool
    modes: int = 0

    def found_from(self, place: Array) -> tuple[Array, SmallMotions]:
        """Give the coordinates at rest, ``(coordinates,)``, and small motions about it.

        Parameters
        ----------
        place
            Coordinates to start from, ``(coordinates,)``.

        Raises
        ------
        SolverError
            When there is none near, or it is unstable.
        """
        place, here = self._bent(place)
        for _ in range(REST.most_steps):
            least = self._least(here)
            change = here.change(least)
            if np.abs(change).max(initial=0.0) <= REST.found:
                self._refuse_neutral(least)
                motions = here.small_motions(self.modes)
                self._judge(motions)
                return place + change, motions
            place, here = self._stepped(place, here, change)
            self.move_on(place)
        raise SolverError(f"no equilibrium of {self._names} is found after {REST.most_steps} steps. {ADVICE}")

    def _bent(self, place: Array) -> tuple[Array, Condensed]:
        """Let the links bend with their freedoms held: full steps, as bent members resist a part of one along them."""
        n = len(place) - len(self.freedoms)
        for _ in range(REST.most_bends):
            here = Condensed.of(self._left(place), self._tangents(place), len(self.freedoms))
            bend = here.bend[:, 0]
            if np.abs(bend).max(initial=0.0) <= REST.found:
                return place, here
            place = place + np.append(bend, np.zeros(len(place) - n))
        raise SolverError(f"the links find no shape at rest with {self._names} held: they may buckle. {ADVICE}")

    @property
    def _names(self) -> str:
        return f"the freedom{'s' * (len(self.freedoms) > 1)} at joint {', '.join(self.freedoms)}"

    def _left(self, place: Array) -> Array:
        still = np.zeros((1, len(place)))
        return self.equation.residuals(np.zeros(1), place[None], still, still)[0]

    def _tangents(self, place: Array) -> tuple[Array, ...]:
        still = np.zeros((1, len(place)))
        return tuple(part[0] for part in self.equation.tangents_at(np.zeros(1), place[None], still, still))

    def _least(self, condensed: Condensed) -> float:
        """Least eigenvalue of the freedoms' stiffness over their mass (1/s^2)."""
        try:
            return condensed.least()
        except np.linalg.LinAlgError as error:
            raise SolverError(f"{self._names} moves no mass: give its links mass or inertia") from error

    def _stepped(self, place: Array, here: Condensed, change: Array) -> tuple[Array, Condensed]:
        """Go a step, or a shorter one at whose end links find a shape and do not push back harder than they pushed."""
        own, fault = change[len(here.bend) :], None
        for _ in range(REST.shorter):
            try:
                there, reached = self._bent(place + change)
            except SolverError as error:
                fault = error
            else:
                fault = None
                if float(reached.own_left @ own) <= REST.back * abs(float(here.own_left @ own)):
                    return there, reached
            change, own = change / 2, own / 2
        if fault is not None:
            raise fault
        raise SolverError(f"no equilibrium of {self._names} is found: the forces are not smooth. {ADVICE}")

    def _refuse_neutral(self, least: float) -> None:
        """Raise where nothing resists a freedom, by the least eigenvalue of its stiffness over its mass."""
        if abs(least) <= REST.least:
            raise SolverError(
                f"nothing holds {self._names} at one place: each is an equilibrium. Give gravity, springs or loads"
            )

    def _judge(self, motions: SmallMotions) -> None:
        if motions.grows and not self.allow_unstable:
            fastest = -float(motions.decay.min())
            raise SolverError(
                f"the equilibrium of {self._names} is unstable: a small disturbance grows by a rate of {fastest:.4g} "
                "1/s. Start from other rough angles; analysis.allow_unstable lets it pass"
            )
