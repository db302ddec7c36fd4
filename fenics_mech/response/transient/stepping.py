"""Time steps by collocation, as a type of PETSc's TS.

A step solves for the accelerations at s points in it, of the second order equation as it stands. With Radau points it
is of order 2s - 1 and damps what is too fast for the steps; with Gauss points it is of order 2s and keeps energies. The
error of a step is measured by its elastic and kinetic energy, so that a stiff mode counts as much as it carries. It is
filtered, so that what is too fast for the steps does not shorten them.

Source: Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.8.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._petsc import PETSc
from fenics_mech.errors import AssemblyError, SolverError
from fenics_mech.response.periodic.tableau import Tableau

Curve = Callable[[Array], tuple[Array, Array]]  # z and z' at times (s), (times, coordinates) each
Sizes = tuple[tuple[slice, float], ...]  # parts of the coordinates, and the root of an energy for each (sqrt(J))
Tangents = tuple[Array, Array, Array]  # by z'', z' and z, ``(times, coordinates, coordinates)`` each
Keep = Callable[[float, Curve], bool]  # takes the end of a step (s) and its motion; says whether to stop
Watch = Callable[[float, float, Curve], float | None]  # takes both ends (s) too; gives the time at which to end instead


@dataclass(frozen=True)
class StepLimits:
    """Limits of Newton's method in a time step."""

    most_iterations: int = 10  # of Newton's method in a step
    sticking: float = 1e-3  # of its limit, to which friction that is held comes to its law: as of the steps
    turned: float = 0.1  # the same, above which it went from sticking to sliding, and tangents are made anew
    fast: float = 0.03  # of the change before, down to which Newton's method keeps its tangents
    newton: float = 1e-3  # of the tolerance of a step, to which it is solved
    shortest: float = 1e-10  # step, of the longest
    margin: float = 1e-9  # of a step, that is not left over at the end
    smallest_change: float = 0.2  # factor of a step's length from one step to the next
    largest_change: float = 5.0  # the same
    after_failure: float = 1.5  # the same after one for which Newton's method failed in a rigid motion
    safety: float = 0.9  # of the length that the error allows


STEPPING = StepLimits()


class HeldFriction(Protocol):
    """Dry friction that is an unknown of its own in Newton's method, as it changes too fast with the speed."""

    def hold(self, time: Array, z: Array, rate: Array) -> float:
        """Take it as linear about where Newton's method has brought it; say how far that is from its law."""

    def let_go(self) -> None:
        """Take it by its law."""


class EquationInTime(Protocol):
    """An equation of motion of second order for scaled coordinates z, which have the unit sqrt(J)."""

    @property
    def linear(self) -> bool:
        """Whether Newton's method has to take one step only."""

    def residuals(self, time: Array, z: Array, rate: Array, second: Array) -> Array:
        """What is left of it at times (s), ``(times, coordinates)``, for z, z' and z'' there."""

    def tangents_at(self, time: Array, z: Array, rate: Array, second: Array) -> Tangents:
        """Tangents by z'', z' and z, ``(times, coordinates, coordinates)`` each."""

    def accelerations(self, time: Array, z: Array, rate: Array) -> Array:
        """Give z'' that the equation demands, ``(times, coordinates)``."""


@dataclass(frozen=True)
class StepCurve:
    """The polynomials of a step, which give z and z' at times (s), ``(times, coordinates)`` each.

    Parameters
    ----------
    start, length
        Where the step begins (s), and its length (s).
    place, rate
        z and z' there, ``(coordinates,)`` each.
    made
        z'' at the collocation points, ``(points, coordinates)``.
    tableau
        These points.
    coefficients
        Of the polynomials of z'', ``(points, coordinates)``.
    """

    start: float
    length: float
    place: Array
    rate: Array
    made: Array
    tableau: Tableau
    coefficients: Array

    def __call__(self, times: Array) -> tuple[Array, Array]:
        """Give z and z'.

        Parameters
        ----------
        times
            Times (s), ``(times,)``.
        """
        place, orders = (times - self.start)[:, None], np.arange(len(self.made))
        powers = (place / self.length) ** orders
        rates = self.rate + place * ((powers / (orders + 1)) @ self.coefficients)
        second = place**2 * ((powers / ((orders + 1) * (orders + 2))) @ self.coefficients)
        return np.asarray(self.place + place * self.rate + second), np.asarray(rates)

    @property
    def points(self) -> tuple[Array, Array]:
        """Times of the collocation points (s), and their weights in an integral over the step (s), ``(points,)``."""
        return self.start + self.length * self.tableau.points, self.length * self.tableau.weights


KeepStep = Callable[[float, StepCurve], bool]  # as `Keep`


@dataclass
class Collocation:
    """Steps of the state ``(z, z')`` of an equation.

    Parameters
    ----------
    equation
        The equation.
    tableau
        The collocation points.
    tolerance, sizes
        Error of a step, and what it is relative to.
    longest
        Longest step (s).
    keep
        Is called with every step.
    watch
        Says where a step has to end, such as where bodies touch; None where nothing cuts steps.
    of_motion
        Whether errors are relative to the energy of the motion alone, and Newton's method ends by the energy of its
        changes: coordinates of rigid motion count from anywhere, and have no common unit.
    from_rest
        When Newton's method begins a step from no acceleration: "never"; "last", where else it does not converge, as
        where friction holds; "first", where what rests may also move, as friction falls with speed.
    held
        Dry friction that Newton's method finds as an unknown of its own; None where there is none.
    """

    equation: EquationInTime
    tableau: Tableau
    tolerance: float
    sizes: Sizes
    longest: float
    keep: KeepStep
    watch: Watch | None = None
    of_motion: bool = False
    from_rest: Literal["never", "last", "first"] = "never"
    held: HeldFriction | None = None
    _latest: tuple[float, Array] | None = field(default=None)  # length and accelerations of the last step
    _fault: str = ""  # what was wrong in the last step that was too long

    def __post_init__(self) -> None:
        """Find the embedded method of order s, which has the start as a further point."""
        points, s = self.tableau.points, len(self.tableau.points)
        self.lead = float(np.linalg.det(self.tableau.inner) ** (1 / s))
        moments = 1 / np.arange(1, s + 1)
        moments[0] -= self.lead
        powers = points ** np.arange(s)[:, None]
        self.embedded = np.linalg.solve(powers, moments) - self.tableau.weights
        self.lagrange = np.linalg.inv(powers.T)

    def begin(self, ts: PETSc.TS, z: Array, rate: Array, length: float) -> None:
        """Let TS make these steps from a state on.

        Parameters
        ----------
        ts
            PETSc's time stepper.
        z, rate
            z (sqrt(J)) and z' at the start, ``(coordinates,)`` each.
        length
            Length of the first step (s).
        """
        self._latest = None
        ts.setType("python")
        ts.setPythonContext(self)
        ts.setSolution(PETSc.Vec().createWithArray(np.concatenate([z, rate]), comm=PETSc.COMM_SELF))
        ts.setTimeStep(length)

    def step(self, ts: PETSc.TS) -> None:
        """Make one step, as long as its error allows; TS calls this.

        Parameters
        ----------
        ts
            PETSc's time stepper, whose time (s), length of step (s) and state ``(z, z')`` are taken and moved on.

        Raises
        ------
        SolverError
            When the steps have become too short.
        """
        start, end = ts.getTime(), ts.getMaxTime()
        vector, asked = ts.getSolution(), min(ts.getTimeStep(), self.longest)
        z, rate = vector.array_r.copy().reshape(2, -1)
        largest = STEPPING.largest_change
        while True:
            last = start + asked * (1 + STEPPING.margin) >= end
            length = end - start if last else asked
            made, error = self._trial(start, length, z, rate)
            change = STEPPING.safety * max(error, 1e-12) ** (-1 / (len(self.tableau.points) + 1))
            change = min(max(change, STEPPING.smallest_change), STEPPING.largest_change)
            if self.of_motion and not len(made):  # Newton's method failed: the next step is to be no bolder
                largest = STEPPING.after_failure
            change = min(change, largest)
            cut = self._cut(start, length, z, rate, made) if error <= 1 else None
            if error <= 1 and cut is None:
                break
            if cut is not None:
                asked = cut - start
                continue
            asked = length * change
            if asked < STEPPING.shortest * self.longest:
                grows = _remedied("the motion grows without bound or its equation has no solution there")
                raise SolverError(
                    f"the time steps failed at {start:.6g} s, where they have become {asked:.1e} s long: "
                    f"{self._fault or grows}"
                )
        curve = self._curve(start, length, z, rate, made)
        vector.array[:] = np.concatenate([part[0] for part in curve(np.array([start + length]))])
        self._latest = length, made
        ts.setTime(end if last else start + length)
        ts.setTimeStep(max(asked, length * change) if last else length * change)
        if self.keep(ts.getTime(), curve):
            ts.setConvergedReason(PETSc.TS.ConvergedReason.CONVERGED_USER)

    def _cut(self, start: float, length: float, z: Array, rate: Array, made: Array) -> float | None:
        """Time (s) at which a step has to end that its error would allow; None where it may stand."""
        if self.watch is None:
            return None
        return self.watch(start, start + length, self._curve(start, length, z, rate, made))

    def _trial(self, start: float, length: float, z: Array, rate: Array) -> tuple[Array, float]:
        """Accelerations at the points, and the error over the tolerance."""
        self._fault = ""
        with np.errstate(over="ignore", invalid="ignore"):
            try:
                guesses = [self._guess(length, len(z))]
                if self.from_rest != "never":
                    at_rest = np.zeros_like(guesses[0])
                    guesses = [at_rest, *guesses] if self.from_rest == "first" else [*guesses, at_rest]
                found = next(filter(None, (self._accelerations(start, length, z, rate, one) for one in guesses)), None)
            except (AssemblyError, SolverError, np.linalg.LinAlgError) as fault:  # too long a step to guess
                found, self._fault = None, str(fault) if isinstance(fault, AssemblyError) else _remedied(str(fault))
            if found is not None:
                made, tangents = found
                error = self._error(start, length, (z, rate), made, tuple(part[0] for part in tangents))
                growth = 0.0 if self.equation.linear else largest_growth(tangents[0], tangents[2])
                error = max(error, (length * growth) ** (len(made) + 1))  # a longer step would damp what grows
                if np.isfinite(error):
                    return made, error
        return np.empty(0), np.inf

    def _accelerations(
        self, start: float, length: float, z: Array, rate: Array, found: Array
    ) -> tuple[Array, Tangents] | None:
        """Solve the equation at the points; None where Newton's method does not converge."""
        try:
            return self._by_newton(start, length, z, rate, found)
        finally:
            if self.held is not None:
                self.held.let_go()

    def _by_newton(
        self, start: float, length: float, z: Array, rate: Array, found: Array
    ) -> tuple[Array, Tangents] | None:
        """Solve the equation at the points by Newton's method; None where it does not converge.

        Gives the accelerations, and tangents there. They are made anew where the ones before make slow progress.
        """
        s, n = len(self.tableau.points), len(z)
        limits = STEPPING.newton * self.tolerance * np.array([size for _, size in self.sizes])
        tangents: Tangents | None = None
        before, off = np.inf, 0.0
        here = self._here(start, length, z, rate, found)
        if self.held is not None:
            self.held.hold(*here[:3])
        for _ in range(STEPPING.most_iterations):
            if tangents is None:
                tangents = self.equation.tangents_at(*here)
                matrix = self.tableau.stage_matrix(length, *tangents)
            solved = np.linalg.solve(matrix, -self.equation.residuals(*here).ravel())
            change = np.asarray(solved, dtype=float).reshape(s, n)
            found = found + change
            over = self._over(length, change, tangents, limits)
            here = self._here(start, length, z, rate, found)
            if self.held is not None:
                off = self.held.hold(*here[:3])
            if self.equation.linear or (over <= 1 and off <= STEPPING.sticking):
                return found, tangents
            if off > STEPPING.turned or not over < STEPPING.fast * before:
                tangents = None
            before = over
        return None

    def _here(self, start: float, length: float, z: Array, rate: Array, found: Array) -> tuple[Array, ...]:
        """Times of the points, and z, z' and z'' there by these accelerations."""
        points = self.tableau.points
        rates = rate + length * (self.tableau.inner @ found)
        places = z + length * points[:, None] * rate + length**2 * (self.tableau.square @ found)
        return start + length * points, places, rates, found

    def _over(self, length: float, change: Array, tangents: Tangents, limits: Array) -> float:
        """Size of the last change of the motion by Newton's method, over what it may be."""
        moved = length**2 * (self.tableau.square @ change)
        if not self.of_motion:
            sizes = np.abs(moved)
            return float(max(sizes[:, part].max(initial=0.0) / limit for (part, _), limit in zip(self.sizes, limits)))
        mass, _, stiffness = tangents
        quicker = length * (self.tableau.inner @ change)
        parts = np.einsum("si,sij,sj->s", quicker, mass, quicker), np.einsum("si,sij,sj->s", moved, stiffness, moved)
        return float(np.sqrt(np.abs(parts).sum(axis=0).max()) / limits.min())

    def _guess(self, length: float, size: int) -> Array:
        """Accelerations at the points on the last step's polynomial, where a law makes the equation nonlinear."""
        s = len(self.tableau.points)
        if self._latest is None or self.equation.linear:
            return np.zeros((s, size))
        before, made = self._latest
        ahead = 1 + self.tableau.points * length / before
        return np.asarray(ahead[:, None] ** np.arange(s) @ self.lagrange @ made)

    def _error(
        self, start: float, length: float, state: tuple[Array, Array], made: Array, tangents: tuple[Array, ...]
    ) -> float:
        """Difference from the embedded method, filtered twice by ``(1 - h lead J)^-1``, over the tolerance.

        The filter J needs no exact tangents: those of the first point serve.
        """
        (z, rate), (mass, damping, stiffness) = state, tangents
        first = self.equation.accelerations(np.array([start]), z[None], rate[None])[0]
        rates = rate + length * (self.tableau.inner @ made)
        by_place = length * (self.lead * rate + self.embedded @ rates)
        by_rate = length * (self.lead * first + self.embedded @ made)
        reach = self.lead * length
        matrix = mass + reach * damping + reach**2 * stiffness
        for _ in range(2):
            by_rate = np.linalg.solve(matrix, mass @ by_rate - reach * (stiffness @ by_place))
            by_place = by_place + reach * by_rate

        def energy(part: slice, place: Array, rate: Array) -> float:
            k, m, q, v = stiffness[part, part], mass[part, part], place[part], rate[part]
            return float(np.sqrt(abs(q @ k @ q) + abs(v @ m @ v)))

        shares = [
            energy(part, by_place, by_rate) / max(size, energy(part, 0 * z if self.of_motion else z, rate), 1e-300)
            for part, size in self.sizes
        ]
        return max(shares) / self.tolerance

    def _curve(self, start: float, length: float, z: Array, rate: Array, made: Array) -> StepCurve:
        """The polynomials of the step."""
        return StepCurve(start, length, z, rate, made, self.tableau, self.lagrange @ made)


def _remedied(fault: str) -> str:
    """Say what helps against a fault of forces."""
    return f"{fault}. Give more damping, or lower loads"


def largest_growth(mass: Array, stiffness: Array) -> float:
    """Largest rate at which a motion without vibration grows (1/s), where the stiffness is not positive; else 0.

    Parameters
    ----------
    mass, stiffness
        M and K, ``(instants, coordinates, coordinates)`` each.
    """
    try:
        np.linalg.cholesky(stiffness + stiffness.transpose(0, 2, 1))
    except np.linalg.LinAlgError:
        squares = np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real
        return float(np.sqrt(max(0.0, -squares.min())))
    return 0.0
