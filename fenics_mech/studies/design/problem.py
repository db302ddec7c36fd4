"""A study as a problem of optimisation: variables from 0 to 1, and aims and limits that are about 1."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.scene.study import Study
from fenics_mech.studies.design.explorer import Explorer
from fenics_mech.studies.design.result_numbers import Quantity
from fenics_mech.studies.design.trial import Trial

FAILED = 10.0  # aim and excess of a limit where a trial failed, in units of those at the start
WITHIN = 1e-6  # excess of a limit that counts as none, relative
LEAST = 1e-9  # of a limit, that a number counts as


@dataclass(frozen=True)
class Bound:
    """A limit as ``sign * (number - limit) / scale <= 0``, or the logarithm of their ratio where both are sizes."""

    # Strains fall with powers of the dimensions, and their logarithms are nearly linear.

    of: str  # name of the number
    limit: float  # in SI
    sign: float  # 1 for the largest value, -1 for the least

    @property
    def words(self) -> str:
        """What is asked of the number."""
        return "at most" if self.sign > 0 else "at least"

    def excess(self, number: float, scale: float) -> float:
        """By how much the number is beyond the limit, in units of the scale."""
        if self._of_sizes:
            return self.sign * math.log(max(number, LEAST * self.limit) / self.limit)
        return self.sign * (number - self.limit) / scale

    @property
    def _of_sizes(self) -> bool:
        return self.limit > 0 and self.of.endswith((".max", ".rms"))

    def slope(self, number: float, scale: float) -> float:
        """Derivative of the excess by the number."""
        return self.sign / (max(number, LEAST * self.limit) if self._of_sizes else scale)


def bounds_of(study: Study) -> tuple[Bound, ...]:
    """Give the limits of a study in SI, the least and the most of each as one."""
    found: list[Bound] = []
    for limit in study.limits:
        quantity = Quantity.read(limit.of)
        pair = {-1.0: limit.least, 1.0: limit.most}
        read = {sign: quantity.in_si(value) for sign, value in pair.items() if value is not None}
        if len(read) == 2 and read[-1.0] > read[1.0]:
            message = f"the least {limit.of} of {read[-1.0]:g} is more than the most of {read[1.0]:g} (SI)"
            raise SceneError(message, place="study.limits", hint="Exchange `least` and `most`")
        found += [Bound(limit.of, value, sign) for sign, value in read.items()]
    return tuple(found)


@dataclass(frozen=True)
class Problem(Explorer):
    """The aims and limits of a study over variables that go from 0 to 1."""

    squares: bool = False  # whether trials count by the sum of the squares of their aims, and not by the sum

    @cached_property
    def aims(self) -> tuple[tuple[str, float], ...]:
        """Names of the aims, with 1 for those that are minimised and -1 for those that are maximised."""
        study = self.trials.design.study
        return (*((name, 1.0) for name in study.minimise), *((name, -1.0) for name in study.maximise))

    @property
    def trades_off(self) -> bool:
        """Whether there are several aims, of which each counts for itself."""
        return len(self.aims) > 1 and not self.squares

    @cached_property
    def bounds(self) -> tuple[Bound, ...]:
        """The limits of the study; see `bounds_of`."""
        return bounds_of(self.trials.design.study)

    @cached_property
    def scales(self) -> dict[str, float]:
        """Size of each number at the start; 1 where it is 0."""
        return {name: abs(value) or 1.0 for name, value in self.first.numbers.items()}

    def aims_of(self, trial: Trial) -> Array:
        """Aims of a trial, all to be minimised, in units of those at the start, ``(aims,)``."""
        if trial.failed:
            return np.full(len(self.aims), FAILED)
        return np.array([sign * trial.numbers[name] / self.scales[name] for name, sign in self.aims])

    def excess_of(self, trial: Trial) -> Array:
        """By how much a trial is beyond each limit, relative; negative within it, ``(limits,)``."""
        if trial.failed:
            return np.full(len(self.bounds), FAILED)
        return np.array([b.excess(trial.numbers[b.of], self._scale(b)) for b in self.bounds])

    def _scale(self, bound: Bound) -> float:
        """Size in whose units the excess of a limit is."""
        return abs(bound.limit) or self.scales[bound.of]

    def jacobian(self, unit: Array) -> tuple[Array, Array]:
        """Derivatives of aims and excess by the variables, ``(aims, variables)`` and ``(limits, variables)``."""
        # They are 0 where they are not known, so that a search moves along the other variables.
        trial, found = self.run([unit])[0], self.derivatives(unit)
        if trial.failed:  # aims and excess are constants there
            return np.zeros((len(self.aims), len(unit))), np.zeros((len(self.bounds), len(unit)))
        aims = [sign / self.scales[name] * found[name] for name, sign in self.aims]
        excess = [b.slope(trial.numbers[b.of], self._scale(b)) * found[b.of] for b in self.bounds]
        return np.nan_to_num(aims), np.nan_to_num(excess).reshape(-1, len(unit))

    def rank(self, trial: Trial) -> tuple[float, float]:
        """Order of trials: the largest excess beyond a limit first, then the size of the aims."""
        beyond = float(max(self.excess_of(trial).max(initial=0.0), 0.0))
        within = beyond <= WITHIN
        return (0.0 if within else beyond), (math.inf if trial.failed else self.size(trial))

    def size(self, trial: Trial) -> float:
        """Sum of the aims of a trial, or of their squares."""
        return float((self.aims_of(trial) ** (2 if self.squares else 1)).sum())

    @property
    def best(self) -> Trial | None:
        """The best trial so far: within all limits, with the least aims."""
        if "first" not in self.__dict__:
            return None
        return min(self.history, key=self.rank)

    @property
    def front(self) -> list[Trial]:
        """Trials within all limits of which no other is better in one aim and as good in all others (Pareto)."""
        within = [trial for trial in self.history if not trial.failed and self.rank(trial)[0] == 0]
        aims = np.array([self.aims_of(trial) for trial in within]).reshape(len(within), -1)
        better = [((aims <= here).all(axis=1) & (aims < here).any(axis=1)).any() for here in aims]
        return [trial for trial, beaten in zip(within, better) if not beaten]
