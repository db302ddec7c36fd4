"""Rates of P at collocation points, where a slider turns with the member that it travels along.

It turns with the slope of its element, w'. As it passes a node at a speed v, its rate of rotation jumps by v times the
jump of w'', and P' jumps with it. Momentum goes on, ``M jump(q') = -P^T m jump(P') q``, and so q' jumps too. P'' at the
points does not show that. Here P'' is a little more, so that its integrals over each step are the change of P' and, of
the second order, that of P. So the blow on q' is spread over its step, and keeps its moment. P' follows by quadrature.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.kinematics import Motion
from fenics_mech.mechanism.system import System
from fenics_mech.mechanism.transformation import Transformation
from fenics_mech.scene import Prismatic


@dataclass(frozen=True)
class PointsInSteps:
    """Collocation points in the steps of a cycle.

    Parameters
    ----------
    starts
        The motion at the starts of the steps, in the order of time.
    duration
        How long each step takes (s), ``(steps,)``.
    places, inner, weights
        The points c and the coefficients A and b of the method, as `Tableau` has them.
    """

    starts: Motion
    duration: Array
    places: Array
    inner: Array
    weights: Array


@dataclass(frozen=True, kw_only=True)
class TransformationInSteps(Transformation):
    """P(theta) with rates at points that are in balance with its values at the ends of steps.

    Parameters
    ----------
    inside
        The points in their steps.
    at_points
        The motion at these points. In any other motion rates are those of P itself.
    """

    inside: PointsInSteps
    at_points: Motion

    def derivatives(self, motion: Motion) -> tuple[Array, Array]:
        """Nonzeros of the first and second time derivative of P, each ``(angles, nonzeros)`` (1/s, 1/s^2).

        Parameters
        ----------
        motion
            The rigid motion.
        """
        first, second = super().derivatives(motion)
        inside, starts = self.inside, self.inside.starts.path
        if starts is None or motion.path is None or motion.path is not self.at_points.path:
            return first, second
        begun = starts.motion(motion.rate)
        h = (self.at_points.rate / motion.rate * inside.duration)[:, None]
        c, b = inside.places, inside.weights
        p, rate = self.values(begun), super().derivatives(begun)[0]
        found = second.reshape(len(h), len(c), -1)
        of_rate = (np.roll(rate, -1, axis=0) - rate) / h - b @ found  # missing of the mean of P''
        of_value = ((np.roll(p, -1, axis=0) - p) / h - rate) / h - (b * (1 - c)) @ found
        moments = b * (1 - c) ** np.arange(min(len(c), 2))[:, None]
        shares = np.linalg.pinv(moments)  # the least change of P'' that has them
        found = found + np.einsum("im,mkn->kin", shares, np.stack([of_rate, of_value])[: len(moments)])
        rates = rate[:, None] + h[:, None] * (inside.inner @ found)
        return rates.reshape(first.shape), found.reshape(second.shape)


def turning_sliders(system: System) -> list[str]:
    """Name the joints whose slider turns with a member that it travels along, past nodes.

    Parameters
    ----------
    system
        The mechanism.
    """
    mesh = system.beams.mesh
    return [
        name
        for name, contact in system.transformation.constraints.contacts.items()
        if isinstance(contact.slot, Prismatic) and np.count_nonzero(mesh.cell_member == contact.member) > 1
    ]


def in_steps(system: System, inside: PointsInSteps) -> System:
    """Give a mechanism at collocation points, with rates of P that have the jumps in their steps.

    Parameters
    ----------
    system
        The mechanism at the points.
    inside
        The points in their steps.
    """
    parts = {part.name: getattr(system.transformation, part.name) for part in fields(Transformation)}
    return replace(system, transformation=TransformationInSteps(**parts, inside=inside, at_points=system.motion))
