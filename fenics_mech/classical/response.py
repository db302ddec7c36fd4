"""The answer of the truncated equation (5.1): modes, sub-intervals that are joined, and what the modes left out add."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array, Index, times
from fenics_mech._constants import TINY
from fenics_mech._guard import require_memory
from fenics_mech.classical.joining import Closed, flat, forced, free, joins, marched, refuse_ringing, steady, whole
from fenics_mech.classical.mechanism import Mechanism, Transformation
from fenics_mech.classical.modes import Modes, slowest
from fenics_mech.classical.resonance import blaming, magnification, of_modes, refuse_magnified
from fenics_mech.estimate.frequencies import highest_felt
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.scene import Scene

STATIC = 0.5  # share of the last frequency kept, up to which the modes left out answer statically
LEAST_ENERGY = 1e-4  # share of the largest elastic energy's square root, below which no harmonic is sought
LEAST_RATIO = 1e-6  # of damping, for which resonance is looked for
JOINED = 24  # matrices over the modes of a sub-interval that are held at a time


@dataclass(frozen=True)
class SubIntervals:
    """Modes as oscillators with constant coefficients about positions, with the loads on them."""

    scene: Scene  # the scene
    mechanism: Mechanism  # the mechanism at the middles of the sub-intervals, and its modes that are kept there
    modes: Modes
    duration: Array  # of the sub-intervals (s), (positions, 1)
    load: Array  # load on the coordinates at the middles, and its rate by time, (positions, coordinates)
    slope: Array

    @classmethod
    def of(cls, scene: Scene, made: SceneMachine, times: Array, edges: Array, modes: int | None = None) -> SubIntervals:
        """Build the mechanism, and find its modes."""
        # times, edges (s)
        P = Transformation.of(made, times)
        wanted = scene.analysis.modes if modes is None else modes
        count = len(P.kept) if wanted == "all" else min(wanted, len(P.kept))
        what = f"{len(times)} sub-intervals with {count} modes"
        require_memory(JOINED * len(times) * count**2, what, "Take fewer modes, or fewer sub_intervals")
        mechanism = Mechanism.of(P)
        slope = np.zeros_like(P.load)
        if scene.analysis.load == "linear":
            slope = np.diff(Transformation.of(made, edges, P).load, axis=0) / np.diff(edges)[:, None]
        duration = np.full((len(times), 1), times[1] - times[0])
        return cls(scene, mechanism, slowest(mechanism, count, scene.petsc), duration, P.load, slope)

    def thinned(self, every: int, those: Index | slice = slice(None)) -> SubIntervals:
        """Give sub-intervals so many times as long about some of the positions of a cycle, with some of the modes."""
        # `every` is an odd divisor of their number, or 2.
        which, count = np.arange(0, len(self.load), every), len(self.load)
        duration, load, slope = every * self.duration[which], self.load[which], self.slope[which]
        if every % 2:  # it rises by as much as those that it takes the place of
            around = np.arange(-(every // 2), every // 2 + 1)
            slope = self.slope[(which[:, None] + around) % count].mean(axis=1)
        else:
            slope = self.load[(which + 1) % count] - self.load[which - 1]
            if count % 2:  # it begins and ends at a position, and is not about one
                duration[-1] = self.duration[-1]
                load[-1], slope[-1] = (self.load[-2] + self.load[-1]) / 2, self.load[-1] - self.load[-2]
            slope = slope / duration * bool(self.slope.any())
        part = slice(0, None, every)
        mechanism, modes = self.mechanism.part(part), self.modes.part(part, those)
        return SubIntervals(self.scene, mechanism, modes, duration, load, slope)

    @property
    def zeta(self) -> Array:
        """Damping ratios (E.12), ``(positions, modes)``."""
        return ratios_of(self.scene, self.modes.omega)

    def straining_by(self, displacements: Array) -> Array:
        """Give rates at which turning strains the modes, by displacements ``(positions, any, coordinates)`` (1/s)."""
        strained = self.modes.shapes / self.modes.omega[..., None] ** 2
        return self.mechanism.strain_by_turning(strained, displacements)

    @cached_property
    def straining(self) -> Array:
        """Rates at which turning strains the modes, ``(positions, modes, modes)`` (1/s); 0 where no mode turns."""
        found = self.straining_by(self.modes.shapes)
        return np.zeros_like(found) if self.scene.analysis.join == "modal" else found

    @cached_property
    def _join(self) -> Array:
        return joins(self.scene.analysis.join, self.modes, self.zeta, self.straining, self.duration)

    @cached_property
    def closed(self) -> Closed:
        """All of them joined to a cycle (5.16)."""
        over = whole(free(self.modes.omega, self.zeta, self.duration))
        return Closed(self._join @ over, self.scene.petsc)

    def blame(self) -> tuple[float, str]:
        """Find which mode is next to resonance, as `of_modes` does."""
        frequency = self.modes.omega.mean(axis=0) / (2 * np.pi)
        return of_modes(self.closed.transitions, frequency, float(self.duration.sum()))

    def starts(self, load: Array, slope: Array) -> Array:
        """Give the states at their starts in a cycle under modal loads ``(positions, modes)``, flat."""
        omega, zeta, step = self.modes.omega, self.zeta, self.duration
        ends = flat(forced(omega, zeta, load - slope * step / 2, slope, step))
        with blaming(self.blame):
            return self.closed.solve(times(self._join, ends))

    def periodic(self, load: Array, slope: Array) -> Array:
        """Give the states at the middles in a cycle under modal loads, ``(positions, modes, 2)``."""
        omega, zeta, half = self.modes.omega, self.zeta, self.duration / 2
        to_middle = forced(omega, zeta, load - slope * half, slope, half)
        starts = self.starts(load, slope)
        return unflat(times(whole(free(omega, zeta, half)), starts)) + to_middle

    @cached_property
    def loads(self) -> tuple[Array, Array]:
        """Modal loads at the middles, and their slopes, ``(positions, modes)`` each (5.2)."""
        return self.modes.modal(self.load), self.modes.modal(self.slope)

    def answer(self, states: Array) -> Response:
        """Give the response of states at the middles, ``(positions, modes, 2)``."""
        load, y = self.loads[0], states[..., 0]
        static, answering = np.zeros_like(self.load), np.zeros_like(load)
        if self.scene.analysis.static_correction:
            static, answering = self.mechanism.stiffness.solve(self.load), load
        zeta, omega = self.zeta, self.modes.omega
        rate = states[..., 1] * omega + times(self.straining, y)
        q = static + self.modes.superposed(y - answering / omega**2)  # (5.3)
        elastic = self.modes.superposed(answering - omega**2 * y)
        return Response(self, states, q, elastic, 2 * zeta * rate / omega)

    def cycle(self) -> Response:
        """Give the periodic motion."""
        states, analysis = self.periodic(*self.loads), self.scene.analysis
        refuse_magnified(self.condition, self.blame)
        if not analysis.allow_ringing:
            swinging = states - steady(self.modes.omega, self.zeta, *self.loads)
            energy = (self.modes.omega**2)[..., None] * swinging**2
            most = (self.modes.omega**2 * states[..., 0] ** 2).sum(axis=1).max()
            share = np.sqrt(energy.sum(axis=2).max(axis=0) / max(most, TINY))
            count = round(self.scene.period / self.duration[0, 0])
            refuse_ringing(self.modes.omega, self.scene.period, count, share)
        return self.answer(states)

    @cached_property
    def condition(self) -> float:
        """How many times a relative error of each sub-interval comes out in the motion, by estimate."""
        return magnification(self.closed, self.starts(*self.loads))

    def march(self) -> Response:
        """Give the motion in time from rest with straight links, in the middle of the first (E.13)."""
        omega, zeta, half, (load, slope) = self.modes.omega, self.zeta, self.duration / 2, self.loads
        if not self.scene.analysis.allow_ringing:
            count = round(self.scene.period / self.duration[0, 0])
            refuse_ringing(omega, self.scene.period, count, np.ones(omega.shape[1]))
        to_end, to_middle = (forced(omega, zeta, start, slope, half) for start in (load, load - slope * half))
        over = whole(free(omega, zeta, half))
        return self.answer(unflat(marched(self._join, over, flat(to_end), flat(to_middle))))

    # ---- without an error ----
    def with_modes_left_out(self, found: Response) -> Response:
        """Give a periodic response with the inertia of the modes left out, and what their motion does to those kept."""
        # They answer statically to the inertia that the static answer lacks.
        missing, inertia = self._left_out(found)
        static = self.mechanism.stiffness.solve(missing)
        q, step = found.q + static, self.duration
        left = q - self.modes.superposed(self.modes.coordinates(q))
        rate, second = (self.modes.coordinates(by_time(left, step)) for by_time in (rates, seconds))
        strained = rate + self.straining_by(left[:, None])[..., 0]
        load = -second - 2 * self.zeta * self.modes.omega * strained
        y = self.periodic(load, rates(load, step))[..., 0]
        moved = self.modes.superposed(-(self.modes.omega**2) * y)
        return replace(found, q=q + self.modes.superposed(y), elastic=found.elastic + inertia + moved)

    def _left_out(self, found: Response) -> tuple[Array, Array]:
        """Load on the modes left out that is missing in the static answer, and the acceleration that it is of."""
        acceleration = seconds(found.q, self.duration)
        acceleration -= self.modes.superposed(self.modes.coordinates(acceleration))
        missing = -self.mechanism.mass.times(acceleration)
        if not self.scene.analysis.static_correction:
            missing += self.load - np.einsum("kmi,km->ki", self.modes.momenta, self.loads[0])
        return missing, acceleration

    def reach(self, found: Response) -> float:
        """Frequency (rad/s) of the highest harmonic of the load on modes left out that would matter on one of them."""
        # Beside the rest, that is, measured by the square root of the elastic energy. It is 0 where it is well below
        # all of theirs: they are not slower than those kept.
        missing, _ = self._left_out(found)
        static, omega = self.mechanism.stiffness.solve(missing), self.modes.omega
        energy = np.sum(omega**2 * self.modes.coordinates(found.q) ** 2, axis=1).max()
        left_out = np.abs(np.einsum("ki,ki->k", missing, static)).max()
        enough = float(max(np.sqrt(left_out), LEAST_ENERGY * np.sqrt(energy)))
        loss = 2 * max(float(self.zeta.min()), LEAST_RATIO)
        highest = 2 * np.pi * highest_felt(missing, static, loss, enough) / self.scene.period
        return highest if highest > STATIC * omega.min(axis=0).max() else 0.0

    def halved(self, found: Response) -> Response:
        """Give the response at every second position by half as many sub-intervals."""
        # Modes that half as many are too few for may ring there: they answer statically where that changes less.
        every, omega = slice(0, len(self.load) - len(self.load) % 2, 2), self.modes.omega
        slow = 2 * omega.max(axis=0) / (2 * np.pi) * 2 * self.duration[0] <= 1
        y, still = found.states[every, :, 0], (self.loads[0] / omega**2)[every]
        changes = []
        for followed in [np.ones_like(slow)] if slow.all() else [np.ones_like(slow), slow]:
            change = still - y
            if followed.any():
                coarse = self.thinned(2, np.flatnonzero(followed))
                change[:, followed] = coarse.periodic(*coarse.loads)[: len(y), :, 0] - y[:, followed]
            changes.append(change)
        change = min(changes, key=lambda one: (omega[every] ** 2 * one**2).sum(axis=1).max())
        here = found.part(every)
        modes = here.by.modes
        moved = -modes.superposed(modes.omega**2 * change)
        return replace(here, q=here.q + modes.superposed(change), elastic=here.elastic + moved)


@dataclass(frozen=True)
class Response:
    """The response at the middles of sub-intervals."""

    by: SubIntervals  # the sub-intervals
    states: Array  # y and y' over omega of every mode, (positions, modes, 2)
    q: Array  # coordinates (m, rad), (positions, coordinates)
    # their accelerations in balance with the elastic forces alone: what damps modes is balanced by its own stress
    elastic: Array
    viscous: Array  # modal coordinates whose elastic forces are those of the damping, (positions, modes)

    @property
    def damped(self) -> tuple[Array, Array]:
        """Coordinates by whose elastic forces links and dampers act together, and the accelerations with them."""
        modes = self.by.modes
        drag = modes.superposed(modes.omega**2 * self.viscous)
        return self.q + modes.superposed(self.viscous), self.elastic - drag

    @property
    def power(self) -> Array:
        """What the damping of modes takes ``(positions,)`` (W)."""
        omega = self.by.modes.omega
        rate = self.states[..., 1] * omega + times(self.by.straining, self.states[..., 0])
        return np.asarray((omega**2 * self.viscous * rate).sum(axis=1))

    def part(self, which: slice) -> Response:
        """Give it at some of the positions."""
        by = self.by
        there = replace(
            by,
            mechanism=by.mechanism.part(which),
            modes=by.modes.part(which),
            duration=by.duration[which],
            load=by.load[which],
            slope=by.slope[which],
        )
        arrays = (x[which] for x in (self.states, self.q, self.elastic, self.viscous))
        return Response(there, *arrays)


def ratios_of(scene: Scene, omega: Array) -> Array:
    """Give the damping ratios of modes, of the shape of `omega`: the last one stated holds for the modes after it."""
    stated = np.atleast_1d(scene.damping.ratio)
    return np.broadcast_to(stated[np.minimum(np.arange(omega.shape[1]), len(stated) - 1)], omega.shape)


def unflat(vectors: Array) -> Array:
    """States ``(positions, modes, 2)`` of vectors, as of `flat`."""
    return vectors.reshape(len(vectors), 2, -1).transpose(0, 2, 1)


def rates(values: Array, step: Array) -> Array:
    """Give rates over a cycle by central differences, ``(positions, ...)``."""
    return np.asarray((np.roll(values, -1, axis=0) - np.roll(values, 1, axis=0)) / (2 * step))


def seconds(values: Array, step: Array) -> Array:
    """Give second rates over a cycle by central differences, ``(positions, ...)``."""
    return np.asarray((np.roll(values, -1, axis=0) - 2 * values + np.roll(values, 1, axis=0)) / step**2)
