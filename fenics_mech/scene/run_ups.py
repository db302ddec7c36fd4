"""How a drive at constant speed starts: the angle turned over time, until it has its speed."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field

from fenics_mech._arrays import Array
from fenics_mech.scene.base import Part, check_paired
from fenics_mech.scene.formulas.expression import Formula, Jet, formula_of
from fenics_mech.scene.units import Angle, Time


class TimeTable(Part):
    """A run-up by angles at given times, joined by a quintic spline that starts from rest.

    It goes over into the steady motion with its speed and without acceleration.

    Parameters
    ----------
    times
        Times (s), from 0 to the end of the run-up.
    angles
        Angles turned (rad).

    Examples
    --------
    >>> law = fm.TimeTable(times=(0.0, 0.5, 1.0), angles=(0.0, 1.0, 5.0))
    >>> fm.Drive(joint="O", speed=10.0, run_up=1.0, run_up_law=law).run_up
    1.0
    """

    kind: Literal["table"] = "table"
    times: Annotated[tuple[Time, ...], Field(min_length=2, max_length=100_000)]
    angles: Annotated[tuple[Angle, ...], Field(min_length=2, max_length=100_000)]

    def _check_keys(self) -> None:
        check_paired(times=self.times, angles=self.angles)
        if self.times[0] != 0 or any(b <= a for a, b in pairwise(self.times)):
            raise ValueError("the times must increase from 0 to the end of the run-up")

    def jet(self, time: Array, speed: float) -> Jet:
        """Angle turned (rad) and two derivatives at times (s), ``(times,)``; `speed` (rad/s) is that at the end."""
        from scipy.interpolate import make_interp_spline  # noqa: PLC0415  (slow to import, and few run-ups have tables)

        ends = [(1, 0.0), (2, 0.0)], [(1, speed), (2, 0.0)]
        spline = make_interp_spline(self.times, self.angles, k=5, bc_type=ends)
        return Jet(spline(time), spline(time, 1), spline(time, 2))


class TimeExpression(Part):
    """A run-up by a formula.

    Parameters
    ----------
    formula
        Angle turned (rad) as a formula of the time t (s).

    Examples
    --------
    >>> fm.Drive(joint="O", speed=10.0, run_up=1.0, run_up_law=fm.TimeExpression(formula="5 * t ** 2")).run_up
    1.0
    """

    kind: Literal["expression"] = "expression"
    formula: Annotated[str, formula_of("t")]

    def jet(self, time: Array, speed: float) -> Jet:
        """Angle turned (rad) and two derivatives at times (s), ``(times,)``; the formula has its own speed."""
        return Formula(self.formula, ("t",)).jet(Jet.variable(time))


RunUpLaw = Annotated[TimeTable | TimeExpression, Field(discriminator="kind")]


def smooth_start(duration: float, time: Array, speed: float) -> Jet:
    """Angle turned (rad) from rest to `speed` (rad/s) within `duration` (s), and two derivatives, ``(times,)`` each."""
    x = time / duration  # the lowest polynomial of the speed whose first two derivatives vanish at both ends
    return Jet(
        speed * duration * x**4 * (2.5 - 3 * x + x**2),
        speed * x**3 * (10 - 15 * x + 6 * x**2),
        speed / duration * 30 * x**2 * (1 - x) ** 2,
    )
