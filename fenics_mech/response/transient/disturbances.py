"""Small disturbances beside a motion in time, carried through its steps: multipliers and Lyapunov exponents.

The equation linearised about the motion is solved by the collocation of the steps themselves. So the disturbance is
that of the motion as it is computed. Disturbances that are followed for long are made orthogonal again and again, and
what they have grown by is summed up.

Source: Benettin, Galgani, Giorgilli and Strelcyn, Meccanica 15 (1980), p. 21; Parker and Chua, Practical Numerical
Algorithms for Chaotic Systems (1989), chapters 3 and 4.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.static.small_motions import RestEquation
from fenics_mech.response.transient.stepping import StepCurve


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

    equation: RestEquation
    tableau: Tableau
    states: Array

    def take(self, step: StepCurve) -> None:
        """Carry the disturbances through a step.

        Parameters
        ----------
        step
            The step, near to where the equation is.
        """
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
        second = -np.linalg.solve(matrix, left.reshape(-1, left.shape[-1])).reshape(left.shape)
        once = self.tableau.weights
        self.states = np.concatenate(
            [
                place + h * speed + h**2 * np.einsum("s,scd->cd", once @ inner, second),
                speed + h * np.einsum("s,scd->cd", once, second),
            ]
        )


@dataclass
class Growth(Transition):
    """Follows how fast disturbances grow, however far a motion goes.

    Parameters
    ----------
    of_each
        Time (s), and logarithm of what each disturbance has grown by since the start, at the end of each step.
    """

    of_each: list[tuple[float, Array]] = field(default_factory=list)

    def take(self, step: StepCurve) -> None:
        """Carry the disturbances through a step, and make them orthogonal.

        Parameters
        ----------
        step
            The step, near to where the equation is.
        """
        super().take(step)
        self.states, triangle = np.linalg.qr(self.states)
        grown = np.log(np.maximum(np.abs(np.diag(triangle)), TINY))
        before = self.of_each[-1][1] if self.of_each else 0.0
        self.of_each.append((step.start + step.length, before + grown))
