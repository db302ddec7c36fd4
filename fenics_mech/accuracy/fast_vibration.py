"""Vibration too fast for the steps of an estimate in time, and how far another theory brings it out of phase.

Two theories put its frequencies a little apart. In time the two vibrations go out of phase, until they differ by as
much as two of a random phase.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.accuracy.quantities import Quantities
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import Matrices


@dataclass(frozen=True)
class PhaseLimits:
    """How the phase is estimated; measured on ten machines: 0.8 to 2.7 of the truth, 0.01 to 1 without it."""

    looked_at: int = 8  # positions of a cycle at which frequencies are compared
    apart: float = np.pi / 2  # rad: vibrations of a random phase differ by sqrt(2) times their amplitude
    massless: float = 1e-13  # of the largest 1/omega^2: below it nothing vibrates


PHASE = PhaseLimits()


def phase_rates(rung: Equation, exact: Matrices, lost: tuple[Array, Array]) -> Array:
    """Give by how much faster or slower than one theory another vibrates (rad/s), ``(angles,)``.

    It is the mean over the modes, by the energy that the vibration has in each.

    Parameters
    ----------
    rung
        The equation of the one theory.
    exact
        The matrices of the other, linearised about the motion.
    lost
        Displacement and velocity of the vibration, ``(angles, coordinates)`` each.
    """
    count = len(lost[0])
    parts = np.array_split(np.arange(count), min(PHASE.looked_at, count))
    return np.concatenate([np.full(len(part), _rate_at(rung, exact, lost, part[len(part) // 2])) for part in parts])


def _rate_at(rung: Equation, exact: Matrices, lost: tuple[Array, Array], k: int) -> float:
    mass, stiffness = rung.linear.mass.symmetric.dense(k), rung.linear.stiffness.symmetric.dense(k)
    try:
        square, shapes = eigh(mass, stiffness)  # 1/omega^2; the shapes have a strain energy of 1/2
        other = eigh(exact.mass.symmetric.dense(k), exact.stiffness.symmetric.dense(k), eigvals_only=True)
    except np.linalg.LinAlgError:  # one of them buckles
        return np.inf
    vibrates = (square > PHASE.massless * square[-1]) & (other > PHASE.massless * other[-1])
    elastic, kinetic = ((shapes.T @ (stiffness @ part[k])) ** 2 for part in lost)
    energy = (elastic + square * kinetic)[vibrates]
    apart = np.abs(1 / np.sqrt(other[vibrates]) - 1 / np.sqrt(square[vibrates]))
    return float(energy @ apart / max(energy.sum(), TINY))


def with_vibration(change: Quantities, vibration: Quantities, phase: Array) -> Iterator[tuple[str, Array]]:
    """Add to a change what two vibrations of a phase between them differ by; give the largest by quantity.

    Parameters
    ----------
    change
        Change of slower motion.
    vibration
        The vibration that it does not have.
    phase
        At each of their angles (rad), ``(angles,)``.
    """
    share = 2 * np.sin(np.minimum(phase, PHASE.apart) / 2)
    for name, size in change.sizes.items():
        yield name, (size + share[:, None] * vibration.sizes[name]).max(axis=0, initial=0.0)
