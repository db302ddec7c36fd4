"""Numbers of a scene from measured data: least squares, with their confidence and what the data do not tell."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._files import write_table
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene
from fenics_mech.scene.load_cases import refuse_cases
from fenics_mech.scene.rewriting import write_like
from fenics_mech.scene.writing import write_scene
from fenics_mech.studies.design.design_variables import Design
from fenics_mech.studies.design.explorer import Explorer
from fenics_mech.studies.design.fit import PART, Fit, Noisy, Truths, fit
from fenics_mech.studies.design.measured_values import Observation, read_observations, stated_observations
from fenics_mech.studies.design.trial import Trial, Trials, kept_folder
from fenics_mech.studies.lead_process import led
from fenics_mech.studies.sweep_axes import value_in_si
from fenics_mech.studies.worker_processes import Workers

FAILED = 1e3  # of the size of the measured values: what a trial that failed predicts


@dataclass(frozen=True)
class Identified:
    """What measured data tell of the variables of a study.

    Parameters
    ----------
    stated
        The scene.
    explorers
        The trials, with all of them in `history`: one for each of what the data were measured at.
    observations
        What was measured.
    fit
        What least squares found, for variables from 0 to 1.
    seconds
        How long all took.

    Examples
    --------
    >>> modulus = {"numbers": ["materials.aluminium.modulus"], "between": ["50 GPa", "90 GPa"]}
    >>> scene = fm.load("demos/four_bar.toml").changed(study={"variables": {"modulus": modulus}}, effects=())
    >>> scene = scene.changed({"analysis.solver": "collocation", "analysis.sub_intervals": 36})
    >>> found = fm.identify(scene, [fm.Observation.number("frequency[1].mean", 45.0, 0.2)])
    >>> found.names
    ['modulus']
    """

    stated: Scene
    explorers: tuple[Explorer, ...]
    observations: tuple[Observation, ...]
    fit: Fit
    seconds: float

    @property
    def explorer(self) -> Explorer:
        """The trials of the first of the data."""
        return self.explorers[0]

    @property
    def history(self) -> list[Trial]:
        """All trials."""
        return [trial for explorer in self.explorers for trial in explorer.history]

    @property
    def names(self) -> list[str]:
        """Names of the variables."""
        return [variable.name for variable in self.explorer.trials.design.variables]

    @cached_property
    def values(self) -> Array:
        """Values of the variables in SI, ``(variables,)``."""
        return np.array(self.explorer.values(self.fit.at))

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the variables in SI, ``(variables, variables)``; NaN for those that the data do not tell."""
        span, told = self._span, self.fit.told
        return np.where(told[:, None] & told, self.fit.covariance * span[:, None] * span, np.nan)

    @property
    def deviation(self) -> Array:
        """Standard deviations of the variables in SI, ``(variables,)``."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def interval(self) -> Array:
        """Ends of the intervals that hold the true values in 95 of 100 cases, in SI, ``(variables, 2)``."""
        half = self.fit.reach * self.deviation
        return np.stack([self.values - half, self.values + half], axis=1)

    @property
    def at_bound(self) -> Truths:
        """Which variables ended at a bound, where their intervals do not hold, ``(variables,)``."""
        return (self.fit.at < 1e-6) | (self.fit.at > 1 - 1e-6)

    @property
    def untold(self) -> list[dict[str, float]]:
        """Combinations of variables that the data do not tell: a change in shares of their ranges."""
        found = []
        for direction in self.fit.untold.T:
            parts = dict(zip(self.names, direction.tolist()))
            found.append({name: part for name, part in parts.items() if abs(part) >= PART})
        return found

    @property
    def scene(self) -> Scene:
        """The scene with the values that were found, and its study."""
        design = self.explorer.trials.design
        return self.stated.changed(design.changes(self.values.tolist()) | {"study": design.study})

    @property
    def parts(self) -> list[slice]:
        """Where the values of each observation stand among all, in order."""
        ends = np.cumsum([0, *(len(one.values) for one in self.observations)])
        return [slice(a, b) for a, b in pairwise(ends)]

    @property
    def first(self) -> Array:
        """Predicted values at the start, ``(points,)``."""
        groups = _groups(self.observations).values()
        return np.concatenate([_predicted(group, one.first.numbers) for group, one in zip(groups, self.explorers)])

    def follows(self, part: slice) -> float:
        """Correlation of each difference with the next: of noise alone it is about 0.

        Parameters
        ----------
        part
            The values of one observation.
        """
        rest = self.fit.weighted[part]
        size = max(float(rest @ rest), float(np.finfo(float).tiny))
        return float(rest[1:] @ rest[:-1]) / size if len(rest) > 2 else 0.0

    @property
    def _span(self) -> Array:
        lower, upper = np.array(self.explorer.trials.design.bounds).T
        return upper - lower


@led
def identify(
    scene: Scene,
    data: Sequence[str | Path | Observation] = (),
    folder: str | Path | None = None,
    *,
    starts: int = 1,
    seed: int = 0,
    jobs: int = 1,
    like: str | Path | None = None,
    progress: Callable[[int, Trial, Trial | None], None] = lambda count, trial, best: None,
) -> Identified:
    """Find the variables of a scene's study for which it predicts what was measured.

    The sum of the squares of all differences is minimised, each in units of its noise. The noise of each curve is
    estimated from its differences. Confidence is that of the linearised problem, for noise that is independent from
    point to point.

    Parameters
    ----------
    scene
        The scene. Of its study only the variables count.
    data
        CSV files or `Observation` objects; by default the measurements that the scene states.
    folder
        Where finished trials are kept, with ``identified.csv`` and ``identified.toml``.
    starts
        Number of searches: the first from the study's start, the others from seeded random ones. The best one counts.
    seed
        Of these starts.
    jobs
        Processes of this machine that share trials. Those of `mpirun` share them too: all call this and get the same.
    like
        The file of the scene, whose units ``identified.toml`` keeps, and its comments if it states all values.
        Without it, that has numbers in SI.
    progress
        Called with the number of trials and the last one after each.

    Raises
    ------
    SceneError
        When the study or the data are not valid, there are fewer data than variables, or the start fails.
    MechanismError
        When no file can be written.

    Examples
    --------
    >>> modulus = {"numbers": ["materials.aluminium.modulus"], "between": ["50 GPa", "90 GPa"]}
    >>> scene = fm.load("demos/four_bar.toml").changed(study={"variables": {"modulus": modulus}}, effects=())
    >>> scene = scene.changed({"analysis.solver": "collocation", "analysis.sub_intervals": 36})
    >>> found = fm.identify(scene, [fm.Observation.number("frequency[1].mean", 45.0, 0.2)])
    >>> f"{found.values[0] / 1e9:.1f} GPa, deviation {found.deviation[0] / 1e9:.1f} GPa"
    '66.4 GPa, deviation 0.6 GPa'
    """
    refuse_cases(scene, "what was measured")
    begun, observations = time.perf_counter(), _observations(scene, data)
    with kept_folder(folder) as kept, Workers(jobs) as workers:
        explorers: list[Explorer] = []

        def told(count: int, trial: Trial, best: Trial | None) -> None:
            progress(sum(len(one.history) for one in explorers) or count, trial, best)

        count = len(Design.of(scene).variables)
        measured = _noisy(observations, count)  # which says where they are too few
        for at, group in _groups(observations).items():
            explorers.append(replace(_explorer(scene, at, kept / "trials", workers, group), progress=told))
            explorers[-1].first  # noqa: B018  (it says what is wrong at the start)
        first = explorers[0]
        points = np.random.default_rng(seed).random((starts, count))
        points[0] = first.to_unit(first.trials.design.start)
        fits = [_fitted(explorers, observations, measured, point) for point in points]
        # minus the logarithm of the likelihood, but for a constant
        misfits = [np.log(one.noise)[one.data.group].sum() + (one.weighted**2).sum() / 2 for one in fits]
        best, seconds = fits[int(np.argmin(misfits))], time.perf_counter() - begun
        found = Identified(scene, tuple(explorers), observations, best, seconds)
        if folder is not None:
            _write(found, kept, like)
    return found


def _observations(scene: Scene, data: Sequence[str | Path | Observation]) -> tuple[Observation, ...]:
    """Read the files of measured data, or those that the scene states; in groups by what they were measured at."""
    found, read = ([] if data else stated_observations(scene)), set[Path]()
    for one in data:
        if isinstance(one, Observation):
            found.append(one)
            continue
        if (file := Path(one).absolute()) in read:
            raise SceneError("this file is named twice", place=str(one), hint="Name each file of data once")
        read.add(file)
        found += read_observations(Path(one))
    return tuple(one for group in _groups(found).values() for one in group)


At = tuple[tuple[str, float], ...]  # numbers of the scene that data were measured at, by dotted path


def _groups(observations: Sequence[Observation]) -> dict[At, list[Observation]]:
    """Give the observations by what they were measured at."""
    found: dict[At, list[Observation]] = {}
    for one in observations:
        found.setdefault(tuple(sorted(one.at.items())), []).append(one)
    return found


def _explorer(scene: Scene, at: At, kept: Path, workers: Workers, of: Sequence[Observation]) -> Explorer:
    """Prepare the trials of data that were measured at the same numbers of the scene."""
    variables = {} if scene.study is None else scene.study.variables
    varied = {one if isinstance(one, str) else one.number for part in variables.values() for one in part.numbers}
    if both := [path for path, _ in at if path in varied]:
        message = f"the data were measured at a known {both[0]}, which is a variable too"
        raise SceneError(message, place="identify", hint="Leave it out of the variables, or out of the data")
    for path, value in at:
        value_in_si(scene, path, value)  # it says what is wrong
    design = Design.of(scene.changed(dict(at)) if at else scene)
    if chosen := [variable.name for variable in design.variables if variable.choices]:
        raise SceneError("least squares take no choices", place=f"study.variables.{chosen[0]}", hint="Give `between`")
    return Explorer(Trials(design, tuple(one.of for one in of), kept, workers).with_fixed_effects())


def _noisy(observations: Sequence[Observation], variables: int) -> Noisy:
    """Give all measured values as one, those of each curve as a group."""
    values = np.concatenate([one.values for one in observations])
    known = np.array([one.deviation for one in observations])
    if np.isnan(known).any() and len(values) <= variables:
        message = f"{len(values)} measured values are too few for {variables} variables"
        raise SceneError(message, place="identify", hint="Measure more, or leave variables out")
    group = np.repeat(np.arange(len(observations)), [len(one.values) for one in observations])
    return Noisy(values, group, known)


def _predicted(observations: Sequence[Observation], numbers: dict[str, float]) -> Array:
    """Numbers of a trial in the order of the measured values, ``(points,)``."""
    return np.array([numbers[name] for one in observations for name in one.of.names])


def _fitted(explorers: Sequence[Explorer], observations: Sequence[Observation], measured: Noisy, start: Array) -> Fit:
    """Fit the variables from one start."""
    far, groups = FAILED * np.abs(measured.values).max(), list(_groups(observations).values())

    def predict(unit: Array) -> Array:
        if not np.isfinite(unit).all():
            found = "the search finds no next trial: the numbers of the data are out of all range"
            raise SceneError(found, place="identify", hint="Give them in SI")
        trials = [explorer.run([unit])[0] for explorer in explorers]
        if any(trial.failed for trial in trials):
            return np.full(len(measured.values), far)
        return np.concatenate([_predicted(group, trial.numbers) for group, trial in zip(groups, trials)])

    def slopes(unit: Array) -> Array:
        found = [explorer.derivatives(unit) for explorer in explorers]
        rows = [one[name] for group, one in zip(groups, found) for part in group for name in part.of.names]
        if not np.any(rows):  # of what is not known nothing is told
            names = ", ".join(variable.name for variable in explorers[0].trials.design.variables)
            message = f"no variable moves the data: none of their numbers changes with {names}"
            raise SceneError(message, place="identify", hint="Measure what the variables change")
        return np.nan_to_num(rows)

    return fit(predict, slopes, measured, start, 1e-8)


def _write(found: Identified, folder: Path, like: str | Path | None) -> None:
    """Write the variables with their confidence, and the scene with them."""
    variables = found.explorer.trials.design.variables
    of_each = zip(variables, found.values, found.deviation, found.interval, found.fit.told)
    rows = [
        [variable.name, variable.unit, value, deviation, low, high, "yes" if told else "no"]
        for variable, value, deviation, (low, high), told in of_each
    ]
    head = ["variable", "unit", "value", "deviation", "low", "high", "told"]
    write_table(folder / "identified.csv", [head, *rows])
    written, values = folder / "identified.toml", found.explorer.trials.design.changes(found.values.tolist())
    write_scene(found.scene, written) if like is None else write_like(like, values, found.scene, written)
