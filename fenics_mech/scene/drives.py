"""Drives: what turns or pushes a joint, as a function of the drive coordinate theta.

Theta runs from 0 to 2 pi in a cycle. For a drive at constant speed it is the angle turned; for a periodic law it is
the phase ``2 pi t / period``.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator
from scipy.interpolate import make_interp_spline

from fenics_mech.expressions import Formula, Jet
from fenics_mech.scene.base import Name, Part
from fenics_mech.units import AngleOrLength, AngularSpeed, Time

Array = NDArray[np.float64]


class Harmonics(Part):
    """``mean + sum_n cosine_n cos(n theta) + sine_n sin(n theta)``, in rad or m."""

    kind: Literal["harmonics"]
    mean: AngleOrLength = 0.0
    cosine: tuple[AngleOrLength, ...] = ()
    sine: tuple[AngleOrLength, ...] = ()

    def jet(self, theta: Array) -> Jet:
        """Value and two derivatives by theta."""
        total = Jet(np.full_like(theta, self.mean), np.zeros_like(theta), np.zeros_like(theta))
        for coefficients, f, df in ((self.cosine, np.cos, lambda x: -np.sin(x)), (self.sine, np.sin, np.cos)):
            for n, a in enumerate(coefficients, 1):
                wave = f(n * theta)
                total += Jet(a * wave, a * n * df(n * theta), -a * n**2 * wave)
        return total


class Table(Part):
    """Equally spaced values over a cycle (rad or m), joined by a periodic quintic spline."""

    kind: Literal["table"]
    values: Annotated[tuple[AngleOrLength, ...], Field(min_length=6, max_length=100_000)]

    def jet(self, theta: Array) -> Jet:
        """Value and two derivatives by theta."""
        nodes = np.linspace(0, 2 * np.pi, len(self.values) + 1)
        spline = make_interp_spline(nodes, np.append(self.values, self.values[0]), k=5, bc_type="periodic")
        turned = np.mod(theta, 2 * np.pi)
        return Jet(*(spline.derivative(n)(turned) if n else spline(turned) for n in range(3)))


class Expression(Part):
    """A formula of theta (0 to 2 pi in a cycle), in rad or m; it must be periodic."""

    kind: Literal["expression"]
    formula: str

    @field_validator("formula")
    @classmethod
    def _can_be_read(cls, text: str) -> str:
        Formula(text, ("theta",))
        return text

    @model_validator(mode="after")
    def _is_periodic(self) -> Self:
        with np.errstate(all="ignore"):
            jet = self.jet(np.array([0.0, 1.0, 2.5, 2 * np.pi]))
        ends = np.array([[part[0], part[-1]] for part in (jet.value, jet.first, jet.second)])
        if not np.isfinite([jet.value, jet.first, jet.second]).all():
            raise ValueError(f"the formula {self.formula!r} is not finite over the cycle")
        if np.abs(np.diff(ends)).max() > 1e-9 * max(1.0, float(np.abs(ends).max())):
            raise ValueError(f"the formula {self.formula!r} does not come back after a cycle: f(0) and f(2 pi) differ")
        return self

    def jet(self, theta: Array) -> Jet:
        """Value and two derivatives by theta."""
        return Formula(self.formula, ("theta",)).jet(Jet.variable(theta))


Law = Annotated[Harmonics | Table | Expression, Field(discriminator="kind")]


class Drive(Part):
    """A drive moves the second body of a joint against the first, at constant speed or by a periodic law.

    Parameters
    ----------
    joint
        Joint of two bodies: a revolute joint, whose angle is driven, or a slot or prismatic joint, whose stroke is.
    speed
        Constant angular speed (rad/s) of a revolute joint.
    start
        Angle at theta = 0 (rad), for a drive at constant speed.
    law
        Instead of a speed: angle (rad) or stroke (m) over the cycle.
    period
        Duration of the law's cycle (s).
    """

    joint: Name
    speed: AngularSpeed | None = None
    start: AngleOrLength = 0.0
    law: Law | None = None
    period: Annotated[Time, Field(gt=0)] | None = None

    @model_validator(mode="after")
    def _moves_in_one_way(self) -> Self:
        if (self.speed is None) == (self.law is None):
            raise ValueError("a drive has either a speed or a law")
        if self.speed == 0:
            raise ValueError("the drive's speed must not be 0: the cycle would have no period")
        if (self.law is None) != (self.period is None):
            raise ValueError("a period goes with a law, and a law needs one")
        return self

    @property
    def cycle_rate(self) -> float:
        """Rate of the drive coordinate theta (rad/s)."""
        return self.speed if self.speed is not None else 2 * math.pi / (self.period or math.nan)

    def jet(self, theta: Array, cycle_rate: float) -> Jet:
        """Angle or stroke and two derivatives by theta, which runs at `cycle_rate` (rad/s)."""
        if self.law is not None:
            return self.law.jet(theta)
        ratio = (self.speed or 0.0) / cycle_rate
        return Jet(self.start + ratio * theta, np.full_like(theta, ratio), np.zeros_like(theta))
