"""Frequencies of small vibrations beside a periodic motion, by its multipliers and the held modes that they move in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.solve.held_modes import followed_modes
from fenics_mech.solve.periodic import Cycle

LEAST = 1e-4  # multipliers below: what has died away in a cycle has no turns that the steps could count


class RunningModes(NamedTuple):
    """Vibrations beside a periodic motion.

    Parameters
    ----------
    multipliers
        One of each conjugate pair, the largest first.
    rates
        Growth, and frequency, 0 or more, as the imaginary part (1/s).
    modes
        Number, from 0, of the held mode that has the largest part of each.
    """

    multipliers: Array
    rates: Array
    modes: Index

    def changed(self, change: Array, before: float, after: float) -> RunningModes:
        """Give the vibrations beside another motion."""
        # change (multipliers,); before, after (s)
        told = np.exp(1j * before * self.rates.imag) * np.abs(self.multipliers)
        turned = np.abs(told - self.multipliers) > np.abs(told - self.multipliers.conj())
        rates = (before * self.rates + np.where(turned, change.conj(), change)) / after
        return RunningModes(self.multipliers * np.exp(change), rates, self.modes)


def running_modes(cycle: Cycle, count: int = 6) -> RunningModes:
    """Give the largest multipliers and the rates of their vibrations, whose frequencies do not alias.

    A multiplier mu tells of a rate log(mu)/T + i k Omega with any whole k. Here k is the number of turns that the
    largest coordinate of a held mode makes in a cycle beside log(mu)/T.

    Parameters
    ----------
    cycle
        A periodic motion.
    count
        Multipliers at most.

    Returns
    -------
    RunningModes
        Of multipliers above 1e-4.
    """
    steps, machine = cycle.steps, cycle.machine
    period, n = steps.period, machine.n
    values, states = steps.multipliers(count)
    kept = (values.imag >= 0) & (np.abs(values) > LEAST)
    values, states = values[kept], states[:, kept]
    rates = np.log(values) / period
    if not len(values):
        return RunningModes(values, rates, np.zeros(0, dtype=int))
    after = steps.through(np.concatenate([states.real, states.imag], axis=1).T.copy(), along=True)[2]
    assert after is not None
    real, imaginary = np.split(after[..., :n], 2, axis=1)
    since = steps.ends - steps.ends[-1] + period
    beside = (real + 1j * imaginary) * np.exp(-rates[:, None] * since[:, None, None])  # (steps, multipliers, n)
    momenta = followed_modes(machine, steps.ends).momenta
    moving = np.array([own.T @ x.T for own, x in zip(momenta, beside)])  # (steps, modes, multipliers)
    largest = np.argmax(np.sum(np.abs(moving) ** 2, axis=0), axis=0)
    led = moving[:, largest, np.arange(len(values))]
    turns = np.round(np.angle(np.roll(led, -1, axis=0) / led).sum(axis=0) / (2 * np.pi))
    rates = rates + 2j * np.pi / period * turns
    return RunningModes(values, np.where(rates.imag < 0, rates.conj(), rates), largest)
