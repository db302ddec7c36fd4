"""Trials of a study at variables that go from 0 to 1: each is run once, and derivatives of its numbers are known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import DerivativeError, MechanismError, SceneError
from fenics_mech.studies.design.slopes import slopes
from fenics_mech.studies.design.trial import Trial, Trials

STEP = 1e-3  # of differences for derivatives, as a share of a variable's range
SAME = 14  # digits by which two points are one


def _silent(count: int, trial: Trial, best: Trial | None) -> None:
    """Tell nobody."""


Progress = Callable[[int, Trial, Trial | None], None]  # number of trials, the last one, and the best so far


@dataclass(frozen=True)
class Explorer:
    """Trials over variables from 0 to 1."""

    trials: Trials  # runs the trials
    progress: Progress = _silent  # called after each trial
    history: list[Trial] = field(default_factory=list)  # all trials, in order
    _known: dict[tuple[float, ...], Trial] = field(default_factory=dict)
    _slopes: dict[tuple[float, ...], dict[str, Array]] = field(default_factory=dict)  # at the last point
    _without: list[str] = field(default_factory=list)  # why trials had no derivatives of their own

    def __getstate__(self) -> dict[str, Any]:
        """Give what other processes get: its trials, and nobody who is told of them."""
        return self.__dict__ | {"progress": _silent}

    @property
    def best(self) -> Trial | None:
        """The best trial so far, where there is an order of trials."""
        return None

    @cached_property
    def first(self) -> Trial:
        """The trial of the start."""
        trial = self.run([self.to_unit(self.trials.design.start)])[0]
        if trial.failed:
            said = f"the scene that the study starts from fails: {trial.message}"
            raise SceneError(said, place="study", hint="Give another `start` to its variables")
        return trial

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
        """Run trials at variables from 0 to 1, or give those that were run before."""
        points = [self.values(unit) for unit in units]
        keys = [_key(point) for point in points]
        new = [point for key, point in dict(zip(keys, points)).items() if key not in self._known]

        def known(trial: Trial) -> None:
            self.history.append(trial)
            self.progress(len(self.history), trial, self.best)

        for trial in self.trials.run(new, known):
            self._known[_key(trial.values)] = trial
        return [self._known[key] for key in keys]

    @property
    def why_differences(self) -> str:
        """Why derivatives were differences of trials; empty where none were, or where they came from `slopes`."""
        if not self._slopes:
            return ""
        return self.trials.why_differences or next(iter(self._without), "")

    def derivatives(self, unit: Array) -> dict[str, Array]:
        """Derivatives of all numbers by the variables, by name, ``(variables,)`` each."""
        # They come from `slopes` where it knows the problem. Else they are central differences, one-sided at a bound
        # or beside a trial that failed, and NaN where the trials on both sides failed.
        if (key := _key(unit)) not in self._slopes:
            found = self._by_linearised(unit) or self._by_differences(unit)
            self._slopes.clear()
            self._slopes[key] = found
        return self._slopes[key]

    def _by_linearised(self, unit: Array) -> dict[str, Array]:
        """Derivatives from the linearised equation; none where it does not give them."""
        trial = self.run([unit])[0]
        if trial.failed or self.trials.why_differences:
            return {}
        try:
            found = slopes(self.trials, trial.values)
        except DerivativeError as error:
            self._without.append(str(error))
            return {}
        except MechanismError:  # a neighbour that fails; differences are one-sided there
            return {}
        return {name: slopes * self._ranges[1] for name, slopes in found.items()}

    def _by_differences(self, unit: Array) -> dict[str, Array]:
        """Derivatives by central differences of trials; NaN where both neighbours failed."""
        here, count = np.clip(unit, 0, 1), len(unit)
        ends = np.array([[here + sign * STEP * row for sign in (-1, 1)] for row in np.eye(count)])
        ends = np.clip(ends, 0, 1)
        found = self.run([here, *ends.reshape(-1, count)])
        slopes = {name: np.full(count, np.nan) for name in found[0].numbers}
        for k in range(count):
            pair = [(ends[k, i, k], found[1 + 2 * k + i]) for i in range(2)]
            good = [one for one in pair if not one[1].failed]
            good = good if len(good) == 2 else [*good, (here[k], found[0])]
            (a, low), (b, high) = good[0], good[-1]
            for name in slopes if a != b and not (low.failed or high.failed) else ():
                slopes[name][k] = (high.numbers[name] - low.numbers[name]) / (b - a)
        return slopes


def _key(values: Sequence[float] | Array) -> tuple[float, ...]:
    """Give what points have in common that are one."""
    return tuple(float(f"{value:.{SAME}g}") for value in values)
