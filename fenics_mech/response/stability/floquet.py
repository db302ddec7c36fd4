"""Stability of a periodic motion: Floquet multipliers of the equation linearised about it.

A small disturbance of the state is multiplied by the monodromy matrix in each cycle, the product of the collocation
steps' transitions. Its eigenvalues are the multipliers: the motion is stable where all are inside the unit circle.

Gauss points are taken. On an undamped oscillator they keep the magnitude of a multiplier exactly, and its angle to
order 2s; Radau points would damp it by ``N (omega h)^(2s) (s!/(2s)!)^2/2`` in a cycle of N steps. Gauss points
hardly damp what is too fast for the steps, so that such disturbances are left out. They count where the stiffness is
not positive somewhere in the cycle and they grow without turning, as a buckled strut diverges.

Source: Nayfeh and Balachandran, Applied Nonlinear Dynamics, ch. 3; Hairer and Wanner, Solving Ordinary Differential
Equations II, section IV.5.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index
from fenics_mech.eigenmodes import Modes
from fenics_mech.errors import UnstableError
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.stability.multipliers import MULTIPLIERS, eigenpairs
from fenics_mech.response.stability.resonance import blamed, refuse_resonance
from fenics_mech.response.stability.turning import LinkAxes, alike, separated, turns

Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class StabilityLimits:
    """Limits of the judgement of stability."""

    beside: float = 0.1  # distance of a multiplier from 1, beyond which it shows no resonance
    longest_step: float = 2 / 3  # angle (rad) per collocation point that a disturbance may turn by in a step
    tolerance: float = 1e-4  # of the magnitude: what steps may make of an undamped motion (7e-6 for 360 on the seed)
    kept: int = 6  # multipliers that are kept


STABILITY = StabilityLimits()


@dataclass(frozen=True)
class Stability:
    """Leading Floquet multipliers, largest magnitude first; none where all vibrations are too fast for the steps.

    Parameters
    ----------
    multipliers
        Factor of each disturbance in a cycle, ``(multipliers,)``.
    frequency
        Its frequency (Hz) in the axes of the link that has the largest part of it: the angle of the multiplier, with
        the whole turns of the disturbance in a cycle there. In fixed axes it is more or less by that link's speed. NaN
        where damping leaves no more of the disturbance than rounding does.
    link
        Name of that link.
    mode
        Number, from 0, of the mode that has the largest part of it at the start of the cycle, as the mass weighs it.
    share
        That part, 0..1.
    vibrates
        Whether its state turns, and does not creep, held by a strong damper.
    period
        Duration of a cycle (s).
    limit
        Frequency of the fastest vibration that the steps follow (Hz): faster ones are not judged.
    enough_steps
        Steps of a cycle that are enough to tell what diverges from what damping ends; 0 where the present ones are.
    """

    multipliers: Complex
    frequency: Array
    link: tuple[str, ...]
    mode: Index
    share: Array
    vibrates: NDArray[np.bool_]
    period: float
    limit: float
    enough_steps: int

    @property
    def growth_rate(self) -> Array:
        """Rate at which each disturbance grows, or decays where it is negative (1/s)."""
        return np.log(np.maximum(np.abs(self.multipliers), np.finfo(float).tiny)) / self.period

    @property
    def stable(self) -> bool:
        """Whether no disturbance grows."""
        return bool((np.abs(self.multipliers) <= 1 + STABILITY.tolerance).all())

    def refuse_unstable(self) -> None:
        """Raise an `UnstableError` that names the worst disturbance when the motion is unstable."""
        if not self.stable:
            worst, frequency = self.multipliers[0], self.frequency[0]
            steadily = frequency * self.period < STABILITY.tolerance
            how = (
                "without vibrating (buckling)"
                if steadily
                else f"at {frequency:.4g} Hz in the axes of link {self.link[0]}"
            )
            steps = f"sub_intervals, as these follow up to {self.limit:.4g} Hz"
            advice = f"Change the speed or give more damping, or more {steps}"
            if self.enough_steps:
                advice = (
                    f"The stiffness is not positive at some positions. Take more sub_intervals: {self.enough_steps} "
                    "are enough to tell what diverges there from what damping ends. If it stays unstable, change the "
                    "speed or give more damping"
                )
            elif frequency > self.limit:
                advice = f"Take more {steps}. If it stays unstable, change the speed or give more damping"
            raise UnstableError(
                f"the periodic motion is unstable: a small disturbance grows by {abs(worst):.6g} in each cycle "
                f"(multiplier {worst:.5g}, {self.growth_rate[0]:.3g} 1/s) {how}; mode "
                f"{self.mode[0] + 1} carries {self.share[0]:.0%} of it. {advice}. "
                "analysis.allow_unstable lets it pass"
            ).finer_by(**({"sub_intervals": self.enough_steps} if self.enough_steps else {}))

    def nearest(self) -> tuple[float, str]:
        """Find which vibration is next to resonance: the distance of its multiplier from 1, and words for it."""
        distance = np.where(self.vibrates, np.abs(self.multipliers - 1), np.inf)
        if not np.isfinite(distance).any():
            return np.inf, "none of its vibrations is known"
        i = int(distance.argmin())
        return float(distance[i]), blamed(int(self.mode[i]), float(self.frequency[i]), self.period, float(distance[i]))

    def refuse_resonance(self) -> None:
        """Raise a `SolverError` that names mode and harmonic when the drive is at an undamped resonance."""
        refuse_resonance(*self.nearest())


def floquet(
    flow: Flow,
    start: Matrices,
    axes: LinkAxes,
    modes: Modes,
    options: Mapping[str, Any] | None = None,
    damped: Callable[[], Flow] | None = None,
) -> Stability:
    """Find the multipliers that decide on stability.

    Parameters
    ----------
    flow
        The steps of a cycle at Gauss points, of the equation linearised about the motion.
    start, modes
        The equation and the modes, with the start of the cycle first, to find which mode a disturbance belongs to.
    axes
        The links' axes at the starts of the steps.
    options
        PETSc options with the prefix "stability_".
    damped
        Gives the same steps at Radau points. By them the slow ones of many disturbances are found without the others,
        and what diverges is told from fast vibrations that Gauss points do not follow.

    Raises
    ------
    SolverError
        When SLEPc does not converge.
    """
    limit, n = STABILITY.longest_step * len(flow.tableau.points) / float(np.max(flow.step)), flow.size
    diverging = bool(flow.matrices.growth)  # what grows so fast without turning is a divergence, and no vibration
    followed = 0 < flow.matrices.growth < limit
    slow = damped() if damped is not None and 2 * n > MULTIPLIERS.few_states and not diverging else None
    for found in eigenpairs(flow, slow, options or {}):
        (values, states), every, rounding = found
        judged, enough = _judged(flow, values, states, start, limit * flow.mean_step)
        if followed and damped is not None:
            bounded = np.abs(values[judged]) <= 1 + STABILITY.tolerance
            judged = judged[[bound or _grows(damped(), states[i]) for bound, i in zip(bounded, judged)]]
        if enough or every:
            break
    states[judged] = separated(axes, flow, values[judged], states[judged])
    kept = _leading(values, judged)
    values, states = values[kept], states[kept]
    period = float(np.sum(flow.duration))
    mode, share = _carriers(start, states[:, :n], states[:, n:] / flow.mean_step, modes)
    turned, link, vibrates = turns(axes, flow, values, states, modes)
    known = np.abs(values) > rounding
    frequency = np.where(known, np.abs(turned) / period, np.nan)
    names = tuple(axes.names[i] for i in link)
    needed = 0 if followed or not diverging else math.ceil(1.05 * len(flow.duration) * flow.matrices.growth / limit)
    return Stability(values, frequency, names, mode, share, vibrates & known, period, limit / (2 * np.pi), needed)


def _judged(flow: Flow, values: Complex, states: Complex, start: Matrices, limit: float) -> tuple[Index, bool]:
    """Find the disturbances that count: those that the steps can follow, and those that grow without turning.

    The largest are examined, few at a time, until there are enough, and the one next to 1 is among them. Those of a
    smaller magnitude are further off. The second value says whether there were enough. There are also enough where many
    are too fast, as Radau points damp these more than the others.
    """
    order, found = np.argsort(-np.abs(values), kind="stable"), np.zeros(0, dtype=np.int64)

    def enough(next_size: float) -> bool:
        """Whether those of no larger magnitude can be left: they are further off."""
        nearest = min(np.abs(values[found] - 1).min(initial=np.inf), STABILITY.beside)
        return len(found) >= STABILITY.kept and 1 - next_size > nearest

    sizes = np.abs(values[order])
    for first in range(0, len(order), STABILITY.kept):
        some = order[first : first + STABILITY.kept]
        if enough(sizes[first]):
            return np.sort(found), True
        counts = _slow_enough(flow, states[some], start, limit)
        if flow.matrices.growth:  # what grows so fast without turning is a divergence, and no vibration
            counts |= (values[some].real > 1 + STABILITY.tolerance) & (
                np.abs(values[some].imag) < STABILITY.tolerance * np.abs(values[some])
            )
        found = np.append(found, some[counts])
    return np.sort(found), enough(sizes.min(initial=1.0)) or 2 * len(found) <= len(order)


def _grows(damped: Flow, state: Complex) -> bool:
    """Whether a disturbance of the start of the cycle is larger at its end by steps that damp what is too fast."""
    states, powers = damped.passed(state[None])
    unit = np.tile(damped.unit, 2)
    first, last = np.linalg.norm(states[[0, -1], 0] * unit, axis=1)
    return bool(np.log(last / first) + powers[-1, 0] > 0)


def _leading(values: Complex, judged: Index) -> Index:
    """Few of those that count, largest magnitude first, and the one next to 1, which shows a resonance."""
    kept = judged[np.argsort(-np.abs(values[judged]), kind="stable")]
    nearest = kept[np.abs(values[kept] - 1).argsort(kind="stable")][:1]
    return np.concatenate([kept[: STABILITY.kept], nearest[~np.isin(nearest, kept[: STABILITY.kept])]])


def _slow_enough(flow: Flow, states: Complex, start: Matrices, limit: float) -> NDArray[np.bool_]:
    """Whether the steps can follow disturbances: their velocity is below limit times the displacement over a cycle.

    The limit is the angle (rad) of a vibration in a step that the steps can follow. Both sizes are weighed by mass,
    which the links' stiff directions do not upset.
    """
    passed = alike(flow, states)[:-1]  # what dies out counts no less
    slow, fast = (np.sum(_norm(start, part) ** 2, axis=0) for part in np.split(passed, [flow.size], axis=-1))
    return np.asarray(np.sqrt(fast / np.maximum(slow, np.finfo(float).tiny)) < limit)


def _carriers(start: Matrices, q: Complex, rate: Complex, modes: Modes) -> tuple[Index, Array]:
    """Find the mode with the largest part of each disturbance, displacement and velocity alike, and that part."""
    momenta = start.mass.at(0).T @ modes.shapes[0].T
    parts = [np.abs(states @ momenta) ** 2 / _norm(start, states)[:, None] ** 2 for states in (q, rate)]
    share = np.mean(parts, axis=0)
    return share.argmax(axis=1), share.max(axis=1)


def _norm(start: Matrices, states: Complex) -> Array:
    """Root of ``x^H M x`` of each state, ``(..., states)``."""
    flat = states.reshape(-1, states.shape[-1])
    momenta = (start.mass.at(0) @ flat.T).T.reshape(states.shape)
    square = np.sum(states.conj() * momenta, axis=-1).real
    return np.sqrt(np.maximum(square, np.finfo(float).tiny))
