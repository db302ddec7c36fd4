"""How well a cycle's equations determine the motion, and which mode and harmonic are to blame where they do not.

Near a resonance that nothing damps, or next to a stability border, the block-cyclic system is nearly singular. What it
makes of rounding is found by a load as large as rounding leaves of each transition's product, with signs by chance.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError


@dataclass(frozen=True)
class SingularityLimits:
    """When the equations of a cycle count as singular."""

    near: float = 1e-5  # distance of a multiplier from 1, at which a failure is put down to it
    singular: float = 1e-4  # the same, beyond which a magnification is that of stiff directions or of the estimate
    largest: float = 1e9  # magnification, beyond which rounding changes the motion by more than about 1e-6 of it


SINGULARITY = SingularityLimits()


class CyclicSystem(Protocol):
    """A system that closes a cycle."""

    def solve(self, right: Array) -> Array:
        """Solve for the states at the starts of all steps."""
        # right (steps, state)

    def roughly(self, right: Array) -> Array:
        """Solve for them to few digits."""

    def terms(self, states: Array) -> Array:
        """Give the size of what adds up to the states at the ends of the steps, from those at their starts."""
        # states (steps, state)


def magnification(cycle: CyclicSystem, states: Array) -> float:
    """How many times a relative error of each step comes out in the states of a cycle, by estimate."""
    # The load is an error of each number, in proportion to what adds up to it, with signs by chance. Source: Skeel,
    # J. ACM 26 (1979) 494.
    if not (size := np.abs(states).max()):
        return 0.0
    signs = np.random.default_rng(0).choice([-1.0, 1.0], states.shape)
    try:
        answer = cycle.roughly(signs * cycle.terms(states) / size)
    except SolverError:
        return np.inf
    return float(np.abs(answer).max())


@contextmanager
def blaming(blame: Callable[[], tuple[float, str]]) -> Iterator[None]:
    """Add to a `SolverError` which mode is at resonance, where one is."""
    try:
        yield
    except SolverError:
        refuse_resonance(*blame())
        raise


def refuse_resonance(distance: float, words: str) -> None:
    """Raise `SolverError` where a multiplier is so near to 1 that there is no periodic motion."""
    if distance < SINGULARITY.near:
        raise SolverError(f"there is no periodic motion: {words}. Give a damping ratio, or another speed")


def refuse_magnified(condition: float, blame: Callable[[], tuple[float, str]]) -> None:
    """Raise `SolverError` where rounding would show in the motion, as a multiplier is next to 1."""
    if condition < SINGULARITY.largest:
        return
    distance, words = blame()
    if distance < SINGULARITY.singular:
        raise SolverError(
            f"the equations of the cycle are nearly singular: a relative error in them comes out {condition:.1e} times "
            f"as large in the motion, as {words}. Give a damping ratio, or another speed"
        )


def of_modes(transitions: Array, frequency: Array, period: float) -> tuple[float, str]:
    """Find which mode is next to resonance, from the transitions of modal states, all displacements first."""
    # transitions (steps, 2 modes, 2 modes); frequency (modes,) (Hz); period (s)
    whole = transitions[0]
    for transition in transitions[1:]:
        whole = transition @ whole
    values, vectors = np.linalg.eig(whole)
    nearest = int(np.abs(values - 1).argmin())
    mode = int(np.sum(np.abs(vectors[:, nearest].reshape(2, -1)) ** 2, axis=0).argmax())
    distance = abs(complex(values[nearest] - 1))
    return distance, blamed(mode, float(frequency[mode]), period, distance)


def blamed(mode: int, frequency: float, period: float, distance: float) -> str:
    """Say that a mode is at resonance."""
    # frequency (Hz); period (s)
    return (
        f"mode {mode + 1} ({frequency:.6g} Hz), hardly damped, is at resonance with harmonic "
        f"{round(frequency * period)} of the drive ({1 / period:.6g} Hz): its multiplier is {distance:.1e} from 1"
    )
