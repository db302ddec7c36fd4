"""Response in time from a given state, by PETSc's TS: how a motion begins, and whether it becomes periodic.

TS integrates the second order equation as it stands, by collocation or with the generalised alpha method (alpha2), or,
with any other of its types, as one of first order. It stops where loads jump and where impulses strike, and goes on
from there.

Source: Chung and Hulbert, J. Appl. Mech. 60 (1993) 371; Balay et al., PETSc Users Manual, ch. 6.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._petsc import PETSc, configured, name_of
from fenics_mech._progress import reached
from fenics_mech.errors import SolverError
from fenics_mech.response.transient.coefficients import TABLE, Coefficients
from fenics_mech.response.transient.course import Course, Schedule, VelocityJumps
from fenics_mech.response.transient.instant import Instant
from fenics_mech.response.transient.stepping import Collocation, Curve, Keep
from fenics_mech.scene.start_state import StartState

logger = logging.getLogger(__name__)
COLLOCATION, SECOND_ORDER = "python", "alpha2"  # types of TS; the first is that of steps of our own
State = Callable[[], Any]  # gives z and its rate
Prepared = tuple[float, State]  # TS's time over ours, and the state


@dataclass(frozen=True)
class IntegrationLimits:
    """Limits of the time steps."""

    most_steps: int = 1_000_000  # of a motion: an hour or so
    largest_rise: float = 1.0  # in a step, of the logarithm of what grows without vibrating: a longer one would damp it
    small_rise: float = 0.1  # the same with PETSc's steps, of order 2: they do not see what is small beside the rest
    largest_motion: float = 1e6  # over the static deflection or the start: such a motion grows without bound
    same: float = 2 * TABLE.narrowest  # of a cycle, between times that count as one


INTEGRATION = IntegrationLimits()


class _Record:
    """Takes samples of the motion step by step, and says when two cycles are the same."""

    def __init__(self, schedule: Schedule, start: float, z: Array, rate: Array) -> None:
        self.schedule, self.times, self.lead = schedule, schedule.times(start), schedule.lead(start)
        self.states = np.zeros((len(self.times), 2, len(z)))
        self.states[0] = z, rate
        self.known, self.change, self.settled = 1, np.inf, False

    def keep(self, end: float, curve: Curve) -> bool:
        """Take the samples inside a step; say whether the motion is periodic by now."""
        reached(end, float(self.times[0]), float(self.times[-1]))
        known = int(np.searchsorted(self.times, end + INTEGRATION.same * self.schedule.cycle))
        if known > self.known:
            self.states[self.known : known] = np.stack(curve(self.times[self.known : known]), axis=1)
        while self.known < known and not self.settled:
            self.settled = self._is_settled(self.known)
            self.known += 1
        return self.settled

    def strike(self, time: float, z: Array, rate: Array) -> None:
        """Put a state in the place of the one just before an impulse."""
        if abs(self.times[self.known - 1] - time) <= INTEGRATION.same * self.schedule.cycle:
            self.states[self.known - 1] = z, rate

    def _is_settled(self, index: int) -> bool:
        samples = self.schedule.samples
        if (index - self.lead) % samples or index < self.lead + 2 * samples:
            return False
        now, then = self.states[index - samples : index, 0], self.states[index - 2 * samples : index - samples, 0]
        self.change = float(np.abs(now - then).max() / max(np.abs(now).max(), 1e-300))
        return self.change < self.schedule.settled


def integrate(
    coefficients: Coefficients,
    schedule: Schedule,
    start: StartState,
    options: Mapping[str, Any],
    impulses: VelocityJumps | None = None,
) -> Course:
    """Integrate the equation from a state.

    Parameters
    ----------
    coefficients
        The equation at any time.
    schedule
        How long, and how accurately.
    start
        Where the motion starts.
    options
        PETSc options with the prefix "transient_"; transient_ts_type chooses the integrator, by default collocation.
    impulses
        Impulses.

    Raises
    ------
    SolverError
        When the time steps fail, or a mass or a tangent matrix is singular.
    """
    weight, rounding, time = coefficients.weight, INTEGRATION.same * schedule.cycle, start.time
    z, z_rate = start.displacement * weight, start.velocity * weight
    record = _Record(schedule, time, z, z_rate)
    impulses = impulses or VelocityJumps(np.zeros(0), np.zeros(0, np.int64), np.zeros((0, len(z))))
    run = _Integrator(coefficients, schedule, options, record.keep, z, np.vstack([z_rate, weight * impulses.jump]))
    for stop in _stops(coefficients, impulses, time, record.times[-1], rounding):
        if stop > time:
            coefficients.look(time, stop)
            z, z_rate = run.go_on(time, stop, z, z_rate)
        if record.settled:
            break
        z_rate, time = z_rate + weight * impulses.at(stop, rounding), stop
        record.strike(stop, z, z_rate)
    states = record.states[: record.known] / weight
    return Course(
        record.times[: record.known], states[:, 0], states[:, 1], record.change, run.steps, coefficients.error
    )


def _stops(
    coefficients: Coefficients, impulses: VelocityJumps, start: float, end: float, rounding: float
) -> Iterator[float]:
    """Give the times at which the integration stops: jumps, impulses, cycles of a run-up, and the end."""
    cycle, last = int(start // coefficients.cycle), start
    if len(impulses.time) and impulses.time[0] <= start + rounding:
        yield start
    while last < end:
        first, next_cycle = cycle * coefficients.cycle, (cycle + 1) * coefficients.cycle
        jumps, repeats = coefficients.jumps(cycle), coefficients.repeats(cycle)
        struck = impulses.time[np.searchsorted(impulses.time, first - rounding) :]
        if repeats and not len(jumps) and not len(struck):
            yield end
            return
        inside = struck[: np.searchsorted(struck, next_cycle - rounding)]
        for stop in np.sort(np.concatenate([jumps, inside, [] if repeats else [next_cycle]])):
            if last + rounding < stop < end - rounding:
                last = float(stop)
                yield last
        if next_cycle >= end - rounding:
            yield end
            return
        cycle += 1


class _Integrator:
    """TS with one of its types, from stop to stop."""

    def __init__(
        self,
        coefficients: Coefficients,
        schedule: Schedule,
        options: Mapping[str, Any],
        keep: Keep,
        z: Array,
        rates: Array,
    ) -> None:
        """Take the size of the motion from the loads, the first displacement, and velocities ``(rates, n)``."""
        self.schedule, self.options, self.taken, self.steps = schedule, options, keep, 0
        self.instant = Instant(coefficients)
        self.kind = str(options.get("transient_ts_type", COLLOCATION))
        self.rise = INTEGRATION.largest_rise if self.kind == COLLOCATION else INTEGRATION.small_rise
        growth = max(coefficients.growth, 1e-300)
        self.longest = min(schedule.longest * schedule.cycle, self.rise / growth)
        self.length = self.longest
        mass, _, stiffness = coefficients.at(coefficients.start)[:3]
        self.scale = np.sqrt(np.abs(np.diag(mass)))  # of velocities, so that energies count
        self.pace = float(np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(mass, stiffness))).min()))
        energies = [abs(z @ stiffness @ z), *np.abs(np.einsum("ki,ij,kj->k", rates, mass, rates))]
        self.energy = max(coefficients.energy, float(np.sqrt(max(energies))))
        self.size = max(coefficients.largest, np.abs(z).max(), np.abs(rates).max() / self.pace, 1e-300)

    def keep(self, end: float, curve: Curve) -> bool:
        """Take a step; say whether the motion is settled.

        Raises
        ------
        SolverError
            When it grows without bound.
        """
        if np.abs(curve(np.array([end]))[0]).max() > INTEGRATION.largest_motion * self.size:
            raise SolverError(
                f"the motion grows without bound: at {end:.6g} s it is more than {INTEGRATION.largest_motion:.0e} "
                "times what loads and start bend. It is unstable: a member buckles, or the drive is in a tongue of "
                "parametric resonance. Change loads or speed, or give more damping"
            )
        return self.taken(end, curve)

    def go_on(self, start: float, end: float, z: Array, rate: Array) -> tuple[Array, Array]:
        """Integrate from a state to a time, or until the motion is settled; gives the state there."""
        prepare = {COLLOCATION: self._collocation, SECOND_ORDER: self._second_order}.get(self.kind, self._first_order)
        ts = PETSc.TS().create(comm=PETSc.COMM_SELF)
        try:
            ts.setType(self.kind)
        except PETSc.Error as error:
            raise SolverError(f"PETSc has no steps of the transient_ts_type {self.kind!r}") from error
        pace, state = prepare(ts, start, z, rate)
        ts.setTime(pace * start)
        ts.setMaxTime(pace * end)
        defaults = {
            "ts_type": self.kind,
            "ts_adapt_type": "basic",
            "ts_alpha_radius": 0.5,  # so that what is too fast for the steps dies out
            "ts_rtol": self.schedule.tolerance,
            "ts_atol": self.schedule.tolerance * self.size,
            "ts_adapt_dt_max": pace * self.longest,
            "ts_exact_final_time": "matchstep",
            "ts_max_steps": INTEGRATION.most_steps - self.steps,
            "ts_max_snes_failures": -1,
            "snes_type": "newtonls",  # not ksponly: alpha2 takes velocities from the last evaluation of the residual
            "snes_rtol": 1e-9,
            "ksp_type": "preonly",
            "pc_type": "lu",
        }
        with configured(ts, "transient_", defaults, self.options):
            ts.solve(ts.getSolution())
            reason, self.length = ts.getConvergedReason(), ts.getTimeStep()
            self.steps += ts.getStepNumber()
            time = ts.getTime() / pace
            z, rate = state()
        logger.debug("%d steps up to %.6g s, the last of %.3g s", self.steps, time, self.length / pace)
        reasons = PETSc.TS.ConvergedReason
        if reason not in (reasons.CONVERGED_TIME, reasons.CONVERGED_USER):
            name, hint = name_of(reasons, reason), ""
            if reason == reasons.CONVERGED_ITS:
                name = "more than transient_ts_max_steps"
                hint = f" after {self.steps} of them. Give a larger time_tolerance or fewer cycles"
            raise SolverError(f"the time steps failed at {time:.6g} s, of {end:.6g} s ({name}){hint}")
        return z, rate

    def _collocation(self, ts: PETSc.TS, start: float, z: Array, rate: Array) -> Prepared:
        """Steps of our own."""
        schedule = self.schedule
        sizes = ((slice(None), self.energy),)
        context = Collocation(self.instant, schedule.tableau, schedule.tolerance, sizes, self.longest, self.keep)
        context.begin(ts, z, rate, self.length)
        return 1.0, lambda: tuple(ts.getSolution().array_r.copy().reshape(2, -1))

    def _second_order(self, ts: PETSc.TS, start: float, z: Array, rate: Array) -> Prepared:
        """Give TS the equation as it stands, in a time in which the slowest vibration has unit pace.

        TS measures errors of velocities by the tolerance of displacements.
        """
        size, pace, instant = len(z), self.pace, self.instant
        tangent = PETSc.Mat().createDense((size, size), comm=PETSc.COMM_SELF).setUp()
        u, v, f = (PETSc.Vec().createSeq(size) for _ in range(3))
        u.array[:], v.array[:] = z, rate / pace

        def function(ts: PETSc.TS, time: float, u: PETSc.Vec, v: PETSc.Vec, a: PETSc.Vec, f: PETSc.Vec) -> None:
            f.array[:] = instant.residual(time / pace, u.array_r, pace * v.array_r, pace**2 * a.array_r)

        def jacobian(ts: Any, time: float, u: Any, v: Any, a: Any, by_v: float, by_a: float, j: Any, p: Any) -> None:
            mass, damping, stiffness = instant.tangents(time / pace, u.array_r, pace * v.array_r)
            p.getDenseArray()[:] = pace**2 * by_a * mass + pace * by_v * damping + stiffness
            p.assemble()

        def state() -> tuple[Array, Array]:
            place, speed = ts.getSolution2()
            return place.array_r.copy(), pace * speed.array_r

        ts.setI2Function(function, f)
        ts.setI2Jacobian(jacobian, tangent, tangent)
        ts.setSolution2(u, v)
        ts.setTimeStep(self.schedule.tolerance / 10)  # in rad; alpha2 estimates its first acceleration only to order 1
        ts.setPostStep(self._kept(start, z, rate, pace, state))  # a monitor cannot stop the steps
        return pace, state

    def _first_order(self, ts: PETSc.TS, start: float, z: Array, rate: Array) -> Prepared:
        """Give TS the state ``(z, scale z')``."""
        n, instant, scale = len(z), self.instant, self.scale
        tangent = PETSc.Mat().createDense((2 * n, 2 * n), comm=PETSc.COMM_SELF).setUp()
        y, f = (PETSc.Vec().createSeq(2 * n) for _ in range(2))
        y.array[:] = np.concatenate([z, scale * rate])

        def function(ts: PETSc.TS, time: float, y: PETSc.Vec, slope: PETSc.Vec, f: PETSc.Vec) -> None:
            (z, speed), (z_slope, speed_slope) = (part.array_r.reshape(2, n) for part in (y, slope))
            f.array[:n] = scale * z_slope - speed
            f.array[n:] = instant.residual(time, z, speed / scale, speed_slope / scale)

        def jacobian(ts: Any, time: float, y: Any, slope: Any, shift: float, j: Any, p: Any) -> None:
            z, speed = y.array_r.reshape(2, n)
            mass, damping, stiffness = instant.tangents(time, z, speed / scale)
            below = [stiffness, (shift * mass + damping) / scale]
            p.getDenseArray()[:] = np.block([[shift * np.diag(scale), -np.eye(n)], below])
            p.assemble()

        def state() -> tuple[Array, Array]:
            z, speed = ts.getSolution().array_r.copy().reshape(2, n)
            return z, speed / scale

        ts.setEquationType(PETSc.TS.EquationType.IMPLICIT)
        ts.setIFunction(function, f)
        ts.setIJacobian(jacobian, tangent, tangent)
        ts.setSolution(y)
        ts.setTimeStep(self.schedule.tolerance / 10 / self.pace)
        ts.setPostStep(self._kept(start, z, rate, 1.0, state))
        return 1.0, state

    def _kept(self, start: float, z: Array, rate: Array, pace: float, state: State) -> Callable[[Any], None]:
        """Keep steps, with cubic polynomials: accelerations of stiff modes are too rough for a higher degree."""
        from scipy.interpolate import CubicHermiteSpline  # noqa: PLC0415  (slow to import, and a cycle needs none)

        latest = start, (z, rate)

        def keep(ts: PETSc.TS) -> None:
            nonlocal latest
            now = ts.getTime() / pace, state()
            curve = CubicHermiteSpline((latest[0], now[0]), *np.stack([latest[1], now[1]], axis=1))
            if self.keep(now[0], lambda times: (curve(times), curve(times, 1))):
                ts.setConvergedReason(PETSc.TS.ConvergedReason.CONVERGED_USER)
            if growth := self.instant.growth(now[0], *now[1]):
                ts.setTimeStep(min(ts.getTimeStep(), pace * self.rise / growth))
            latest = now

        return keep
