"""Drives: what turns or pushes a joint, as a function of the drive coordinate theta.

Theta runs from 0 to 2 pi in a cycle. For a drive at constant speed it is the angle turned; for a periodic law it is
the phase ``2 pi t / period``. With several drives the cycle is the shortest one in which each of them makes a whole
number of its own. A drive at constant speed may start with a run-up, which is not periodic: theta is then a function of
time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import lru_cache, partial
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Discriminator, Field, Tag, field_validator

from fenics_mech._arrays import Array
from fenics_mech.scene.base import Name, Part
from fenics_mech.scene.formulas.expression import Formula, Jet
from fenics_mech.scene.formulas.interval import unbounded_at
from fenics_mech.scene.rest_to_rest import RestToRest
from fenics_mech.scene.run_ups import RunUpLaw, TimeExpression, TimeTable, smooth_start
from fenics_mech.scene.sampling import SAMPLING, SampledFunction, enough_angles, equal_steps, pieces_of
from fenics_mech.scene.units import AngleOrLength, AngularSpeed, Inertia, Time, TorsionalDamping, TorsionalRate

MOST_HARMONICS = 10_000  # of a series, which is summed at up to 2**17 angles
MOST_TURNS = 20  # cycles of the first drive in the common one
SAME_RATIO = 1e-9  # of a ratio of two rates, by which it may miss a ratio of whole numbers
JOIN = 1e-6  # of its speed or its length, by which a run-up's law may miss what it has to join
BLOCK = 2**20  # products of an order and an angle that are held at once


def _values(law: Callable[[Array], Jet], places: Array) -> Array:
    """Value and two derivatives of a law, ``(3, places)``."""
    with np.errstate(all="ignore"):
        jet = law(places)
    return np.stack([jet.value, jet.first, jet.second])


def check_finite(formula: Formula) -> None:
    """Raise `ValueError` unless a formula of theta is finite over the whole cycle, also between any samples of it."""
    if (where := unbounded_at(formula, 0.0, 2 * math.pi)) is not None:
        raise ValueError(
            f"the formula {formula.text!r} is not finite over the cycle, or cannot be shown to be: "
            f"see theta = {where:.6g}"
        )


class Harmonics(Part):
    """A periodic law ``mean + sum_n cosine_n cos(n theta) + sine_n sin(n theta)`` of a drive.

    Parameters
    ----------
    mean
        Mean angle (rad) or stroke (m).
    cosine, sine
        Amplitudes (rad or m) of the harmonics, the first first.

    Examples
    --------
    >>> swing = fm.Harmonics(mean="90 deg", sine=("30 deg",))
    >>> fm.Drive(joint="O", law=swing, period=0.5).law.kind
    'harmonics'
    """

    kind: Literal["harmonics"] = "harmonics"
    mean: AngleOrLength = 0.0
    cosine: Annotated[tuple[AngleOrLength, ...], Field(max_length=MOST_HARMONICS)] = ()
    sine: Annotated[tuple[AngleOrLength, ...], Field(max_length=MOST_HARMONICS)] = ()

    @property
    def orders(self) -> Array:
        """Orders n of the harmonics, ``(harmonics,)``."""
        return np.arange(1, 1 + max(len(self.cosine), len(self.sine)), dtype=np.float64)

    @property
    def amplitudes(self) -> NDArray[np.complex128]:
        """Complex amplitudes c of the harmonics: the sum is that of the real parts of ``c exp(i n theta)``."""
        size = len(self.orders)
        cosine, sine = (np.pad(part, (0, size - len(part))) for part in (self.cosine, self.sine))
        return cosine - 1j * sine  # type: ignore[no-any-return]

    def jet(self, theta: Array) -> Jet:
        """Value and two derivatives by theta (rad), of the shape of theta."""
        n = self.orders
        by_derivative = self.amplitudes * np.stack([np.ones_like(n), 1j * n, -(n**2)])
        flat, block = theta.ravel(), max(1, BLOCK // max(1, len(n)))
        parts = np.zeros((3, len(flat)))
        for k in range(0, len(flat), block):
            parts[:, k : k + block] = (by_derivative @ np.exp(1j * n[:, None] * flat[k : k + block])).real
        value, first, second = parts.reshape(3, *theta.shape)
        return Jet(self.mean + value, first, second)

    def equally(self, count: int, derivative: int = 0) -> Array:
        """Give a derivative, or the value, at equal steps of a cycle, ``(count,)``, by the fast Fourier transform."""
        n = self.orders
        spectrum = np.zeros(count, complex)
        np.add.at(spectrum, n.astype(np.int64) % count, self.amplitudes * (1j * n) ** derivative)
        return count * np.fft.ifft(spectrum).real + (0.0 if derivative else self.mean)


class Table(Part):
    """A periodic law of a drive by values, joined by a periodic quintic spline.

    Parameters
    ----------
    values
        Angles (rad) or strokes (m) at equal steps of the cycle; the first is not repeated at its end.

    Examples
    --------
    >>> len(fm.Table(values=("0 mm", "2 mm", "4 mm", "5 mm", "4 mm", "2 mm")).values)
    6
    """

    kind: Literal["table"] = "table"
    values: Annotated[tuple[AngleOrLength, ...], Field(min_length=6, max_length=100_000)]

    def jet(self, theta: Array) -> Jet:
        """Value and two derivatives by theta (rad), of the shape of theta."""
        from scipy.interpolate import make_interp_spline  # noqa: PLC0415  (slow to import, and few drives have tables)

        nodes = np.linspace(0, 2 * np.pi, len(self.values) + 1)
        spline = make_interp_spline(nodes, np.append(self.values, self.values[0]), k=5, bc_type="periodic")
        turned = np.mod(theta, 2 * np.pi)
        return Jet(*(spline.derivative(n)(turned) if n else spline(turned) for n in range(3)))


class Expression(Part):
    """A periodic law of a drive by a formula.

    Parameters
    ----------
    formula
        Angle (rad) or stroke (m) as a formula of theta, which runs from 0 to 2 pi in a cycle.

    Examples
    --------
    >>> fm.Expression(formula="0.1 * sin(theta) ** 3").kind
    'expression'
    """

    kind: Literal["expression"] = "expression"
    formula: str

    @field_validator("formula")
    @classmethod
    def _is_periodic(cls, text: str) -> str:
        formula = Formula(text, ("theta",))
        values = _values(lambda theta: formula.jet(Jet.variable(theta)), np.array([0.0, 1.0, 2.5, 2 * np.pi]))
        check_finite(formula)
        if not np.isfinite(values).all():
            raise ValueError(f"the derivatives of the formula {text!r} are not finite over the cycle")
        ends = values[:, [0, -1]]
        if np.abs(np.diff(ends)).max() > 1e-9 * float(np.abs(values).max()):
            raise ValueError(f"the formula {text!r} is not periodic: f(0) and f(2 pi) differ")
        return text

    def jet(self, theta: Array) -> Jet:
        """Value and two derivatives by theta (rad), of the shape of theta."""
        return Formula(self.formula, ("theta",)).jet(Jet.variable(theta))


Law = Annotated[Harmonics | Table | Expression | RestToRest, Field(discriminator="kind")]


def _acceleration(law: Law, count: int) -> Array:
    """Second derivative of a law at so many equal steps of a cycle."""
    return law.equally(count, 2) if isinstance(law, Harmonics) else law.jet(equal_steps(count)).second


@lru_cache(maxsize=8)
def _accelerations(law: Law) -> SampledFunction:
    """Second derivative of a law over a cycle, which several checks look at."""
    if isinstance(law, Expression | RestToRest):
        edges = law.edges if isinstance(law, RestToRest) else pieces_of(law.formula, of_second=True)
        return SampledFunction.between(edges, lambda theta: law.jet(theta).second)
    return SampledFunction.equally(_acceleration(law, SAMPLING.samples))


class Motor(Part):
    """What lies between an ideal drive and its crank: a shaft that twists, and the rotor that turns with the crank.

    Parameters
    ----------
    stiffness, damping
        Moment of the shaft over its twist (N m/rad), and over the rate of it (N m s/rad).
    inertia
        Moment of inertia of what turns with the crank (kg m^2): rotor, gears, flywheel.

    Examples
    --------
    >>> fm.Drive(joint="O", speed=30.0, motor=fm.Motor(stiffness=200.0, inertia=0.01)).motor.damping
    0.0
    """

    stiffness: Annotated[TorsionalRate, Field(gt=0)]
    damping: Annotated[TorsionalDamping, Field(ge=0)] = 0.0
    inertia: Annotated[Inertia, Field(ge=0)] = 0.0


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
    run_up
        Time (s) in which a drive at constant speed comes from rest to its speed. Only a solution in time has a run-up;
        the steady state is that of the speed.
    run_up_law
        The angle turned during the run-up, instead of `smooth_start`: from 0 at t = 0 to any, with the drive's speed at
        the end.
    motor
        What lies between a drive at constant speed and its crank; without it the crank turns as the drive does.

    Examples
    --------
    >>> round(fm.Drive(joint="O", speed="300 rpm").speed, 3)
    31.416
    """

    joint: Name
    speed: AngularSpeed | None = None
    start: AngleOrLength = 0.0
    law: Law | None = None
    period: Annotated[Time, Field(gt=0)] | None = None
    run_up: Annotated[Time, Field(gt=0)] | None = None
    run_up_law: RunUpLaw | None = None
    motor: Motor | None = None

    def _check_keys(self) -> None:
        if (self.speed is None) == (self.law is None):
            raise ValueError("a drive needs either a speed or a law, not both")
        if self.speed == 0:
            raise ValueError("the drive's speed must not be 0: the cycle would have no period")
        if (self.law is None) != (self.period is None):
            raise ValueError("a law and its period must be given together")
        if self.run_up is None:
            if self.run_up_law is not None:
                raise ValueError("a run_up_law needs its duration, run_up")
            return
        if self.speed is None:
            raise ValueError("a run-up leads to a constant speed: a drive with a periodic law has none")
        law = self.run_up_law
        if isinstance(law, TimeTable) and abs(law.times[-1] - self.run_up) > JOIN * self.run_up:
            raise ValueError(f"the run-up's table ends at {law.times[-1]:.6g} s, and the run-up at {self.run_up:.6g} s")
        values = _values(self.coordinate, np.linspace(0, self.run_up, 101))
        formula = Formula(law.formula, ("t",)) if isinstance(law, TimeExpression) else None
        pole = formula is not None and unbounded_at(formula, 0.0, self.run_up) is not None
        if pole or not np.isfinite(values).all():
            raise ValueError("the run-up's law is not finite over the run-up")
        first, last_rate = values[0, 0], values[1, -1]
        if abs(first) > JOIN:
            raise ValueError(f"the run-up's law must start with an angle of 0, and starts with {first:.6g} rad")
        if abs(last_rate - self.speed) > JOIN * abs(self.speed):
            raise ValueError(
                f"the run-up's law ends with {last_rate:.6g} rad/s, and the drive goes on with {self.speed:.6g} rad/s"
            )

    @property
    def cycle_rate(self) -> float:
        """Rate of the drive's own cycle (rad/s): its speed, or 2 pi over the period of its law."""
        return self.speed if self.speed is not None else 2 * math.pi / (self.period or math.nan)

    def coordinate(self, time: Array) -> Jet:
        """Coordinate (rad) of the own cycle, its rate and acceleration, at times (s) from 0 on, ``(times,)``."""
        if self.run_up is None:
            return Jet(self.cycle_rate * time, np.full_like(time, self.cycle_rate), np.zeros_like(time))
        speed, end = self.cycle_rate, self.run_up
        law = self.run_up_law.jet if self.run_up_law is not None else partial(smooth_start, end)
        starting, last = law(np.minimum(time, end), speed), law(np.array([end]), speed)
        steady = time > end
        return Jet(
            np.where(steady, last.value + speed * (time - end), starting.value),
            np.where(steady, speed, starting.first),
            np.where(steady, 0.0, starting.second),
        )

    def turns_in(self, cycle_rate: float) -> int:
        """Own cycles in the common one, which runs at `cycle_rate` (rad/s); negative in the opposite sense."""
        return round(self.cycle_rate / cycle_rate)

    def enough_angles(self, least: int, cycle_rate: float) -> int:
        """Number of parts of the common cycle, at least so many, that show what the law's acceleration does."""
        law, turns = self.law, abs(self.turns_in(cycle_rate))
        if law is None:
            return least
        own = -(-least // turns)
        enough = enough_angles(lambda count: _acceleration(law, count), _accelerations(law), own)
        return least if enough == own else turns * enough

    def jet(self, theta: Array, cycle_rate: float) -> Jet:
        """Angle (rad) or stroke (m) and two derivatives by theta (rad), ``(angles,)``, which runs at `cycle_rate`."""
        turns = self.turns_in(cycle_rate)
        if self.law is not None:
            own = self.law.jet(np.mod(turns * theta, 2 * np.pi))
            return Jet(own.value, turns * own.first, turns**2 * own.second)  # chain rule
        return Jet(self.start + turns * theta, np.full_like(theta, turns), np.zeros_like(theta))


Drives = Annotated[
    Annotated[Drive, Tag("one")] | Annotated[tuple[Drive, ...], Tag("many")],
    Discriminator(lambda value: "many" if isinstance(value, list | tuple) else "one"),
]


def common_rate(drives: Sequence[Drive]) -> float:
    """Rate (rad/s) of theta, in whose cycle, the shortest one, every drive makes a whole number of its own."""
    first = drives[0].cycle_rate
    if len(drives) == 1:
        return first
    ratios = [Fraction(drive.cycle_rate / first).limit_denominator(MOST_TURNS) for drive in drives]
    turns = math.lcm(*(ratio.denominator for ratio in ratios))
    for drive, ratio in zip(drives, ratios):
        other = drive.cycle_rate / first
        if turns > MOST_TURNS or ratio == 0 or abs(float(ratio) - other) > SAME_RATIO * abs(other):
            periods = [f"{2 * math.pi / abs(one.cycle_rate):.12g} s at joint {one.joint}" for one in drives]
            raise ValueError(
                f"the drives have no common cycle of at most {MOST_TURNS} cycles of the first: theirs take "
                f"{', '.join(periods)}"
            )
    return first / turns
