"""Springs, dampers and dead loads: a force law over one measure."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.geometry import End
from fenics_mech.terms.term import Look, Measure, Response, Term, diagonal


class Spring(Term):
    """Springs along the line of two places, or about an axis; whole turns are counted.

    Parameters
    ----------
    pairs
        Both ends of each spring.
    stiffness
        N/m, or N m/rad.
    rest
        Length (m) or angle (rad) without force.
    look
        `Look.DISTANCE`, or `Look.ANGLE` for a torsional spring.
    """

    def __init__(
        self, pairs: Sequence[tuple[End, End]], stiffness: float, rest: float, look: Look = Look.DISTANCE
    ) -> None:
        super().__init__(pairs)
        self.stiffness, self.rest, self.measures = stiffness, rest, (Measure(look),)

    def respond(self, t: Array, x: Array, v: Array) -> Response:
        """Give the forces: k (x - x0)."""
        return Response(self.stiffness * (x - self.rest), diagonal(np.full_like(x, self.stiffness)))

    def energy(self, t: Array, x: Array) -> Array:
        """Give the energy: k (x - x0)^2/2."""
        return self.stiffness * np.sum((x - self.rest) ** 2, axis=-1) / 2


class Damper(Term):
    """Dampers along the line of two places, or about an axis.

    Parameters
    ----------
    pairs
        Both ends of each damper.
    factor
        N s/m, or N m s/rad.
    look
        `Look.DISTANCE`, `Look.ANGLE`, or one of the others.
    axis
        The axis of the measure, where it has one.
    """

    def __init__(
        self, pairs: Sequence[tuple[End, End]], factor: float, look: Look = Look.DISTANCE, axis: int = 0
    ) -> None:
        super().__init__(pairs)
        self.factor, self.measures = factor, (Measure(look, axis),)

    def respond(self, t: Array, x: Array, v: Array) -> Response:
        """Give the forces: c v."""
        return Response(self.factor * v, by_rate=diagonal(np.full_like(x, self.factor)))


class DeadLoad(Term):
    """A force that keeps its direction, or a moment in the plane.

    Parameters
    ----------
    ground, end
        An end that rests, and the end that is loaded.
    axis
        Axis of the fixed frame along which it acts; None for a moment.
    force
        N or N m, by time ``(instants,)`` (s).
    """

    def __init__(self, ground: End, end: End, axis: int | None, force: Callable[[Array], Array]) -> None:
        super().__init__([(ground, end)])
        self.force = force
        self.measures = (Measure(Look.ANGLE) if axis is None else Measure(Look.PLACE, axis),)

    def respond(self, t: Array, x: Array, v: Array) -> Response:
        """Give minus the load, as stresses act against their measures."""
        return Response(np.broadcast_to(-np.asarray(self.force(t))[:, None, None], x.shape))
