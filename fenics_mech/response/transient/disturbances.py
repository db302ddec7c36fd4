"""Small disturbances beside a motion in time, carried through its steps: multipliers and Lyapunov exponents.

The equation linearised about the motion is solved by the collocation of the steps themselves. So the disturbance is
that of the motion as it is computed. Disturbances that are followed for long are made orthogonal again and again, and
what they have grown by is summed up.

Source: Benettin, Galgani, Giorgilli and Strelcyn, Meccanica 15 (1980), p. 21; Parker and Chua, Practical Numerical
Algorithms for Chaotic Systems (1989), chapters 3 and 4.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.transient.stepping import StepCurve


class EquationOfMotion(Protocol):
    """An equation of motion as the solver of `stepping` knows it."""

    def residuals(self, time: Array, place: Array, rate: Array, second: Array) -> Array:
        """What is left of it, ``(times, coordinates)``."""

    def tangents_at(self, time: Array, place: Array, rate: Array, second: Array) -> tuple[Array, Array, Array]:
        """Tangents by the second derivative, the rate and the place, ``(times, coordinates, coordinates)`` each."""


@dataclass
class Transition:
    """Carries the state's disturbances from a start on.

    Parameters
    ----------
    equation
        The equation of the motion.
    tableau
        The collocation points of its steps.
    states
        Disturbances of ``(z, z')``, one a column, ``(2 coordinates, disturbances)``.
    """

    equation: EquationOfMotion
    tableau: Tableau
    states: Array

    def take(self, step: StepCurve) -> None:
        """Carry the disturbances through a step.

        Parameters
        ----------
        step
            The step, near to where the equation is.
        """
        self._carry(step, self._seconds(step))

    def _carry(self, step: StepCurve, second: Array) -> None:
        (place, speed), once = np.split(self.states, 2), self.tableau.weights
        h, twice = step.length, once @ self.tableau.inner
        self.states = np.concatenate(
            [
                place + h * speed + h**2 * np.einsum("s,scd->cd", twice, second),
                speed + h * np.einsum("s,scd->cd", once, second),
            ]
        )

    def _seconds(self, step: StepCurve) -> Array:
        """Give the accelerations of the disturbances at the points ``(points, coordinates, disturbances)``."""
        points, inner, square = self.tableau.points, self.tableau.inner, self.tableau.square
        h, z, rate, made = step.length, step.place, step.rate, step.made
        tangents = self.equation.tangents_at(
            step.start + h * points,
            z + h * points[:, None] * rate + h**2 * (square @ made),
            rate + h * (inner @ made),
            made,
        )
        _, damping, stiffness = tangents
        place, speed = np.split(self.states, 2)
        ahead = place + h * points[:, None, None] * speed
        left = damping @ speed + stiffness @ ahead
        matrix = self.tableau.stage_matrix(h, *tangents)
        return np.asarray(-np.linalg.solve(matrix, left.reshape(-1, left.shape[-1])).reshape(left.shape))

    def _inside(self, step: StepCurve, second: Array, times: Array) -> Array:
        """Give the disturbances at instants in a step (s), ``(times, 2 coordinates, disturbances)``."""
        h, share, (place, speed) = step.length, (times - step.start)[:, None] / step.length, np.split(self.states, 2)
        orders = np.arange(1, len(self.tableau.points) + 1)
        made = np.linalg.inv(np.vander(self.tableau.points, increasing=True))
        polynomials = np.tensordot(made, second, 1)
        once, twice = share**orders / orders, share ** (orders + 1) / (orders * (orders + 1))
        places = place + h * share[..., None] * speed + h**2 * np.tensordot(twice, polynomials, 1)
        return np.concatenate([places, speed + h * np.tensordot(once, polynomials, 1)], axis=1)


@dataclass
class Growth(Transition):
    """Follows how fast disturbances grow, however far a motion goes.

    Parameters
    ----------
    times
        Instants at which the growth is wanted too: it is no straight line between the ends of steps ``(times,)`` (s).
    of_each
        Time (s), and logarithm of what each disturbance has grown by since the start, there and at the ends of steps.
    """

    times: Array
    of_each: list[tuple[float, Array]] = field(default_factory=list)

    def take(self, step: StepCurve) -> None:
        """Carry the disturbances through a step, and make them orthogonal.

        Parameters
        ----------
        step
            The step, near to where the equation is.
        """
        second, end = self._seconds(step), step.start + step.length
        before = self.of_each[-1][1] if self.of_each else 0.0
        if len(due := self.times[(self.times > step.start) & (self.times < end)]):
            inside = np.linalg.qr(self._inside(step, second, due))[1]
            self.of_each += [(float(t), before + _grown(triangle)) for t, triangle in zip(due, inside)]
        self._carry(step, second)
        self.states, triangle = np.linalg.qr(self.states)
        self.of_each.append((end, before + _grown(triangle)))


def _grown(triangle: Array) -> Array:
    """Give logarithms of what disturbances have grown by, by the triangle of their QR factorisation."""
    return np.asarray(np.log(np.maximum(np.abs(np.diag(triangle)), TINY)))


def quarters_of(times: Array) -> Array:
    """Give where the last two quarters of a motion begin and end (s), whose growth makes the exponents.

    Parameters
    ----------
    times
        Instants of the result, ascending ``(times,)`` (s).
    """
    return np.linspace(times[0], times[-1], 5)[2:]
