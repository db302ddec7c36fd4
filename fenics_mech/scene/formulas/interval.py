"""Bounds of a formula over a range of its variable by interval arithmetic: what no set of samples can tell.

Source: Moore, Kearfott and Cloud, Introduction to Interval Analysis (2009), ch. 2 and 6.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech.scene.formulas.expression import FUNCTIONS, Arithmetic, Formula, Jet, jet_functions

CELLS = 256  # that a range is first cut into
DEEPEST = 40  # times that a cell is halved: 1e-12 of it is left
MOST_CELLS = 4096  # without bounds: beyond it the formula is not finite on a whole range
ROUNDING = 1e-9  # by which a square root's argument may seem to be negative where it is 0


@dataclass(frozen=True)
class Interval(Arithmetic):
    """Numbers from `low` to `high`, arrays of one shape; from -inf to inf where nothing is known."""

    low: Array
    high: Array

    @classmethod
    def around(cls, *values: Array) -> Interval:
        """Give the smallest interval with all values in it; no bounds where one of them is no number."""
        low, high = np.minimum.reduce(values), np.maximum.reduce(values)
        return cls(np.where(np.isnan(low), -np.inf, low), np.where(np.isnan(high), np.inf, high))

    @property
    def bounded(self) -> NDArray[np.bool_]:
        """Whether both bounds are finite."""
        return np.isfinite(self.low) & np.isfinite(self.high)

    def _holds(self, start: float, step: float) -> NDArray[np.bool_]:
        """Whether one of the numbers ``start + k step``, k whole, lies inside."""
        return np.floor((self.high - start) / step) >= np.ceil((self.low - start) / step)

    def _other(self, other: Interval | float) -> Interval:
        return other if isinstance(other, Interval) else Interval.around(np.full_like(self.low, other))

    def __add__(self, other: Interval | float) -> Interval:
        o = self._other(other)
        return Interval.around(self.low + o.low, self.high + o.high)

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __mul__(self, other: Interval | float) -> Interval:
        o = self._other(other)
        return Interval.around(self.low * o.low, self.low * o.high, self.high * o.low, self.high * o.high)

    def __pow__(self, power: float) -> Interval:
        p = float(power)
        if p % 1:
            return self._from_zero(lambda x: x**p) if p > 0 else (self._from_zero(np.log) * p)._rising(np.exp)
        ends = Interval.around(self.low**p, self.high**p)
        inside = (self.low <= 0) & (self.high >= 0)
        if p < 0:
            return Interval(np.where(inside, -np.inf, ends.low), np.where(inside, np.inf, ends.high))
        return ends if p % 2 or p == 0 else Interval(np.where(inside, 0.0, ends.low), ends.high)

    def _from_zero(self, f: Callable[[Array], Array]) -> Interval:
        """Values of an increasing function of positive numbers; no bounds where some are negative."""
        negative = self.low < -ROUNDING * (1 + np.abs(self.high))
        low, high = f(np.maximum(self.low, 0)), f(np.maximum(self.high, 0))
        return Interval(np.where(negative, -np.inf, low), np.where(negative, np.inf, high))

    def _wave(self, f: Callable[[Array], Array], crest: float) -> Interval:
        """Values of a sine of which one maximum is at `crest` (rad)."""
        ends = Interval.around(f(self.low), f(self.high))
        low = np.where(self._holds(crest + np.pi, 2 * np.pi), -1.0, ends.low)
        return self._kept(Interval(low, np.where(self._holds(crest, 2 * np.pi), 1.0, ends.high)))

    def tan(self) -> Interval:
        """Values of the tangent; no bounds over a pole."""
        pole = self._holds(np.pi / 2, np.pi)
        low, high = np.tan(self.low), np.tan(self.high)
        return self._kept(Interval(np.where(pole, -np.inf, low), np.where(pole, np.inf, high)))

    def _rising(self, f: Callable[[Array], Array]) -> Interval:
        """Values of an increasing function."""
        return self._kept(Interval(f(self.low), f(self.high)))

    def _kept(self, values: Interval) -> Interval:
        """Values of a function of this interval, without bounds where it has none: a wave of a pole is no number."""
        return Interval(np.where(self.bounded, values.low, -np.inf), np.where(self.bounded, values.high, np.inf))


def _function(of_interval: Callable[[Interval], Interval], f: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Extend a function to intervals; plain numbers stay numbers."""
    return lambda x: of_interval(x) if isinstance(x, Interval) else f(x)


OF_INTERVALS: dict[str, Callable[[Interval], Interval]] = {
    "sin": lambda x: x._wave(np.sin, np.pi / 2),
    "cos": lambda x: x._wave(np.cos, 0.0),
    "tan": Interval.tan,
    "exp": lambda x: x._rising(np.exp),
    "log": lambda x: x._from_zero(np.log),
    "sqrt": lambda x: x._from_zero(np.sqrt),
    "tanh": lambda x: x._rising(np.tanh),
}
INTERVAL_FUNCTIONS = {name: _function(f, FUNCTIONS[name]) for name, f in OF_INTERVALS.items()}
INTERVAL_JET_FUNCTIONS = jet_functions(INTERVAL_FUNCTIONS)


def unbounded_at(formula: Formula, low: float, high: float, above: float = -np.inf) -> float | None:
    """Find where a formula of one variable has no bounds, or none above a number; None where it has all."""
    # cells without bounds, or without a lower one above a number, are halved until they have: at a pole they never do
    (name,) = formula.variables
    edges = np.linspace(low, high, CELLS + 1)
    left, right = edges[:-1], edges[1:]
    with np.errstate(all="ignore"):
        for _ in range(DEEPEST):
            found = formula(INTERVAL_FUNCTIONS, **{name: Interval(left, right)})
            if not isinstance(found, Interval):
                return None if np.isfinite(found) and found > above else low
            unknown = ~(found.bounded & np.asarray(found.low > above))
            left, right = left[unknown], right[unknown]
            if len(left) > MOST_CELLS:
                break
            if not len(left):
                return None
            middle = (left + right) / 2
            left, right = np.concatenate([left, middle]), np.concatenate([middle, right])
    return float(left.min())


def bounds_over(formula: Formula, left: Array, right: Array, *, of_second: bool = False) -> tuple[Array, Array]:
    """Give bounds of a formula of one variable, or of its second derivative, over ranges, of their shape."""
    (name,) = formula.variables
    inside, like = Interval(left, right), np.zeros_like(left)
    with np.errstate(all="ignore"):
        if of_second:
            variable: tuple[Any, ...] = inside, Interval(like + 1, like + 1), Interval(like, like)
            found = formula(INTERVAL_JET_FUNCTIONS, **{name: Jet(*variable)})
            found = found.second if isinstance(found, Jet) else 0.0
        else:
            found = formula(INTERVAL_FUNCTIONS, **{name: inside})
    if not isinstance(found, Interval):
        found = Interval(like + float(found), like + float(found))
    return np.broadcast_to(found.low, left.shape), np.broadcast_to(found.high, left.shape)
