"""Drives that move from rest to rest and back, with dwells between the moves."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.scene.base import Part
from fenics_mech.scene.formulas.expression import Jet
from fenics_mech.scene.units import AngleOrLength

Share = Annotated[float, Field(ge=0, le=1)]

POLYNOMIALS = {  # coefficients of the share of the way, by powers of the share of the time
    "polynomial-3-4-5": np.polynomial.Polynomial([0, 0, 0, 10, -15, 6]),
    "polynomial-4-5-6-7": np.polynomial.Polynomial([0, 0, 0, 0, 35, -84, 70, -20]),
}
PARTS = 32  # of each move and dwell, in which six points integrate the square of a sine to rounding


class RestToRest(Part):
    """A law of a drive that goes from one place of rest to another and comes back, with dwells between.

    The acceleration is continuous, and with `polynomial-4-5-6-7` its rate too. Outside of both moves the drive dwells.
    Source: Norton, Design of Machinery, chapter 8.

    Parameters
    ----------
    start, end
        Angles (rad) or strokes (m) between which the drive moves.
    out
        Shares of the cycle at which the move to `end` begins and ends.
    back
        Shares of the cycle at which the move back to `start` begins and ends.
    profile
        Law of a move: `polynomial-3-4-5`, `polynomial-4-5-6-7` or `cycloidal`.

    Examples
    --------
    >>> move = fm.RestToRest(start="0 deg", end="90 deg", out=(0.1, 0.3), back=(0.6, 0.8))
    >>> fm.Drive(joint="O", law=move, period="2 s").law.kind
    'rest-to-rest'
    """

    kind: Literal["rest-to-rest"] = "rest-to-rest"
    start: AngleOrLength = 0.0
    end: AngleOrLength
    out: tuple[Share, Share]
    back: tuple[Share, Share]
    profile: Literal["polynomial-3-4-5", "polynomial-4-5-6-7", "cycloidal"] = "polynomial-3-4-5"

    def _check_keys(self) -> None:
        (begin, there), (leave, home) = self.out, self.back
        if not (begin < there <= leave < home):
            raise ValueError(
                f"out = [{begin:g}, {there:g}] and back = [{leave:g}, {home:g}] must be shares of the cycle that "
                "increase: each move ends after it begins, and back begins when out has ended"
            )
        if self.start == self.end:
            raise ValueError(f"start and end are both {self.start:g}: the drive would not move")

    @property
    def edges(self) -> Array:
        """Ascending angles (rad) from 0 to 2 pi, between which the law is smooth, ``(pieces + 1,)``."""
        corners = np.unique([0.0, *self.out, *self.back, 1.0])
        parts = [np.linspace(a, b, PARTS, endpoint=False) for a, b in pairwise(corners)]
        return TURN * np.append(np.concatenate(parts), 1.0)

    def jet(self, theta: Array) -> Jet:
        """Value and two derivatives by theta (rad), of the shape of theta."""
        share, way = np.mod(theta, TURN) / TURN, self.end - self.start
        orders = []
        for order in range(3):
            value = np.zeros_like(share)
            for (begin, end), sign in ((self.out, 1), (self.back, -1)):
                passed = np.clip((share - begin) / (end - begin), 0.0, 1.0)
                value += sign * _way(self.profile, order, passed) / (TURN * (end - begin)) ** order
            orders.append(way * value + (0.0 if order else self.start))
        return Jet(*orders)


def _way(profile: str, order: int, time: Array) -> Array:
    """Give the share of the way, or a derivative of it, over the share of the time; derivatives are 0 at its ends."""
    if profile in POLYNOMIALS:
        law = POLYNOMIALS[profile]
        return np.asarray((law.deriv(order) if order else law)(time))
    by_order = (
        lambda: time - np.sin(TURN * time) / TURN,
        lambda: 1 - np.cos(TURN * time),
        lambda: TURN * np.sin(TURN * time),
    )
    return np.asarray(by_order[order]())
