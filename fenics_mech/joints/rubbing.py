"""Dry friction of a joint as a term, whose normal force is that of the joint: the multipliers of its rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.geometry import End
from fenics_mech.joints.dry_friction import held_at, largest, line
from fenics_mech.scene import Friction
from fenics_mech.terms import Measure, Response, Term
from fenics_mech.terms.term import diagonal

SLIDES = 2.0  # widths, at which friction is within 4 % of its limit
STEP = 1e-4  # of Stribeck's speed, for the slope of its fall


class Rubbing(Term):
    """Dry friction at a pin or a slider, with its viscous share."""

    # Newton's method takes it as an unknown of its own: where it sticks, a small change of the speed goes from one
    # limit to the other. It is held on its law where the last step predicted it, and it is linear in the speed about
    # there.

    def __init__(
        self, pair: tuple[End, End], measure: Measure, stated: Friction, rows: Sequence[int], start: float
    ) -> None:
        # start (rad)
        super().__init__([pair])
        self.measures, self.stated, self.rows, self.start = (measure,), stated, tuple(rows), start
        self.held: float | None = None  # friction on the second body at rest, which holds it (N m, N)

    def near(self, t: Array) -> Array:
        """Give the angle at the start: steps in time count whole turns from it."""
        return np.full((len(t), 1, 1), self.start)

    def turned_unseen(self, rate: Array) -> bool:
        """Say whether sliding turned round between instants, which do not show how friction changed ``(instants,)``."""
        scaled = ((self.stated.radius or 1.0) * rate - self.stated.belt_speed) / self.stated.width
        return bool(
            ((scaled[1:] * scaled[:-1] < 0) & (np.abs(scaled[1:]) > SLIDES) & (np.abs(scaled[:-1]) > SLIDES)).any()
        )

    def respond(
        self, t: Array, x: Array, v: Array, pulls: Array | None = None, predicted: Array | None = None
    ) -> Response:
        """Give minus the friction on the second body: its coefficient times the size of the joint's force."""
        # pulls (instants, rows) (N)
        if self.held is not None:
            return Response(np.full_like(x, -self.held))
        assert pulls is not None
        stated, rate = self.stated, v[:, 0, 0]
        arm, drag = stated.radius or 1.0, stated.viscous * rate
        sliding = arm * rate - stated.belt_speed
        force = np.sqrt(np.sum(pulls**2, axis=1))
        limit = arm * largest(stated, sliding) * force
        scaled = sliding / stated.width
        held, dry = scaled, np.zeros_like(scaled)  # nothing is predicted before the first step
        if predicted is not None:
            dry = predicted[:, 0, 0] - drag
            held = held_at(dry / np.maximum(limit, TINY), scaled)
        share, slope = line(held, scaled), 1 - np.tanh(held) ** 2
        least, step = np.maximum(force, TINY), STEP * (stated.stribeck or stated.width)
        fall = (largest(stated, sliding + step) - largest(stated, sliding - step)) / (2 * step)
        by_rate = arm * (limit * slope / stated.width + arm * fall * force * share) + stated.viscous
        by_pulls = (limit * share / least)[:, None] * (pulls / least[:, None])
        return Response(
            (limit * share + drag)[:, None, None],
            by_rate=diagonal(by_rate[:, None, None]),
            by_pulls=by_pulls[:, None, None],
            off=float(np.abs(dry - limit * np.tanh(scaled)).max()),
            limit=float(limit.max()),
        )
