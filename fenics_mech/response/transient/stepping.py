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

import numpy as np
from petsc4py import PETSc

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.transient.instant import Instant, growth

Curve = Callable[[Array], tuple[Array, Array]]  # z and z' at times (s), (times, coordinates) each
Keep = Callable[[float, float, Curve], bool]  # takes a step's start and end (s) and its motion; says whether to stop


@dataclass(frozen=True)
class StepLimits:
    """Limits of Newton's method in a time step."""

    most_iterations: int = 10  # of Newton's method in a step
    newton: float = 1e-3  # of the tolerance of a step, to which it is solved
    shortest: float = 1e-10  # step, of the longest
    margin: float = 1e-9  # of a step, that is not left over at the end
    smallest_change: float = 0.2  # factor of a step's length from one step to the next
    largest_change: float = 5.0  # the same
    safety: float = 0.9  # of the length that the error allows


STEPPING = StepLimits()


@dataclass
class Collocation:
    """Steps of the state ``(z, z')`` of the equation at an `instant`.

    Parameters
    ----------
    instant
        The equation.
    tableau
        The collocation points.
    tolerance, size
        Error of a step, and what it is relative to: the root of an energy (sqrt(J)).
    longest
        Longest step (s).
    keep
        Is called with every step.
    """

    instant: Instant
    tableau: Tableau
    tolerance: float
    size: float
    longest: float
    keep: Keep
    _latest: tuple[float, Array] | None = field(default=None)  # length and accelerations of the last step

    def __post_init__(self) -> None:
        """Find the embedded method of order s, which has the start as a further point."""
        points, s = self.tableau.points, len(self.tableau.points)
        self.lead = float(np.linalg.det(self.tableau.inner) ** (1 / s))
        moments = 1 / np.arange(1, s + 1)
        moments[0] -= self.lead
        powers = points ** np.arange(s)[:, None]
        self.embedded = np.linalg.solve(powers, moments) - self.tableau.weights
        self.lagrange = np.linalg.inv(powers.T)

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
        while True:
            last = start + asked * (1 + STEPPING.margin) >= end
            length = end - start if last else asked
            made, error = self._trial(start, length, z, rate)
            change = STEPPING.safety * max(error, 1e-12) ** (-1 / (len(self.tableau.points) + 1))
            change = min(max(change, STEPPING.smallest_change), STEPPING.largest_change)
            if error <= 1:
                break
            asked = length * change
            if asked < STEPPING.shortest * self.longest:
                raise SolverError(
                    f"the time steps failed at {start:.6g} s, where they have become {asked:.1e} s long: the motion "
                    "grows without bound or its equation has no solution there. Give more damping, or lower loads"
                )
        curve = self._curve(start, length, z, rate, made)
        vector.array[:] = np.concatenate([part[0] for part in curve(np.array([start + length]))])
        self._latest = length, made
        ts.setTime(end if last else start + length)
        ts.setTimeStep(max(asked, length * change) if last else length * change)
        if self.keep(start, ts.getTime(), curve):
            ts.setConvergedReason(PETSc.TS.ConvergedReason.CONVERGED_USER)

    def _trial(self, start: float, length: float, z: Array, rate: Array) -> tuple[Array, float]:
        """Accelerations at the points, and the error over the tolerance."""
        with np.errstate(over="ignore", invalid="ignore"):
            found = self._accelerations(start, length, z, rate)
            if found is not None:
                made, growth = found
                error = self._error(start, length, z, rate, made)
                error = max(error, (length * growth) ** (len(made) + 1))  # a longer step would damp what grows
                if np.isfinite(error):
                    return made, error
        return np.empty(0), np.inf

    def _accelerations(self, start: float, length: float, z: Array, rate: Array) -> tuple[Array, float] | None:
        """Solve the equation at the points by Newton's method; None where it does not converge.

        Gives the accelerations, and the rate at which a nonlinear law lets a motion grow (1/s); that of the linear
        equation limits the longest step.
        """
        points, inner = self.tableau.points, self.tableau.inner
        s, n = len(points), len(z)
        found = self._guess(length, n)
        for _ in range(STEPPING.most_iterations):
            rates = rate + length * (inner @ found)
            places = z + length * points[:, None] * rate + length**2 * (self.tableau.square @ found)
            residual, tangents = [], []
            for here in zip(start + length * points, places, rates, found):
                residual.append(self.instant.residual(*here))
                tangents.append(self.instant.tangents(*here[:3]))
            matrix = self.tableau.stage_matrix(length, *(np.stack(part) for part in zip(*tangents)))
            change = np.linalg.solve(matrix, -np.concatenate(residual)).reshape(s, n)
            found = found + change
            moved = np.abs(length**2 * (self.tableau.square @ change)).max()
            if self.instant.coefficients.law is None:
                return found, 0.0
            if moved <= STEPPING.newton * self.tolerance * self.size:
                mass, _, stiffness = (np.stack(part) for part in zip(*tangents))
                return found, growth(mass, stiffness)
        return None

    def _guess(self, length: float, size: int) -> Array:
        """Accelerations at the points on the last step's polynomial, where a law makes the equation nonlinear."""
        s = len(self.tableau.points)
        if self._latest is None or self.instant.coefficients.law is None:
            return np.zeros((s, size))
        before, made = self._latest
        ahead = 1 + self.tableau.points * length / before
        return np.asarray(ahead[:, None] ** np.arange(s) @ self.lagrange @ made)

    def _error(self, start: float, length: float, z: Array, rate: Array, made: Array) -> float:
        """Difference from the embedded method, filtered twice by ``(1 - h lead J)^-1``, over the tolerance."""
        mass, damping, stiffness = self.instant.tangents(start, z, rate)
        first = self.instant.acceleration(start, z, rate)
        rates = rate + length * (self.tableau.inner @ made)
        by_place = length * (self.lead * rate + self.embedded @ rates)
        by_rate = length * (self.lead * first + self.embedded @ made)
        reach = self.lead * length
        matrix = mass + reach * damping + reach**2 * stiffness
        for _ in range(2):
            by_rate = np.linalg.solve(matrix, mass @ by_rate - reach * (stiffness @ by_place))
            by_place = by_place + reach * by_rate

        def energy(place: Array, rate: Array) -> float:
            return float(np.sqrt(abs(place @ stiffness @ place) + abs(rate @ mass @ rate)))

        whole = max(self.size, energy(z, rate), 1e-300)
        return energy(by_place, by_rate) / (self.tolerance * whole)

    def _curve(self, start: float, length: float, z: Array, rate: Array, made: Array) -> Curve:
        """The polynomials of the step."""
        orders = np.arange(len(made))
        coefficients = self.lagrange @ made

        def curve(times: Array) -> tuple[Array, Array]:
            place = (times - start)[:, None]
            powers = (place / length) ** orders
            rates = rate + place * ((powers / (orders + 1)) @ coefficients)
            places = z + place * rate + place**2 * ((powers / ((orders + 1) * (orders + 2))) @ coefficients)
            return places, rates

        return curve
