"""Springs, dampers and dead loads: a force law over one measure."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.geometry import PLANE, End
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
    near
        Angle within half a turn of that of the springs, by time ``(instants,)``; without it they are within half a turn
        of 0, or of the angle that the residual is given.
    """

    def __init__(
        self,
        pairs: Sequence[tuple[End, End]],
        stiffness: float,
        rest: float,
        look: Look = Look.DISTANCE,
        near: Callable[[Array], Array] | None = None,
    ) -> None:
        super().__init__(pairs)
        self.stiffness, self.rest, self.measures, self._near = stiffness, rest, (Measure(look),), near

    def near(self, t: Array) -> Array | None:
        """Give angles near those of the springs."""
        if self._near is None:
            return None
        return np.broadcast_to(self._near(t)[:, None, None], (len(t), len(self.pairs), 1))

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


class Shaft(Term):
    """A shaft that twists between a law of its angle and what it turns.

    Parameters
    ----------
    pair
        Ends between which the angle is.
    stiffness, damping
        N m/rad, and N m s/rad.
    law
        The angle without moment, by time ``(instants,)`` (s).
    rate
        That of the law, which is constant (rad/s).
    """

    measures = (Measure(Look.ANGLE),)

    def __init__(
        self, pair: tuple[End, End], stiffness: float, damping: float, law: Callable[[Array], Array], rate: float
    ) -> None:
        super().__init__([pair])
        self.stiffness, self.damping, self.law, self.rate = stiffness, damping, law, rate

    def near(self, t: Array) -> Array:
        """Give the angles without moment."""
        return np.asarray(self.law(t)[:, None, None])

    def respond(self, t: Array, x: Array, v: Array) -> Response:
        """Give the moments: k (x - law) + c (v - rate)."""
        stress = self.stiffness * (x - self.near(t)) + self.damping * (v - self.rate)
        by_measure, by_rate = (diagonal(np.full_like(x, factor)) for factor in (self.stiffness, self.damping))
        return Response(stress, by_measure, by_rate)

    def energy(self, t: Array, x: Array) -> Array:
        """Give the energy: k (x - law)^2/2."""
        return self.stiffness * np.sum((x - self.near(t)) ** 2, axis=-1) / 2


class Effort(Term):
    """A torque or force of a law at a joint, on the second end, with the opposite one on the first.

    Parameters
    ----------
    pair, measure
        Ends, and the measure that is the joint's angle or stroke.
    law
        Gives the effort (N m or N) and its derivatives by the measure and its rate, by time, measure and rate
        ``(instants,)``.
    start
        Angle within half a turn of that at the start (rad).
    """

    def __init__(
        self,
        pair: tuple[End, End],
        measure: Measure,
        law: Callable[[Array, Array, Array], tuple[Array, Array, Array]],
        start: float,
    ) -> None:
        super().__init__([pair])
        self.measures, self.law, self.start = (measure,), law, start

    def near(self, t: Array) -> Array:
        """Give the angle at the start: steps in time count whole turns from it."""
        return np.full((len(t), 1, 1), self.start)

    def respond(self, t: Array, x: Array, v: Array) -> Response:
        """Give minus the effort, as stresses act against their measures."""
        stress, by_measure, by_rate = (-part[:, None, None] for part in self.law(t, x[:, 0, 0], v[:, 0, 0]))
        return Response(stress, diagonal(by_measure), diagonal(by_rate))


class SoftBearing(Term):
    """A bushing in place of a pin in the plane: stiffness and damping along the axes of the first end, and in rotation.

    Parameters
    ----------
    pair
        The ends.
    stiffness, damping
        Along both axes (N/m, N s/m) and in rotation (N m/rad, N m s/rad).
    turned
        Rotation without moment (rad).
    start
        Angle within half a turn of that at the start (rad).
    """

    measures = (Measure(Look.ALONG, 0), Measure(Look.ALONG, 1), Measure(Look.ANGLE))

    def __init__(
        self, pair: tuple[End, End], stiffness: Sequence[float], damping: Sequence[float], turned: float, start: float
    ) -> None:
        super().__init__([pair])
        self.stiffness, self.damping = np.array(stiffness), np.array(damping)
        self.rest, self.start = np.array([0.0, 0.0, turned]), np.array([0.0, 0.0, start])

    def near(self, t: Array) -> Array:
        """Give the angle at the start: steps in time count whole turns from it."""
        return np.tile(self.start, (len(t), 1, 1))

    def respond(self, t: Array, x: Array, v: Array) -> Response:
        """Give forces and moment: k (x - x0) + c v."""
        by_measure, by_rate = (diagonal(np.broadcast_to(factor, x.shape)) for factor in (self.stiffness, self.damping))
        return Response(self.stiffness * (x - self.rest) + self.damping * v, by_measure, by_rate)


class PointLoad(Term):
    """A force and a moment at an end in the plane, times a factor over time.

    Parameters
    ----------
    ground, end
        An end that rests in the axes of the fixed frame, and the end that is loaded.
    force, moment
        N, N m.
    factor
        By time ``(instants,)`` (s).
    follows
        Whether the force is given in the axes of the end, and turns with them.
    """

    measures = (Measure(Look.PLACE, 0), Measure(Look.PLACE, 1), Measure(Look.ANGLE))
    external = True

    def __init__(
        self,
        ground: End,
        end: End,
        force: Sequence[float],
        moment: float,
        factor: Callable[[Array], Array],
        follows: bool = False,
    ) -> None:
        super().__init__([(ground, end)])
        self.force, self.moment, self.factor, self.follows = np.asarray(force, dtype=float), moment, factor, follows

    def respond(self, t: Array, x: Array, v: Array) -> Response:
        """Give minus the load; one that follows turns with the angle."""
        turn = PLANE.turn(x[..., 2:]) if self.follows else np.eye(2)
        force = np.broadcast_to(turn @ self.force, (*x.shape[:2], 2))
        factor = np.asarray(self.factor(t))[:, None, None]
        stress = -factor * np.concatenate([force, np.full_like(x[..., :1], self.moment)], axis=-1)
        by_measure = np.zeros((*x.shape, 3))
        if self.follows:
            by_measure[..., :2, 2] = -factor * (force @ PLANE.skew(np.ones(1)).T)
        return Response(stress, by_measure)


class OverState(Term):
    """A load times a factor that goes by a measure of two other ends, such as the angle of a joint, and by its rate.

    Parameters
    ----------
    load
        The load for the factor 1: a single element.
    pair, measure
        The ends, and the measure.
    factor
        Gives the factor and its derivatives by the measure and its rate, by time, measure and rate ``(instants,)``.
    near
        Angle within half a turn of the measure, by time ``(instants,)``.
    """

    together = 2
    external = True

    def __init__(
        self,
        load: PointLoad,
        pair: tuple[End, End],
        measure: Measure,
        factor: Callable[[Array, Array, Array], tuple[Array, Array, Array]],
        near: Callable[[Array], Array] | None = None,
    ) -> None:
        super().__init__([*load.pairs, pair])
        self.load, self.measure, self.factor, self._near = load, measure, factor, near

    @property
    def looks(self) -> Sequence[Sequence[Measure]]:
        """Measures of the load, and of the other ends."""
        return [self.load.measures, [self.measure] * len(self.load.measures)]

    def near(self, t: Array) -> Array | None:
        """Give angles near those of the other ends."""
        if self._near is None:
            return None
        count = len(self.load.measures)
        return np.stack([np.zeros((len(t), count)), np.tile(self._near(t)[:, None], count)], axis=1)

    def respond(self, t: Array, x: Array, v: Array) -> Response:
        """Give the load's stresses times the factor, and none on the other ends."""
        one, count = self.load.respond(t, x[:, :1], v[:, :1]), x.shape[2]
        factor, by_measure, by_rate = self.factor(t, x[:, 1, 0], v[:, 1, 0])
        stress, across = np.zeros(x.shape), np.zeros((2, len(t), 1, 2 * count, 2 * count))
        stress[:, 0] = factor[:, None] * one.stress[:, 0]
        assert one.by_measure is not None
        across[0, :, 0, :count, :count] = factor[:, None, None] * one.by_measure[:, 0]
        for derivative, by in zip(across, (by_measure, by_rate)):
            derivative[:, 0, :count, count] = by[:, None] * one.stress[:, 0]
        return Response(stress, *across)


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

    external = True

    def __init__(self, ground: End, end: End, axis: int | None, force: Callable[[Array], Array]) -> None:
        super().__init__([(ground, end)])
        self.force = force
        self.measures = (Measure(Look.ANGLE) if axis is None else Measure(Look.PLACE, axis),)

    def respond(self, t: Array, x: Array, v: Array) -> Response:
        """Give minus the load, as stresses act against their measures."""
        return Response(np.broadcast_to(-np.asarray(self.force(t))[:, None, None], x.shape))
