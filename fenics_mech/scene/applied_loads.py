"""What acts on the links from outside: loads at points, loads along members, and impulses.

A load may change over the cycle: a `factor`, a number that is a function of the drive angle theta, multiplies it.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag, field_validator

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.scene.base import Part, check_paired
from fenics_mech.scene.drives import MOST_HARMONICS, Harmonics, check_finite
from fenics_mech.scene.formulas.expression import Formula, Jet
from fenics_mech.scene.sampling import SAMPLING, SampledFunction, enough_angles, equal_steps, pieces_of
from fenics_mech.scene.state_factors import FactorFormula, FactorTimes, StateFactor
from fenics_mech.scene.units import Angle, AngularMomentum, Force, LineForce, Momentum, OfTurning, Time, Torque

NAME = r"[A-Za-z_][A-Za-z0-9_\-]*"
# "link.point", "joint", or "member@place" with a place 0 to 1 along the member, such as "coupler@0.3"
Place = Annotated[str, Field(pattern=rf"^{NAME}(\.{NAME})?(@(0?\.\d+|[01](\.0*)?))?$")]


def in_rad(*angles: float) -> str:
    """Recall the unit of numbers, where some angle other than 0 is one."""
    return "; without a unit they are rad" * any(a and not isinstance(a, OfTurning) for a in angles)


class FactorHarmonics(Harmonics):
    """A factor ``mean + sum_n cosine_n cos(n theta) + sine_n sin(n theta)`` of a load.

    Parameters
    ----------
    mean
        Mean of the factor.
    cosine, sine
        Amplitudes of the harmonics, the first first.

    Examples
    --------
    >>> fm.Load(at="B", force=("10 N", 0), factor=fm.FactorHarmonics(mean=1.0, sine=(0.5,))).factor_range
    (0.5, 1.5)
    """

    mean: float = 0.0
    cosine: Annotated[tuple[float, ...], Field(max_length=MOST_HARMONICS)] = ()
    sine: Annotated[tuple[float, ...], Field(max_length=MOST_HARMONICS)] = ()
    jumps: ClassVar[tuple[float, ...]] = ()  # drive angles (rad) at which the value jumps
    corners: ClassVar[tuple[float, ...]] = ()  # drive angles (rad) between which the value is a polynomial

    def at(self, theta: Array) -> Array:
        """Values at drive angles (rad), of their shape."""
        return self.jet(theta).value


_SLOWER = (
    "as a four-stroke engine has it, add what turns {n} times as slowly, such as a camshaft: a link of its own with a "
    "drive at 1/{n} of the speed. The cycle is then one turn of it, so divide these angles by {n}"
)


class FactorTable(Part):
    """A factor of a load by values at angles, joined by straight lines, also over the end of the cycle.

    Two points at one angle make a jump.

    Parameters
    ----------
    angles
        Drive angles (rad), increasing over at most one cycle.
    values
        Values of the factor there.

    Examples
    --------
    >>> fm.FactorTable(angles=("0 deg", "90 deg", "180 deg"), values=(0, 1, 0)).jumps
    ()
    """

    kind: Literal["table"] = "table"
    angles: Annotated[tuple[Angle, ...], Field(min_length=2, max_length=100_000)]
    values: Annotated[tuple[float, ...], Field(min_length=2, max_length=100_000)]

    def _check_keys(self) -> None:
        check_paired(angles=self.angles, values=self.values)
        if any(b < a for a, b in pairwise(self.angles)) or self.angles[-1] - self.angles[0] > TURN * (1 + 1e-12):
            found = f"found {np.degrees(self.angles[0]):.6g} to {np.degrees(self.angles[-1]):.6g} deg"
            turns = (self.angles[-1] - self.angles[0]) / TURN
            n = round(turns)
            several = n > 1 and abs(turns - n) < 1e-6
            raise ValueError(
                f"the angles must increase, over at most one cycle, {found}{in_rad(*self.angles)}"
                + (f". For a cycle of {n} turns, {_SLOWER.format(n=n)}" if several else "")
            )

    @property
    def jumps(self) -> tuple[float, ...]:
        """Drive angles (rad) at which the value jumps."""
        points = [*zip(self.angles, self.values), (self.angles[0] + TURN, self.values[0])]
        return tuple(a for (a, value), (b, other) in pairwise(points) if b - a < SAMPLING.same and value != other)

    @property
    def corners(self) -> tuple[float, ...]:
        """Drive angles (rad) between which the value is a polynomial."""
        return self.angles

    def at(self, theta: Array) -> Array:
        """Values at drive angles (rad), of their shape."""
        turned = self.angles[0] + np.mod(theta - self.angles[0], TURN)
        return np.interp(turned, [*self.angles, self.angles[0] + TURN], [*self.values, self.values[0]])


class FactorExpression(Part):
    """A factor of a load by a formula.

    Parameters
    ----------
    formula
        The factor as a formula of theta (rad), from 0 to 2 pi in every cycle.

    Examples
    --------
    >>> fm.FactorExpression(formula="1 + cos(theta)").kind
    'expression'
    """

    kind: Literal["expression"] = "expression"
    formula: str
    corners: ClassVar[tuple[float, ...]] = ()  # drive angles (rad) between which the value is a polynomial: not known

    @field_validator("formula")
    @classmethod
    def _is_finite(cls, text: str) -> str:
        check_finite(Formula(text, ("theta",)))
        return text

    @property
    def jumps(self) -> tuple[float, ...]:
        """Drive angles (rad) at which the value jumps: 0, where the formula does not end as it began."""
        begin, end = _evaluated(self.formula, np.array([0.0, TURN]))
        return () if math.isclose(begin, end, rel_tol=SAMPLING.same, abs_tol=SAMPLING.same) else (0.0,)

    def at(self, theta: Array) -> Array:
        """Values at drive angles (rad), of their shape."""
        return _evaluated(self.formula, np.mod(theta, TURN))


def _evaluated(formula: str, theta: Array) -> Array:
    return Formula(formula, ("theta",)).jet(Jet.variable(theta)).value


class Pulse(Part):
    """Acts in a part of the cycle: 1 from one angle to another in the sense of theta, 0 in the rest.

    Parameters
    ----------
    start, end
        Angles (rad) at which the factor is 1/2, on its way up and down.
    ramp
        Width (rad) of each flank, a polynomial with two continuous derivatives; 0 is a jump.

    Examples
    --------
    >>> fm.Pulse(start="30 deg", end="60 deg", ramp="5 deg").kind
    'pulse'
    """

    kind: Literal["pulse"] = "pulse"
    start: Angle
    end: Angle
    ramp: Annotated[Angle, Field(ge=0)] = 0.0

    def _check_keys(self) -> None:
        if self.start == self.end:
            raise ValueError("the pulse starts and ends at the same angle")
        if self.ramp > min(self.width, TURN - self.width) * (1 + 1e-9):
            found = ", ".join(f"{key} {math.degrees(getattr(self, key)):.6g} deg" for key in ("start", "end", "ramp"))
            raise ValueError(
                f"the ramp is wider than the pulse, or than the pause between two of them, found {found}"
                + in_rad(self.start, self.end, self.ramp)
            )

    @property
    def width(self) -> float:
        """Part of the cycle in which the pulse acts (rad)."""
        return (self.end - self.start) % TURN or TURN

    @property
    def jumps(self) -> tuple[float, ...]:
        """Drive angles (rad) at which the value jumps."""
        return () if self.ramp else (self.start, self.end)

    @property
    def corners(self) -> tuple[float, ...]:
        """Drive angles (rad) between which the value is a polynomial."""
        return tuple(angle + side * self.ramp / 2 for angle in (self.start, self.end) for side in (-1, 1))

    def at(self, theta: Array) -> Array:
        """Values at drive angles (rad), of their shape."""
        from_middle = np.mod(theta - self.start - self.width / 2 + math.pi, TURN) - math.pi
        inside = self.width / 2 - np.abs(from_middle)
        if self.ramp == 0:
            return np.where(inside >= 0, 1.0, 0.0)
        x = np.clip(inside / self.ramp + 0.5, 0, 1)
        return x**3 * (10 - 15 * x + 6 * x**2)


OverCycle = FactorHarmonics | FactorTable | FactorExpression | Pulse
Factor = Annotated[OverCycle | FactorFormula | FactorTimes, Field(discriminator="kind")]


def _equally(factor: OverCycle, count: int) -> Array:
    """Values of a factor at so many equal steps of a cycle."""
    return factor.equally(count) if isinstance(factor, FactorHarmonics) else factor.at(equal_steps(count))


@lru_cache(maxsize=8)
def _over_a_cycle(factor: OverCycle) -> SampledFunction:
    """Values of a factor over a cycle, which several checks look at."""
    if isinstance(factor, FactorHarmonics):
        return SampledFunction.equally(factor.equally(SAMPLING.samples))
    return SampledFunction.between(
        np.union1d(np.linspace(0, TURN, SAMPLING.pieces + 1), factor_pieces(factor)), factor.at
    )


def factor_pieces(factor: OverCycle) -> Array:
    """Give angles (rad) from 0 to 2 pi, ascending, between which Gauss points integrate a factor, ``(pieces + 1,)``."""
    if isinstance(factor, FactorExpression):
        return pieces_of(factor.formula)
    return np.union1d([0.0, TURN], np.mod([*factor.corners, *factor.jumps], TURN))


class Varying(Part):
    """What a factor multiplies; without one it is constant over the cycle."""

    factor: Factor | None = None

    @property
    def jumps(self) -> tuple[float, ...]:
        """Drive angles (rad) at which it jumps."""
        return () if self.factor is None else self.factor.jumps

    @property
    def over_cycle(self) -> OverCycle | None:
        """Its factor, where that goes by the drive angle."""
        return None if isinstance(self.factor, StateFactor) else self.factor

    def factor_at(self, theta: Array) -> Array:
        """Factor at drive angles, ``(angles,)``; 1 of one that goes by time or by a joint, see `load_factor`."""
        return np.ones_like(theta) if self.over_cycle is None else self.over_cycle.at(theta)

    def computed(self) -> dict[str, Any]:
        """Give values of keys such as ``force`` or ``line``, by key, in SI: a class of another package has others."""
        return {}

    @property
    def factor_range(self) -> tuple[float, float]:
        """Smallest and largest value of the factor; 1 where it does not go by the drive angle."""
        if (factor := self.over_cycle) is None:
            return 1.0, 1.0
        values = np.append(_over_a_cycle(factor).values, factor.at(np.array(factor.corners)))
        return float(values.min()), float(values.max())

    @property
    def cut_where_needed(self) -> bool:
        """Whether steps of a cycle can be cut where the factor begins and ends to change."""
        return self.factor is not None and bool(self.factor.corners)

    def enough_angles(self, least: int) -> int:
        """Number of equal parts of a cycle, at least so many, that show what the factor does inside them."""
        if (factor := self.over_cycle) is None:
            return least
        return enough_angles(lambda count: _equally(factor, count), _over_a_cycle(factor), least, bool(self.jumps))

    def share_missed(self, count: int) -> float:
        """Share of the factor's largest value that none of so many positions of a cycle, nor a middle between, sees."""
        if (factor := self.over_cycle) is None:
            return 0.0
        whole = max(map(abs, self.factor_range))
        seen = float(np.abs(_equally(factor, 2 * count)).max())
        return 1 - seen / whole if whole else 0.0


class Load(Varying):
    """A force and a moment at a point of a link, at a joint, or at a place along a member.

    Parameters
    ----------
    at
        "link.point", the name of a joint, or "member@place" with a place 0 to 1 along the member.
    force
        Force along X and Y of the fixed frame (N); with `follows` along x and y of the link.
    moment
        Moment, counter-clockwise (N m).
    follows
        The force turns with the link, and with its elastic rotation at the point.
    factor
        What it is multiplied by, over the drive angle, the time, or a joint's place and rate.

    Examples
    --------
    >>> fm.Load(at="coupler@0.5", force=(0, "-20 N")).force
    (0.0, -20.0)
    """

    at: Place
    force: tuple[Force, Force] = (0.0, 0.0)
    moment: Torque = 0.0
    follows: bool = False


class LineLoad(Varying):
    """A load spread along a member, constant or linear.

    Parameters
    ----------
    member
        "link", or "link.member" when the link has several members.
    line
        Force per length (N/m) at the member's first end, along X and Y of the fixed frame.
    line_end
        The same at its second end; without it the load is constant.
    axes
        With "member" the two components are along the member's axis and its normal, and turn with its rigid motion.
        With ``analysis.solver = "poses"`` they turn with its bent axis.
    factor
        What it is multiplied by, over the drive angle, the time, or a joint's place and rate.

    Examples
    --------
    >>> fm.LineLoad(member="coupler", line=(0, "-40 N/m"), axes="member").line
    (0.0, -40.0)
    """

    member: str
    line: tuple[LineForce, LineForce]
    line_end: tuple[LineForce, LineForce] | None = None
    axes: Literal["fixed", "member"] = "fixed"

    @property
    def ends(self) -> Array:
        """Force per length at the member's first and second end (N/m), ``(2, 2)``, without the factor."""
        return np.array([self.line, self.line if self.line_end is None else self.line_end])


AnyLoad = Annotated[
    Annotated[Load, Tag("load")] | Annotated[LineLoad, Tag("line-load")],
    Discriminator(lambda value: "line-load" if _has_member(value) else "load"),
]


def _has_member(value: object) -> bool:
    return "member" in value if isinstance(value, dict) else isinstance(value, LineLoad)


class Impulse(Part):
    """An impulse: it changes velocities and no displacement.

    Parameters
    ----------
    at
        As of a load.
    angle
        Drive angle at which it strikes, in every cycle (rad).
    time
        Or the time at which it strikes once (s), in a motion with freedoms.
    impulse
        Force times time along X and Y of the fixed frame (N s).
    angular_impulse
        Moment times time, counter-clockwise (N m s).

    Examples
    --------
    >>> fm.Impulse(at="coupler.B", angle="90 deg", impulse=("0.1 N s", 0)).impulse
    (0.1, 0.0)
    """

    at: Place
    angle: Angle | None = None
    time: Annotated[Time, Field(ge=0)] | None = None
    impulse: tuple[Momentum, Momentum] = (0.0, 0.0)
    angular_impulse: AngularMomentum = 0.0

    def _check_keys(self) -> None:
        if (self.angle is None) == (self.time is None):
            raise ValueError("must state when it strikes, by the drive's `angle` or by the `time`, and not by both")
