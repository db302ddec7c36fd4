"""Response in time from a given state, by PETSc's TS: how a motion begins, and whether it becomes periodic.

The equation's matrices are computed at many times at once, a cycle of the drive at a time, and interpolated between:
polynomials of degree 7 through Chebyshev points in windows of the cycle. TS integrates the second order equation as it
stands (alpha2, the generalised alpha method) or, of any other type, as one of first order.

Source: Chung and Hulbert, J. Appl. Mech. 60 (1993) 371; Balay et al., PETSc Users Manual, ch. 6.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from petsc4py import PETSc
from scipy.interpolate import BPoly

from fenics_mech._petsc import configured, name_of
from fenics_mech.beams.layout import element_dofs
from fenics_mech.effects.terms import Law
from fenics_mech.errors import SolverError
from fenics_mech.mechanism.equation import Array, Equation

NODES = 8  # of the interpolation in a window
PROBES = 16  # times in a cycle at which it is checked
LARGEST_ERROR = 1e-3  # of the matrices, by interpolation
SECOND_ORDER = "alpha2"
LONGEST_STEP = 1 / 40  # of a cycle


@dataclass(frozen=True)
class Span:
    """What is to be computed.

    Parameters
    ----------
    cycle
        Duration of a cycle of the drive at its speed (s).
    samples
        Equal parts of a cycle at whose ends the motion is given.
    cycles
        Cycles, at most.
    settled
        Difference of two successive cycles, relative to the largest displacement, at which to stop; 0 never stops.
    steady_after
        Time from which the drive is at its speed (s): cycles are compared from there on.
    tolerance
        Relative error of a time step.
    """

    cycle: float
    samples: int
    cycles: int
    settled: float
    steady_after: float
    tolerance: float


@dataclass(frozen=True)
class Course:
    """A motion in time: q and q' ``(times, coordinates)``, and how it came about.

    Parameters
    ----------
    time, displacement, velocity
        Times (s) and the motion there.
    change
        Difference of the last two cycles, relative; infinite where there is only one.
    steps
        Time steps that were made.
    interpolation
        Largest relative error of the interpolated matrices and load, found by trials.
    """

    time: Array
    displacement: Array
    velocity: Array
    change: float
    steps: int
    interpolation: float


@dataclass
class Coefficients:
    """Matrices of the equation at any time, by interpolation.

    Parameters
    ----------
    equation_at
        Gives the equation at many ascending times.
    cycle, windows
        Duration of a cycle (s), and the windows in it.
    repeats_after
        Time from which the matrices repeat in each cycle (s).
    """

    equation_at: Callable[[Array], Equation]
    cycle: float
    windows: int
    repeats_after: float
    error: float = 0.0
    law: Law | None = None
    dofs: Any = None
    weight: Array | None = None
    _tables: dict[int, Array] = field(default_factory=dict)
    _latest: tuple[float, list[Array]] = field(default=(-np.inf, []))
    _cuts: list[tuple[int, tuple[int, ...]]] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Place the nodes in a window, 0..1, with their barycentric weights."""
        odd = np.pi * (2 * np.arange(NODES) + 1) / (2 * NODES)
        self.nodes = (1 - np.cos(odd)) / 2
        self.barycentric = (-1.0) ** np.arange(NODES) * np.sin(odd)

    def at(self, time: float) -> list[Array]:
        """Scaled M, C, K and load, and with a nonlinear law P and P', at a time (s)."""
        if self._latest[0] != time:  # residual and tangents are asked for one after the other
            self._latest = time, self._interpolated(time)
        return self._latest[1]

    def _interpolated(self, time: float) -> list[Array]:
        cycle = int(time // self.cycle)
        number = min(cycle, int(np.ceil(self.repeats_after / self.cycle - 1e-9)))
        if number not in self._tables:
            self._tables = {old: table for old, table in self._tables.items() if old == number - 1}
            self._tables[number] = self._table(number)
        place = (time / self.cycle - cycle) * self.windows
        window = min(int(place), self.windows - 1)
        table = self._tables[number]
        flat = self._weights(place - window) @ table[window]
        return [flat[end - int(np.prod(shape)) : end].reshape(shape) for end, shape in self._cuts]

    def _weights(self, place: float) -> Array:
        """Lagrange polynomials at a place 0..1 in a window, by the barycentric formula (Berrut and Trefethen, 2004)."""
        gap = place - self.nodes
        if (hit := np.abs(gap).argmin()) is not None and abs(gap[hit]) < 1e-14:
            return np.eye(NODES)[hit]
        parts = self.barycentric / gap
        return parts / parts.sum()

    def _table(self, cycle: int) -> Array:
        """Everything at the nodes of all windows of a cycle, flat, ``(windows, nodes, entries)``; checks it, too."""
        step = self.cycle / self.windows
        start = cycle * self.cycle
        nodes = (start + step * (np.arange(self.windows)[:, None] + self.nodes)).ravel()
        probes = start + self.cycle * (np.arange(PROBES) + 0.5 / np.sqrt(2)) / PROBES
        times = np.concatenate([nodes, probes])
        order = np.argsort(times)
        flat = self._flat(self.equation_at(times[order]))[np.argsort(order)]
        table = flat[: len(nodes)].reshape(self.windows, NODES, -1)
        places = (probes - start) / step
        windows = np.minimum(places.astype(int), self.windows - 1)
        found = np.stack([self._weights(p - w) @ table[w] for p, w in zip(places, windows)])
        for end, shape in self._cuts[:4]:
            part = slice(end - int(np.prod(shape)), end)
            size = max(float(np.abs(flat[:, part]).max()), 1e-300)
            self.error = max(self.error, float(np.abs(found - flat[len(nodes) :])[:, part].max()) / size)
        if self.error > LARGEST_ERROR:
            raise SolverError(
                f"the matrices change too fast to be interpolated (error {self.error:.1e}): give more sub_intervals"
            )
        return table

    def _flat(self, equation: Equation) -> Array:
        """Scale the coordinates, so that axial and bending ones are alike, and put everything in rows, one per time."""
        linear = equation.linear
        if self.weight is None:
            self.weight = np.sqrt(np.abs(np.einsum("tii->i", linear.stiffness)) / len(linear.load))
        square = np.outer(self.weight, self.weight)
        parts = [linear.mass / square, linear.damping / square, linear.stiffness / square, linear.load / self.weight]
        self.law = equation.system.terms.law
        if self.law is not None:
            p, first, _ = equation.shape
            self.dofs = element_dofs(equation.system.beams.mesh)
            parts += [p / self.weight, (np.zeros_like(p) if first is None else first) / self.weight]
        ends = np.cumsum([int(np.prod(part.shape[1:])) for part in parts])
        self._cuts = [(int(end), part.shape[1:]) for end, part in zip(ends, parts)]
        return np.concatenate([part.reshape(len(part), -1) for part in parts], axis=1)


class _Motion:
    """Residual and tangents of the scaled equation at a time, as TS asks for them.

    TS measures errors of velocities by the tolerance of displacements. So its time is ``pace`` times ours, a radian of
    the slowest vibration.
    """

    def __init__(self, coefficients: Coefficients, time: float) -> None:
        self.coefficients = coefficients
        mass, _, stiffness = coefficients.at(time)[:3]
        self.pace = float(np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(mass, stiffness))).min()))

    def residual(self, time: float, z: Array, rate: Array, second: Array) -> Array:
        """``M z'' + C z' + K z + law - f``."""
        mass, damping, stiffness, load, *shape = self.coefficients.at(time)
        lack = mass @ second + damping @ rate + stiffness @ z - load
        law, dofs = self.coefficients.law, self.coefficients.dofs
        if law is None:
            return lack
        p, first = shape
        ends = law.force((p @ z)[None], (p @ rate + first @ z)[None])
        return lack + np.bincount(dofs.ravel(), weights=ends.ravel(), minlength=len(p)) @ p

    def tangents(self, time: float, z: Array, rate: Array) -> tuple[Array, Array, Array]:
        """M, and the tangents by z' and z."""
        mass, damping, stiffness, _, *shape = self.coefficients.at(time)
        law, dofs = self.coefficients.law, self.coefficients.dofs
        if law is None:
            return mass, damping, stiffness
        p, first = shape
        v, v_rate = (p @ z)[None], (p @ rate + first @ z)[None]
        _, by_v, by_rate = law.linearised(v, v_rate, law.tension(v, v_rate))
        here, turning = p[dofs], first[dofs]
        back = here.reshape(-1, len(z)).T
        damping = damping + back @ (by_rate[0] @ here).reshape(-1, len(z))
        stiffness = stiffness + back @ (by_v[0] @ here + by_rate[0] @ turning).reshape(-1, len(z))
        return mass, damping, stiffness

    def acceleration(self, time: float, z: Array, rate: Array) -> Array:
        """Give z'' at a state."""
        lack = self.residual(time, z, rate, np.zeros_like(z))
        return np.linalg.solve(self.coefficients.at(time)[0], -lack)


class _Record:
    """Keeps the states after all steps, and stops when two cycles are the same."""

    def __init__(self, motion: _Motion, span: Span, start: float) -> None:
        self.motion, self.span, self.first = motion, span, start
        self.times: list[float] = []
        self.states: list[Array] = []  # z, z', z''
        self.cycles, self.change = 0, np.inf

    def add(self, time: float, z: Array, rate: Array) -> bool:
        """Keep a state; tell whether the motion is periodic by now."""
        self.times.append(time)
        self.states.append(np.stack([z, rate, self.motion.acceleration(time, z, rate)]))
        ended = int((time - self.first) / self.span.cycle + 1e-9)
        if ended == self.cycles:
            return False
        self.cycles = ended
        last = self.first + self.span.cycle * (ended - 1 + np.arange(self.span.samples) / self.span.samples)
        before = last - self.span.cycle
        if before[0] < max(self.first, self.span.steady_after) - 1e-9 * self.span.cycle:
            return False
        now, then = (self.at(times)[0] for times in (last, before))
        self.change = float(np.abs(now - then).max() / max(np.abs(now).max(), 1e-300))
        return self.change < self.span.settled

    def at(self, times: Array) -> tuple[Array, Array]:
        """Give z and z' at times, by polynomials of degree 5 through the states of both ends of a step."""
        known = np.array(self.times)
        low = max(int(np.searchsorted(known, times[0], side="right")) - 1, 0)
        high = min(int(np.searchsorted(known, times[-1])) + 1, len(known))
        curve = BPoly.from_derivatives(known[low:high], np.stack(self.states[low:high]))
        return curve(times), curve(times, 1)


def integrate(
    coefficients: Coefficients, span: Span, time: float, q: Array, rate: Array, options: Mapping[str, Any]
) -> Course:
    """Integrate the equation from a state.

    Parameters
    ----------
    coefficients
        The equation at any time.
    span
        How long, and how accurately.
    time, q, rate
        Where the motion starts (s), with its displacement and velocity, ``(coordinates,)`` each.
    options
        PETSc options with the prefix "transient_"; transient_ts_type chooses the integrator.

    Raises
    ------
    SolverError
        When the time steps fail.
    """
    coefficients.at(time)
    assert coefficients.weight is not None
    weight = coefficients.weight
    motion = _Motion(coefficients, time)
    pace = motion.pace
    record = _Record(motion, span, time)
    record.add(time, q * weight, rate * weight)
    _, _, stiffness, load = coefficients.at(time)[:4]
    size = max(float(np.abs(np.linalg.solve(stiffness, load)).max()), float(np.abs(q * weight).max()), 1e-300)
    kind = str(options.get("transient_ts_type", SECOND_ORDER))
    defaults: dict[str, Any] = {
        "ts_type": kind,
        "ts_adapt_type": "basic",
        "ts_alpha_radius": 0.5,  # so that what is too fast for the steps dies out
        "ts_rtol": span.tolerance,
        "ts_atol": span.tolerance * size,
        "ts_adapt_dt_max": pace * LONGEST_STEP * span.cycle,
        "ts_exact_final_time": "matchstep",
        "ts_max_steps": 10_000_000,
        "ts_max_snes_failures": -1,
        "snes_type": "newtonls",  # not ksponly: alpha2 takes velocities from the last evaluation of the residual
        "snes_rtol": 1e-9,
        "ksp_type": "preonly",
        "pc_type": "lu",
    }
    ts = PETSc.TS().create(comm=PETSc.COMM_SELF)
    ts.setTime(pace * time)
    ts.setMaxTime(pace * (time + span.cycles * span.cycle))
    ts.setTimeStep(span.tolerance / 10)  # in rad; alpha2 estimates its first acceleration only to order 1
    (_second_order if kind == SECOND_ORDER else _first_order)(ts, motion, record, q * weight, rate * weight / pace)
    with configured(ts, "transient_", defaults, options):
        ts.solve(ts.getSolution())
        reason, steps = ts.getConvergedReason(), ts.getStepNumber()
    if reason not in (PETSc.TS.ConvergedReason.CONVERGED_TIME, PETSc.TS.ConvergedReason.CONVERGED_USER):
        raise SolverError(
            f"the time steps failed at {record.times[-1]:.6g} s ({name_of(PETSc.TS.ConvergedReason, reason)})"
        )
    times = time + span.cycle / span.samples * np.arange(record.cycles * span.samples + 1)
    z, z_rate = record.at(times)
    return Course(times, z / weight, z_rate / weight, record.change, steps, coefficients.error)


def _second_order(ts: PETSc.TS, motion: _Motion, record: _Record, z: Array, rate: Array) -> None:
    """Give TS the equation as it stands."""
    size, pace = len(z), motion.pace
    tangent = PETSc.Mat().createDense((size, size), comm=PETSc.COMM_SELF).setUp()
    u, v, f = (PETSc.Vec().createSeq(size) for _ in range(3))
    u.array[:], v.array[:] = z, rate

    def function(ts: PETSc.TS, time: float, u: PETSc.Vec, v: PETSc.Vec, a: PETSc.Vec, f: PETSc.Vec) -> None:
        f.array[:] = motion.residual(time / pace, u.array_r, pace * v.array_r, pace**2 * a.array_r)

    def jacobian(ts: Any, time: float, u: Any, v: Any, a: Any, by_v: float, by_a: float, j: Any, p: Any) -> None:
        mass, damping, stiffness = motion.tangents(time / pace, u.array_r, pace * v.array_r)
        p.getDenseArray()[:] = pace**2 * by_a * mass + pace * by_v * damping + stiffness
        p.assemble()

    def keep(ts: PETSc.TS) -> None:
        place, speed = ts.getSolution2()
        if record.add(ts.getTime() / pace, place.array_r.copy(), pace * speed.array_r):
            ts.setConvergedReason(PETSc.TS.ConvergedReason.CONVERGED_USER)

    ts.setI2Function(function, f)
    ts.setI2Jacobian(jacobian, tangent, tangent)
    ts.setSolution2(u, v)
    ts.setPostStep(keep)  # a monitor cannot stop the steps


def _first_order(ts: PETSc.TS, motion: _Motion, record: _Record, z: Array, rate: Array) -> None:
    """Give TS the state ``(z, z'/pace)``."""
    n, pace = len(z), motion.pace
    tangent = PETSc.Mat().createDense((2 * n, 2 * n), comm=PETSc.COMM_SELF).setUp()
    state, f = (PETSc.Vec().createSeq(2 * n) for _ in range(2))
    state.array[:] = np.concatenate([z, rate])

    def function(ts: PETSc.TS, time: float, y: PETSc.Vec, slope: PETSc.Vec, f: PETSc.Vec) -> None:
        (z, rate), (z_slope, rate_slope) = (part.array_r.reshape(2, n) for part in (y, slope))
        f.array[:n] = z_slope - rate
        f.array[n:] = motion.residual(time / pace, z, pace * rate, pace**2 * rate_slope)

    def jacobian(ts: Any, time: float, y: Any, slope: Any, shift: float, j: Any, p: Any) -> None:
        z, rate = y.array_r.reshape(2, n)
        mass, damping, stiffness = motion.tangents(time / pace, z, pace * rate)
        below = [stiffness, pace**2 * shift * mass + pace * damping]
        p.getDenseArray()[:] = np.block([[shift * np.eye(n), -np.eye(n)], below])
        p.assemble()

    def keep(ts: PETSc.TS) -> None:
        z, rate = ts.getSolution().array_r.copy().reshape(2, n)
        if record.add(ts.getTime() / pace, z, pace * rate):
            ts.setConvergedReason(PETSc.TS.ConvergedReason.CONVERGED_USER)

    ts.setEquationType(PETSc.TS.EquationType.IMPLICIT)
    ts.setIFunction(function, f)
    ts.setIJacobian(jacobian, tangent, tangent)
    ts.setSolution(state)
    ts.setPostStep(keep)  # a monitor cannot stop the steps
