"""Resonances that the steps or the mesh miss, as they shift or weaken a vibration more than its damping does.

In a step of length h a vibration becomes ``R(i omega h)`` times as large instead of ``exp(i omega h)``: weaker
(dissipation) and late or early (dispersion). Elements put its frequency too high, and lumped mass too low. Where that
outweighs the damping also for the more accurate steps that estimate the error, or in the mesh, an estimate from the
motion found does not show how large the vibration may be. Its load and its damping do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index
from fenics_mech.accuracy.corrected_response import ESTIMATES
from fenics_mech.accuracy.frequency_errors import frequency_error, highest_felt, largest_frequency_error
from fenics_mech.accuracy.periodic_errors import more_accurate
from fenics_mech.eigenmodes import Modes, natural, solve_modes
from fenics_mech.forces.elastic_response import ElasticResponse, elastic_response
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.solution import CollocationSolution, HarmonicSolution, Solution
from fenics_mech.response.static.quasi_static import displacement_under

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class ResonanceLimits:
    """When a harmonic of a load counts as one that may meet a mode."""

    near: float = 0.02  # of a natural frequency, up to which a harmonic beside it is on it
    mesh_safety: float = 2.0  # on the error of a frequency by the mesh: with one element it is 1.6
    finer: float = 0.3  # times the damping ratio: change by more accurate steps or a mesh that conceals a resonance
    coarse: float = 0.05  # of a natural frequency by the mesh, from which its first order says too little
    felt: float = 1e-3  # of the largest static answer, as a root of energy, that a vibration is to count
    farthest: float = 1.25  # times its frequency, up to which the mesh may put a mode that a harmonic meets
    undamped: float = 1e-6  # loss factor, below which `least_loss` is taken
    least_loss: float = 1e-3  # loss factor that is taken where there is less
    even: float = 1e-6  # difference of steps of a phase, relative to them, that counts as none
    looked_at: int = 360  # positions of the cycle, for the harmonic with the largest vibration
    at_a_time: int = 4_000_000  # numbers: positions times harmonics


RESONANCES = ResonanceLimits()


def missed_vibrations(solution: Solution) -> Iterator[tuple[str, ElasticResponse, float]]:
    """Give by source of error a response with some of the vibration that the source may miss, and how much of it.

    Parameters
    ----------
    solution
        A solution of any method; only periodic ones have such vibrations.
    """
    match solution:
        case CollocationSolution():
            equation, cycle = solution.equation, solution.cycle
            points = more_accurate(solution.scene.analysis.stages)
            hidden = partial(hidden_by_steps, points, float(cycle.steps.duration.max()))
            resonances = _resonances_of(solution, equation, hidden)
            by_steps = resonances.met & hidden(resonances.harmonics, resonances.width)
            at, size = cycle.steps.regular, equation.system.size
            motion = solution.orbit.start[at, :size], solution.orbit.start_velocity[at, :size]
            for source, missed in (("time", by_steps), ("mesh", resonances.by_mesh)):
                yield from _beside(source, equation, motion, resonances, missed)
        case HarmonicSolution():
            cycle = solution.cycle
            resonances = _resonances_of(solution, cycle.start)
            q, rate = (part[cycle.steps.regular] for part in cycle.series_motion(solution.series)(np.zeros(1)))
            yield from _beside("mesh", cycle.start, (q, rate), resonances, resonances.by_mesh)


def _resonances_of(
    solution: CollocationSolution | HarmonicSolution,
    equation: Equation,
    hidden: Callable[[Array, Array], Mask] | None = None,
) -> Resonances:
    """Give the resonances that the loads of a scene's equation may have, on the modes of a solution or more of them.

    More modes are found only where the mesh or the steps might hide a resonance. Which ones steps hide is told by
    `hidden` from frequency and width.
    """
    rate, linear, system = abs(solution.scene.cycle_rate), equation.linear, equation.system
    modes, width = solution.modes.elastic, width_of(linear.loss)
    fastest = fastest_felt(system, linear.load, rate, width)
    by_steps = hidden is not None and hidden(np.arange(rate, fastest, rate), np.array([width])).any()
    if by_steps or largest_frequency_error(system, fastest) > RESONANCES.coarse:
        modes = enough_modes(system, modes, fastest, solution.scene.petsc)
    work = np.sum(modes.shapes * linear.damped(modes.shapes), axis=-1)
    loss = (work / modes.omega).mean(axis=0)
    return Resonances(modes, rate, linear.load, loss, frequency_error(system, modes))


def _beside(
    source: str, equation: Equation, motion: tuple[Array, Array], resonances: Resonances, missed: Mask
) -> Iterator[tuple[str, ElasticResponse, float]]:
    """Put a little of a missed vibration beside a motion, as an equation may be linear for small motions only."""
    if not missed.any():
        return
    more = [np.einsum("kmi,km->ki", resonances.modes.shapes, part) for part in resonances.vibration(missed)]
    moves, vibrates = (float(np.abs(q).max(initial=0.0)) for q in (motion[0], more[0]))
    share = ESTIMATES.little * moves / vibrates if vibrates > ESTIMATES.little * moves > 0 else 1.0
    yield source, elastic_response(equation, *(part + share * change for part, change in zip(motion, more))), share


@dataclass(frozen=True)
class Resonances:
    """Modes and the harmonics of their loads that may meet them.

    Parameters
    ----------
    modes
        Elastic modes at equal steps of time.
    rate
        Circular frequency of the cycle (rad/s).
    load
        Load on the coordinates, ``(angles, coordinates)``: where modes cross, modal loads may have corners.
    loss
        Loss factors, twice the damping ratios, ``(modes,)``.
    off
        By which share about the mesh has the natural frequencies wrong, ``(modes,)``; see `frequency_error`.
    """

    modes: Modes
    rate: float
    load: Array
    loss: Array
    off: Array

    @cached_property
    def harmonics(self) -> Array:
        """Circular frequencies of the harmonics that the angles show (rad/s)."""
        return self.rate * np.arange(len(self.load) // 2 + 1, dtype=float)

    @cached_property
    def width(self) -> Array:
        """Relative width of the modes' resonances: their loss factors, ``(modes,)``."""
        return np.array([width_of(loss) for loss in self.loss])

    @cached_property
    def met(self) -> Mask:
        """Which harmonics a mode of the linkage may meet by its mean frequency, ``(harmonics, modes)``.

        Between modes that a mesh is too coarse for, and beyond the last of them, the linkage has others.
        """
        omega, beside = self.modes.omega.mean(axis=0), RESONANCES.near + RESONANCES.mesh_safety * self.off
        least, most = (1 - beside) * omega, (1 + beside) * omega
        most = np.where(self.off > RESONANCES.coarse, np.maximum(most, np.append(least[1:], np.inf)), most)
        return (self.harmonics[:, None] > least) & (self.harmonics[:, None] < most)

    @property
    def shifted(self) -> Mask:
        """Which modes the mesh shifts by a share of their width, or more, ``(modes,)``."""
        return self.off > RESONANCES.finer * self.width / 2

    @property
    def by_mesh(self) -> Mask:
        """Those that the mesh may miss."""
        return self.met & (self.off > RESONANCES.coarse)

    def vibration(self, missed: Mask) -> tuple[Array, Array]:
        """Give modal coordinates and their rates, ``(angles, modes)`` each, of the largest missed vibration.

        It is the static answer to the load over the width of the resonance, of the harmonic with the largest one. Where
        a frequency varies slowly, harmonics are those over the phase of the mode's own vibration (WKB).

        Parameters
        ----------
        missed
            Which harmonics meet which mode unseen, ``(harmonics, modes)``.
        """
        modes, count = self.modes, len(self.load)
        y, y_rate = np.zeros((2, *modes.omega.shape))
        for m in np.flatnonzero(missed.any(axis=0)):
            pace = modes.omega[:, m] / modes.omega[:, m].mean()
            numbers, phase = np.flatnonzero(missed[:, m]), 2 * np.pi / count * np.cumsum(pace)
            loads = self._harmonics_of_load(phase, numbers)
            worst = int(np.abs(modes.shapes[:: max(1, count // RESONANCES.looked_at), m] @ loads).max(axis=0).argmax())
            found = -1j * (modes.shapes[:, m] @ loads[:, worst]) * np.exp(1j * numbers[worst] * phase)
            found /= modes.omega[:, m].mean() ** 2 * self.width[m]
            y[:, m], y_rate[:, m] = found.real, (1j * numbers[worst] * found).real * self.rate * pace
        return y, y_rate

    def _harmonics_of_load(self, phase: Array, numbers: Index) -> NDArray[np.complex128]:
        """Give harmonics of the load over a phase that grows by a turn in the cycle, ``(coordinates, numbers)``."""
        count = len(phase)
        if np.ptp(np.diff(phase, prepend=0.0)) < RESONANCES.even / count:
            return (np.fft.rfft(self.load, axis=0)[numbers] * np.exp(-1j * numbers * phase[0])[:, None]).T * (2 / count)
        parts = np.array_split(numbers, -(-count * len(numbers) // RESONANCES.at_a_time))
        turns = (np.exp(-1j * phase[:, None] * part) for part in parts)
        found = np.concatenate([self.load.T @ turn for turn in turns], axis=1, dtype=np.complex128)
        return found * (2 / count)


def width_of(loss: float) -> float:
    """Give the relative width of the resonance of a mode with a loss factor."""
    return loss if loss > RESONANCES.undamped else RESONANCES.least_loss


def hidden_by_steps(finer: Tableau, step: float, omega: Array, width: Array) -> Mask:
    """Say which resonances the steps hide that estimate the error of others.

    What these show, the difference from the others tells, which also hide it then.

    Parameters
    ----------
    finer
        Points of the steps that estimate the error.
    step
        Longest duration of a step (s).
    omega
        Angular frequencies (rad/s), ``(frequencies,)``.
    width
        Relative widths of resonances, ``(modes,)``.

    Returns
    -------
    numpy.ndarray
        Of bool, ``(frequencies, modes)``.
    """
    return finer.change(omega * step)[:, None] > RESONANCES.finer * width / 2


def fastest_felt(system: System, load: Array, rate: float, width: float) -> float:
    """Give the angular frequency (rad/s) up to which a harmonic of a load may be felt on a mode that it meets.

    Parameters
    ----------
    system
        The mechanism.
    load
        The load, ``(angles, coordinates)``.
    rate
        Angular frequency of the cycle (rad/s).
    width
        Least relative width of the resonances of modes.
    """
    # without axial forces the answer is rough, but there is one also where it buckles for a moment
    static = displacement_under(system.without_axial_forces, load)
    whole = float(np.sqrt(np.abs(np.einsum("ki,ki->k", load, static)).max()))
    return RESONANCES.farthest * rate * highest_felt(load, static, width, RESONANCES.felt * whole)


def enough_modes(system: System, modes: Modes, fastest: float, options: Mapping[str, Any]) -> Modes:
    """Give elastic modes up to a frequency, or more where more are known.

    Parameters
    ----------
    system, modes
        The mechanism, and elastic modes of it.
    fastest
        The angular frequency (rad/s).
    options
        PETSc options for eigenproblems.
    """
    wanted = 0
    while modes.omega.shape[1] < system.size and np.max(modes.omega.min(axis=0), initial=0.0) < fastest:
        wanted = 2 * modes.omega.shape[1] + 2 if wanted else slower_than(system, fastest) + 1
        modes = solve_modes(system, wanted, options).elastic
    return modes


def slower_than(system: System, omega: float) -> int:
    """Count the modes that are slower somewhere than an angular frequency, by Sylvester's law of inertia.

    Parameters
    ----------
    system
        The mechanism.
    omega
        The angular frequency (rad/s).
    """
    mass, stiffness = (part.symmetric for part in natural(system).held_matrices())
    pivots = (stiffness + mass * -float(omega**2)).factors.pivots
    return int((pivots < 0).sum(axis=1).max())
