"""Factors of loads over time, and over the place and rate of a joint: where nothing repeats with a drive angle."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from fenics_mech._arrays import Array
from fenics_mech.scene.base import Name, Part, check_paired
from fenics_mech.scene.formulas.expression import JET_FUNCTIONS, Formula, formula_of, slopes_of
from fenics_mech.scene.units import Time

VARIABLES = "t", "place", "rate"


class StateFactor(Part):
    """What goes by the time or by the state of a joint, and not by a drive angle."""

    joint: Name | None = None
    jumps: ClassVar[tuple[float, ...]] = ()  # drive angles (rad) at which the value jumps: it knows none
    corners: ClassVar[tuple[float, ...]] = ()  # drive angles (rad) between which the value is a polynomial: the same


class FactorFormula(StateFactor):
    """A factor of a load by a formula of the time, and of the place and the rate of a joint.

    Parameters
    ----------
    formula
        The factor as a formula of the time t (s), and of place and rate: those of the joint, its angle or stroke (rad
        or m) and the rate of that (rad/s or m/s).
    joint
        The joint; it may be left out where the formula has the time alone.

    Examples
    --------
    >>> fm.FactorFormula(formula="sin(5 * t)").joint is None
    True
    """

    kind: Literal["formula"] = "formula"
    formula: Annotated[str, formula_of(*VARIABLES)]

    def _check_keys(self) -> None:
        used = [name for name in ("place", "rate") if Formula(self.formula, VARIABLES).uses(name)]
        if used and self.joint is None:
            raise ValueError(f"the formula has the {' and the '.join(used)} of a joint: name it with `joint`")

    def of_state(self, time: Array, place: Array, rate: Array) -> Array:
        """Factor at times (s), with the joint's place and rate there, ``(times,)`` each."""
        return np.broadcast_to(self._value(time, place, rate), time.shape)

    def with_derivatives(self, time: Array, place: Array, rate: Array) -> tuple[Array, Array, Array]:
        """Factor, and its derivatives by place and rate, ``(times,)`` each; see `of_state`."""
        return slopes_of(self._value, time, place, rate)

    def _value(self, *state: Any) -> Any:
        return Formula(self.formula, VARIABLES)(JET_FUNCTIONS, **dict(zip(VARIABLES, state)))


class FactorTimes(StateFactor):
    """A factor of a load by values at times, joined by straight lines; before and after them it stays as it is.

    Parameters
    ----------
    times
        Times (s), increasing.
    values
        Values of the factor there.
    joint
        It has none.

    Examples
    --------
    >>> fm.FactorTimes(times=("0 s", "0.1 s"), values=(0, 1)).kind
    'times'
    """

    kind: Literal["times"] = "times"
    joint: None = None
    times: Annotated[tuple[Time, ...], Field(min_length=2, max_length=100_000)]
    values: Annotated[tuple[float, ...], Field(min_length=2, max_length=100_000)]

    def _check_keys(self) -> None:
        check_paired(times=self.times, values=self.values)
        if any(b <= a for a, b in pairwise(self.times)):
            raise ValueError("the times must increase: where the load is to jump, let it rise in a short time")

    def of_state(self, time: Array, place: Array, rate: Array) -> Array:
        """Factor at times (s), ``(times,)``; the place and the rate of a joint do not count."""
        return np.interp(time, self.times, self.values)
