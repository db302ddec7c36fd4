"""A study as a problem of optimisation: variables from 0 to 1, and aims and limits that are about 1."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import MechanismError, SceneError
from fenics_mech.studies.design.result_numbers import Quantity
from fenics_mech.studies.design.sensitivity import sensitivity
from fenics_mech.studies.design.trial import Trial, Trials


@dataclass(frozen=True)
class ProblemLimits:
    """Numbers of the search itself."""

    failed: float = 10.0  # aim and excess of a limit where a trial failed, in units of those at the start
    step: float = 1e-3  # of differences for gradients, as a share of a variable's range
    within: float = 1e-6  # excess of a limit that counts as none, relative
    least: float = 1e-9  # of a limit, that a number counts as
    same: int = 14  # digits by which two points are one


PROBLEM = ProblemLimits()
Progress = Callable[[int, Trial, Trial | None], None]  # number of trials, the last one, and the best so far


@dataclass(frozen=True)
class Bound:
    """A limit as ``sign * (number - limit) / scale <= 0``, or the logarithm of their ratio where both are sizes.

    Strains fall with powers of the dimensions, and their logarithms are nearly linear.

    Parameters
    ----------
    of
        Name of the number.
    limit
        In SI.
    sign
        1 for the largest value, -1 for the least.
    """

    of: str
    limit: float
    sign: float

    def excess(self, number: float, scale: float) -> float:
        """By how much the number is beyond the limit, in units of the scale."""
        if self._of_sizes:
            return self.sign * math.log(max(number, PROBLEM.least * self.limit) / self.limit)
        return self.sign * (number - self.limit) / scale

    @property
    def _of_sizes(self) -> bool:
        return self.limit > 0 and self.of.endswith((".max", ".rms"))

    def slope(self, number: float, scale: float) -> float:
        """Derivative of the excess by the number."""
        return self.sign / (max(number, PROBLEM.least * self.limit) if self._of_sizes else scale)


@dataclass(frozen=True)
class Problem:
    """The aims and limits of a study over variables that go from 0 to 1.

    Parameters
    ----------
    trials
        Runs the trials.
    progress
        Called after each trial.
    """

    trials: Trials
    progress: Progress = lambda count, trial, best: None
    history: list[Trial] = field(default_factory=list)
    _known: dict[tuple[float, ...], Trial] = field(default_factory=dict)

    @cached_property
    def aims(self) -> tuple[tuple[str, float], ...]:
        """Names of the aims, with 1 for those that are minimised and -1 for those that are maximised."""
        study = self.trials.design.study
        return (*((name, 1.0) for name in study.minimise), *((name, -1.0) for name in study.maximise))

    @cached_property
    def bounds(self) -> tuple[Bound, ...]:
        """The limits of the study.

        Raises
        ------
        SceneError
            When a limit cannot be read, or the least is not below the most.
        """
        found: list[Bound] = []
        for limit in self.trials.design.study.limits:
            quantity = Quantity.read(limit.of)
            pair = {-1.0: limit.least, 1.0: limit.most}
            read = {sign: quantity.in_si(value) for sign, value in pair.items() if value is not None}
            if len(read) == 2 and read[-1.0] > read[1.0]:
                message = f"the least {limit.of} of {read[-1.0]:g} is more than the most of {read[1.0]:g} (SI)"
                raise SceneError(message, place="study.limits", hint="Exchange `least` and `most`")
            found += [Bound(limit.of, value, sign) for sign, value in read.items()]
        return tuple(found)

    @cached_property
    def first(self) -> Trial:
        """The trial of the start.

        Raises
        ------
        SceneError
            When it fails.
        """
        trial = self.run([self.to_unit(self.trials.design.start)])[0]
        if trial.failed:
            said = f"the scene that the study starts from fails: {trial.message}"
            raise SceneError(said, place="study", hint="Give another `start` to its variables")
        return trial

    @cached_property
    def scales(self) -> dict[str, float]:
        """Size of each number at the start; 1 where it is 0."""
        return {name: abs(value) or 1.0 for name, value in self.first.numbers.items()}

    @cached_property
    def _ranges(self) -> tuple[Array, Array]:
        lower, upper = np.array(self.trials.design.bounds).T
        return lower, np.where(upper > lower, upper - lower, 1.0)

    def to_unit(self, values: Sequence[float]) -> Array:
        """Give the variables from 0 to 1 of values in SI."""
        lower, span = self._ranges
        return (np.array(values, dtype=float) - lower) / span

    def values(self, unit: Array) -> tuple[float, ...]:
        """Give values in SI of variables from 0 to 1; a choice takes the nearest index."""
        lower, span = self._ranges
        found = lower + span * np.clip(unit, 0, 1)
        variables = self.trials.design.variables
        return tuple(float(round(v) if variable.choices else v) for v, variable in zip(found, variables))

    def run(self, units: Sequence[Array]) -> list[Trial]:
        """Run trials at variables from 0 to 1, or give those that were run before.

        Parameters
        ----------
        units
            The variables of each trial, ``(variables,)`` each.
        """
        points = [self.values(unit) for unit in units]
        keys = [_key(point) for point in points]
        new = [point for key, point in dict(zip(keys, points)).items() if key not in self._known]

        def known(trial: Trial) -> None:
            self.history.append(trial)
            self.progress(len(self.history), trial, self.best)

        for trial in self.trials.run(new, known):
            self._known[_key(trial.values)] = trial
        return [self._known[key] for key in keys]

    def aims_of(self, trial: Trial) -> Array:
        """Aims of a trial, all to be minimised, in units of those at the start, ``(aims,)``."""
        if trial.failed:
            return np.full(len(self.aims), PROBLEM.failed)
        return np.array([sign * trial.numbers[name] / self.scales[name] for name, sign in self.aims])

    def excess_of(self, trial: Trial) -> Array:
        """By how much a trial is beyond each limit, relative; negative within it, ``(limits,)``."""
        if trial.failed:
            return np.full(len(self.bounds), PROBLEM.failed)
        return np.array([b.excess(trial.numbers[b.of], self._scale(b)) for b in self.bounds])

    def _scale(self, bound: Bound) -> float:
        """Size in whose units the excess of a limit is."""
        return abs(bound.limit) or self.scales[bound.of]

    def jacobian(self, unit: Array) -> tuple[Array, Array]:
        """Derivatives of aims and excess by the variables, ``(aims, variables)`` and ``(limits, variables)``.

        They come from `sensitivity` where it knows the problem. Else they are central differences, one-sided at a bound
        or beside a trial that failed.

        Parameters
        ----------
        unit
            The variables, ``(variables,)``.
        """
        return self._by_sensitivity(unit) or self._by_differences(unit)

    def _by_sensitivity(self, unit: Array) -> tuple[Array, Array] | None:
        """Derivatives from the linearised equation; None where it does not give them."""
        trial = self.run([unit])[0]
        if trial.failed or not self.trials.linearised:
            return None
        try:
            found = sensitivity(self.trials, trial.values)
        except MechanismError:  # a neighbour that fails; differences are one-sided there
            return None
        if found is None:
            return None
        span = self._ranges[1]
        aims = [sign / self.scales[name] * found[name] * span for name, sign in self.aims]
        excess = [b.slope(trial.numbers[b.of], self._scale(b)) * found[b.of] * span for b in self.bounds]
        return np.array(aims), np.array(excess).reshape(-1, len(unit))

    def _by_differences(self, unit: Array) -> tuple[Array, Array]:
        """Derivatives by central differences of trials."""
        here, count = np.clip(unit, 0, 1), len(unit)
        ends = np.array([[here + sign * PROBLEM.step * row for sign in (-1, 1)] for row in np.eye(count)])
        ends = np.clip(ends, 0, 1)
        found = self.run([here, *ends.reshape(-1, count)])
        rows = []
        for k in range(count):
            pair = [
                (point[k], trial) for point, trial in zip(ends[k], found[1 + 2 * k : 3 + 2 * k]) if not trial.failed
            ]
            pair = pair if len(pair) == 2 else [*pair, (here[k], found[0])]
            (a, low), (b, high) = pair if len(pair) == 2 else (pair[0], pair[0])
            step = b - a or 1.0
            rows.append([(part(high) - part(low)) / step for part in (self.aims_of, self.excess_of)])
        return np.array([row[0] for row in rows]).T, np.array([row[1] for row in rows]).T.reshape(-1, count)

    def rank(self, trial: Trial) -> tuple[float, float]:
        """Order of trials: the largest excess beyond a limit first, then the sum of the aims."""
        beyond = float(max(self.excess_of(trial).max(initial=0.0), 0.0))
        within = beyond <= PROBLEM.within
        return (0.0 if within else beyond), (math.inf if trial.failed else float(self.aims_of(trial).sum()))

    @property
    def best(self) -> Trial | None:
        """The best trial so far: within all limits, with the least sum of aims."""
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


def _key(values: Sequence[float]) -> tuple[float, ...]:
    """Give what points have in common that are one."""
    return tuple(float(f"{value:.{PROBLEM.same}g}") for value in values)
