"""Where a machine with freedoms is in equilibrium, and small motions about that.

Rows lead the freedoms, so that links find their shape at each place of these. The multipliers of the rows are what
would hold the freedoms, and Newton's method looks for the place at which they are 0. Where the stiffness is not
positive, a share of the mass is added to it, so that each step gives way to the forces (Levenberg). No step is so long
that they push back harder than they pushed.
Source of the small motions: Meirovitch, Fundamentals of Vibrations (2001), chapters 7 and 8.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import eigh, null_space

from fenics_mech._arrays import Array, Index
from fenics_mech.errors import MechanismError, SolverError
from fenics_mech.machine import Machine
from fenics_mech.solve.frequencies import tangents_at
from fenics_mech.solve.newton import converge
from fenics_mech.solve.sparse import blocks_of, solutions
from fenics_mech.solve.statics import stiffness
from fenics_mech.terms import rubs

ADVICE = "Give rough angles nearer to it, or leave out what drives the freedoms on"


@dataclass(frozen=True)
class RestLimits:
    """Limits of the search for an equilibrium."""

    most_steps: int = 200
    longest: float = 0.4  # rad or m, of all freedoms together in a step
    found: float = 1e-9  # m or rad, of a step of Newton's method after which the equilibrium is found
    bent: float = 1e-11  # rad or of the extent, of a step after which links have their shape
    most_bends: int = 30  # of these steps
    balanced: float = 1e-11  # of the largest force, by which such a step changes one of a row, where bodies rub
    shorter: int = 60  # times that a step is halved at most
    back: float = 0.9  # of what pushed along a step, with which forces may push back at its end
    least: float = 1e-5  # 1/s^2, of stiffness over mass, up to which it counts as none
    basis: int = 3  # modes of the links for each small motion that is given
    shift: float = 2.0  # times the negative eigenvalue that is added to the stiffness
    rounding: float = 1e-6  # of the fastest rate of a small motion, by which one may seem to grow
    still: float = 1e-9  # of the fastest rate, below which there is no oscillation


REST = RestLimits()


@dataclass(frozen=True)
class SmallMotions:
    """Small motions about an equilibrium, the slowest first."""

    frequency: Array  # natural frequency with damping (Hz), 0 where it does not oscillate, (motions,)
    decay: Array  # rate at which it decays (1/s), negative where it grows, (motions,)

    @classmethod
    def of(cls, mass: Array, damping: Array, stiffness: Array) -> SmallMotions:
        """Solve ``M y'' + C y' + K y = 0`` for all motions that go as ``exp(s t)``."""
        # mass, damping, stiffness (coordinates, coordinates) each
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
        """Give the slowest motions."""
        return SmallMotions(self.frequency[:count], self.decay[:count])


class Shape:
    """Newton's method for the shape of links at rest, step by step, whose freedoms are held."""

    def __init__(self, machine: Machine, t: Array, q: Array, a: Array, drawn: Sequence[Array]) -> None:
        # t (1,) (s); q, a (1, size) each
        self.machine, self.t, self.q, self.a, self.drawn = machine, t, q, a, drawn
        self.share = 1.0  # of the loads that act
        self.stresses: Sequence[Array] | None = None
        self.begun = q, a

    @property
    def angles(self) -> list[Array]:
        """Angles near those of every term."""
        found = self.machine.turned(self.drawn, self.q)
        assert found is not None
        return found

    def step(self) -> float:
        """Take a step, and give the size of its change."""
        machine, zero, known, share = self.machine, np.zeros_like(self.q), self.stresses, self.share
        at = self.t, self.q, zero, self.a
        found = machine.residual(*at, predicted=known, angles=self.angles, loads=share, moving=False)
        values = stiffness(machine, found)[..., None, None]
        x = solutions(blocks_of(machine.pattern, 1), values, -found.force, "the shape at rest")
        change = np.where(np.arange(machine.size) < machine.n, x, 0.0)
        pulls = x - change
        self.stresses = machine.predicted(found, change, zero, pulls)
        self.q, self.a = self.q + change, self.a + pulls
        size = float(np.abs(change / machine.units).max(initial=0.0))
        if rubs(machine.terms):  # else multipliers follow from the shape alone
            sizes = (np.abs(here.response.stress).max(initial=0.0) for here in found.terms)
            most = max(float(np.abs(self.a).max(initial=0.0)), *sizes) or 1.0
            size = max(size, REST.bent / REST.balanced * float(np.abs(pulls).max(initial=0.0)) / most)
        return size

    def rest(self) -> None:
        """Go back to where it begins."""
        self.q, self.a = self.begun

    def refuse_beyond(self, reached: float) -> None:
        """Take what is found: whether it is stable is judged with the freedoms."""


@dataclass(frozen=True)
class Condensed:
    """What is left of the freedoms' equations at a shape of the links, which give way at once."""

    shape: Shape  # the shape
    rows: Index  # numbers of the rows that lead the freedoms

    @cached_property
    def _tangents(self) -> tuple[Array, Array]:
        """Mass of the coordinates ``(n, n)``, and stiffness with all rows ``(size, size)``."""
        shape, machine, zero = self.shape, self.shape.machine, np.zeros_like(self.shape.q)
        found = machine.residual(shape.t, shape.q, zero, shape.a, angles=shape.angles, moving=False)
        mass, whole = (machine.pattern.dense(x)[0] for x in (found.M, stiffness(machine, found)))
        return mass[: machine.n, : machine.n], whole

    @cached_property
    def _moved(self) -> Array:
        """How coordinates and multipliers move with each freedom ``(size, freedoms)``."""
        return led_by(self._tangents[1], self.shape.machine.n + self.rows)

    @property
    def left(self) -> Array:
        """What the freedoms would have to be held by, with the other sign ``(freedoms,)``."""
        return -self.shape.a[0, self.shape.machine.n + self.rows]

    @cached_property
    def mass(self) -> Array:
        """Mass of the freedoms ``(freedoms, freedoms)``."""
        mass, moved = self._tangents[0], self._moved[: self.shape.machine.n]
        return np.asarray(moved.T @ (mass + mass.T) @ moved / 2)

    @property
    def stiffness(self) -> Array:
        """Stiffness of the freedoms ``(freedoms, freedoms)``."""
        return -self._moved[self.shape.machine.n + self.rows]

    def least(self) -> float:
        """Least eigenvalue of the freedoms' stiffness over their mass (1/s^2)."""
        stiff = self.stiffness
        return float(eigh((stiff + stiff.T) / 2, self.mass, eigvals_only=True, subset_by_index=(0, 0))[0])

    def change(self, least: float) -> Array:
        """Give a step of Newton's method ``(freedoms,)``, with as much mass in the stiffness as makes it positive."""
        left, mass = self.left, self.mass
        accelerated = float(np.abs(np.linalg.solve(mass, left)).max())
        shift = 0.0 if least > REST.least else max(-REST.shift * least, accelerated / REST.longest)
        if not shift and least <= REST.least:  # nothing pushes, and nothing holds
            return np.zeros_like(left)
        change = -np.linalg.solve(self.stiffness + shift * mass, left)
        return np.asarray(change * min(1.0, REST.longest / max(np.abs(change).sum(), REST.found)))


def led_by(whole: Array, numbers: Index) -> Array:
    """Give how unknowns move with the values of rows ``(size, rows)``, by their stiffness ``(size, size)``."""
    # Rows and columns are brought to one size before.
    scale = 1 / np.sqrt(np.maximum(np.abs(whole).max(axis=1), 1e-300))
    return np.asarray(scale[:, None] * np.linalg.solve(scale[:, None] * whole * scale, np.diag(scale)[:, numbers]))


@dataclass(frozen=True)
class RestSearch:
    """Searches the equilibrium of a machine with freedoms."""

    machine: Machine  # the machine as drawn, with rows that lead the freedoms
    rows: Index  # numbers of these rows
    names: tuple[str, ...]  # names of the freedoms, for messages
    t: Array  # instant at which drives are held (1,) (s)
    # Leads the rows of the freedoms to places (freedoms,), and gives coordinates of links that do not bend there
    # (n,). It raises `MechanismError` where there are none.
    led: Callable[[Array], Array]
    drawn: Sequence[Array]  # angles of every term as drawn

    def found_from(self, place: Array) -> tuple[Array, Condensed]:
        """Give the places of the freedoms at rest ``(freedoms,)``, and what is there."""
        # place (freedoms,)
        here = self.at(place)
        for _ in range(REST.most_steps):
            least = self._least(here)
            change = here.change(least)
            if np.abs(change).max(initial=0.0) <= REST.found:
                self._refuse_neutral(least)
                return place + change, self.at(place + change, (place, here))
            place, here = self._stepped(place, here, change)
        raise SolverError(f"no equilibrium of {self._named} is found after {REST.most_steps} steps. {ADVICE}")

    def at(self, place: Array, near: tuple[Array, Condensed] | None = None) -> Condensed:
        """Let links take their shape with the freedoms held, near to one at other places, which goes along."""
        # place (freedoms,)
        machine, size = self.machine, self.machine.size
        if near is None:
            q, a = np.pad(self.led(place), (0, size - machine.n))[None], np.zeros((1, size))
        else:
            known, shape = near[0], near[1].shape
            q, a = self._along(shape.q[0], self.led(known), self.led(place))[None], shape.a
        shape = Shape(machine, self.t, q, a, self.drawn)
        try:
            converge(shape, REST.bent, REST.most_bends, "the shape at rest")
        except SolverError as error:
            raise SolverError(
                f"the links find no shape at rest with {self._named} held: they may buckle. {ADVICE}"
            ) from error
        return Condensed(shape, self.rows)

    def _along(self, q: Array, known: Array, there: Array) -> Array:
        """Give coordinates of bent links that go along with ones that do not bend, each pose by its turn."""
        machine, d = self.machine, self.machine.geometry.d
        beside, turned = (np.append(x, 0.0)[machine.places] for x in (q[: machine.n] - known, there - known))
        beside[:, :d] = (machine.geometry.turn(turned[:, d:]) @ beside[:, :d, None])[..., 0]
        found = np.zeros(machine.size + 1)
        found[machine.places] = beside
        return found[:-1] + np.pad(there, (0, machine.size - machine.n))

    @property
    def _named(self) -> str:
        return f"the freedom{'s' * (len(self.names) > 1)} at joint {', '.join(self.names)}"

    def _least(self, condensed: Condensed) -> float:
        """Least eigenvalue of the freedoms' stiffness over their mass (1/s^2)."""
        try:
            return condensed.least()
        except np.linalg.LinAlgError as error:
            raise SolverError(f"{self._named} moves no mass: give its links mass or inertia") from error

    def _stepped(self, place: Array, here: Condensed, change: Array) -> tuple[Array, Condensed]:
        """Go a step, or a shorter one at whose end links find a shape and do not push back harder than they pushed."""
        fault = None
        for _ in range(REST.shorter):
            try:
                there = self.at(place + change, (place, here))
            except MechanismError as error:
                fault = error
            else:
                fault = None
                if float(there.left @ change) <= REST.back * abs(float(here.left @ change)):
                    return place + change, there
            change = change / 2
        if fault is not None:
            raise fault
        raise SolverError(f"no equilibrium of {self._named} is found: the forces are not smooth. {ADVICE}")

    def _refuse_neutral(self, least: float) -> None:
        """Raise where nothing resists a freedom, by the least eigenvalue of its stiffness over its mass."""
        if abs(least) <= REST.least:
            raise SolverError(
                f"nothing holds {self._named} at one place: each is an equilibrium. Give gravity, springs or loads"
            )

    def refuse_unstable(self, motions: SmallMotions) -> None:
        """Raise `SolverError` where a small motion grows."""
        if motions.grows:
            fastest = -float(motions.decay.min())
            raise SolverError(
                f"the equilibrium of {self._named} is unstable: a small disturbance grows by a rate of {fastest:.4g} "
                "1/s. Start from other rough angles; analysis.allow_unstable lets it pass"
            )


def small_motions(
    machine: Machine, t: float, q: Array, a: Array, rows: Index, count: int, angles: Sequence[Array] | None = None
) -> SmallMotions:
    """Give the slowest small motions about an equilibrium of a machine whose freedoms are let go."""
    # q, a (size,)
    # They are combinations of what the freedoms move, links giving way at once, and of the links' slowest modes
    # beside.
    n, (M, C, K) = machine.n, (x.toarray() for x in tangents_at(machine, q, a, t, moving=False, angles=angles))
    moved, pushed = (led_by(x, n + rows)[:n] for x in (K, K.T))
    held = null_space(K[n:, :n]) if len(K) > n else np.eye(n)
    modes = np.zeros((n, 0))
    if held.shape[1]:
        mass, stiff = (held.T @ (x + x.T)[:n, :n] @ held / 2 for x in (M, K))
        most = min(REST.basis * count, len(mass))
        try:
            slowness, shapes = eigh(mass, stiff, subset_by_index=(len(mass) - most, len(mass) - 1))
        except np.linalg.LinAlgError as error:
            raise SolverError(
                f"the links buckle where the freedoms rest: their stiffness is not positive there. {ADVICE}"
            ) from error
        modes = held @ shapes[:, slowness > REST.still * slowness.max()]
    left, right = np.hstack([pushed, modes]), np.hstack([moved, modes])
    return SmallMotions.of(*(left.T @ x[:n, :n] @ right for x in (M, C, K))).first(count)
