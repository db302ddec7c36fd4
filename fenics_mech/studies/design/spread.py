"""How numbers of a result scatter with numbers of the scene: samples, a linear estimate, and shares of the variance."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import count
from pathlib import Path

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._files import write_table
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene
from fenics_mech.studies.design.chaos import Chaos, polynomial_chaos
from fenics_mech.studies.design.explorer import Explorer
from fenics_mech.studies.design.fit import Truths
from fenics_mech.studies.design.problem import Bound, bounds_of
from fenics_mech.studies.design.result_numbers import Curve, Quantity, read_all
from fenics_mech.studies.design.scatter import Scattered, drawn
from fenics_mech.studies.design.sobol_indices import SobolIndices, saltelli_points, sobol_indices
from fenics_mech.studies.design.trial import Trial, Trials, kept_folder
from fenics_mech.studies.lead_process import led
from fenics_mech.studies.worker_processes import Workers

MOST_ANGLES = 180  # of a curve
QUANTILES = (0.05, 0.5, 0.95)
MOST_LEFT = 0.05  # of the variance, from which polynomials do not tell a number
MOST_TRIALS = 1_000_000
TINY = np.finfo(float).tiny


@dataclass(frozen=True)
class Spread:
    """How numbers of a result scatter.

    Parameters
    ----------
    scattered
        What scatters.
    explorer
        The trial at the means in `first`, and the derivatives there.
    samples
        Trials of the samples, in groups of `width`.
    width
        1, or the number of variables plus 2 where `sobol_indices` has its points.
    seconds
        How long all took.

    Examples
    --------
    >>> strip = {"numbers": ["sections.strip.area"], "tolerance": "5 %"}
    >>> study = {"scatter": {"strip": strip}, "results": ["mass[coupler]"]}
    >>> scene = fm.load("demos/four_bar.toml").changed(study=study)
    >>> found = fm.spread(scene, samples=64)
    >>> float(found.data["result"].std() / found.data["result"].mean()).__round__(3)
    0.029
    """

    scattered: Scattered
    explorer: Explorer
    samples: tuple[Trial, ...]
    width: int
    seconds: float

    @property
    def names(self) -> list[str]:
        """Names of the numbers that are looked at, without those of curves."""
        return [one.text for one in self.explorer.trials.quantities if not isinstance(one, Curve)]

    @property
    def curves(self) -> list[Curve]:
        """The curves that are looked at."""
        return [one for one in self.explorer.trials.quantities if isinstance(one, Curve)]

    @cached_property
    def independent(self) -> list[Trial]:
        """The samples that are independent of one another."""
        return [trial for k, trial in enumerate(self.samples) if k % self.width < 2]

    @cached_property
    def data(self) -> xr.Dataset:
        """Values, numbers and curves of the independent samples in SI; NaN where a trial failed."""
        variables, trials = self.scattered.design.variables, self.independent
        found = xr.Dataset(coords={"variable": [one.name for one in variables], "name": self.names})
        found["value"] = ("sample", "variable"), np.array([one.values for one in trials]).reshape(-1, len(variables))
        numbers = np.array([[one.numbers[name] for name in self.names] for one in trials])
        found["result"] = ("sample", "name"), numbers.reshape(-1, len(self.names))
        if self.curves and trials:
            found["curve"] = (
                ("sample", "of", "theta"),
                np.array([[curve.values(one.numbers) for curve in self.curves] for one in trials]),
            )
            found = found.assign_coords(of=[one.text for one in self.curves], theta=list(self.curves[0].angles))
        return found

    @cached_property
    def contributions(self) -> dict[str, Array]:
        """Linear estimate: derivatives at the means times the variables' deviations, by number, ``(variables,)``."""
        lower, upper = np.array(self.scattered.design.bounds).T
        shares = self.scattered.deviations / (upper - lower)
        middle = self.explorer.to_unit(self.scattered.design.start)
        return {name: slopes * shares for name, slopes in self.explorer.derivatives(middle).items()}

    def linear_shares(self, name: str) -> Array:
        """Give the shares of a number's variance by the linear estimate, ``(variables,)``."""
        square = self.contributions[name] ** 2
        return np.asarray(square / np.maximum(square.sum(), TINY))

    @cached_property
    def indices(self) -> dict[str, SobolIndices]:
        """Sobol indices of each number; empty where there are no points for them."""
        if self.width == 1 or not self.samples:
            return {}
        table = {name: np.array([trial.numbers[name] for trial in self.samples]) for name in self.names}
        return {name: sobol_indices(values.reshape(-1, self.width)) for name, values in table.items()}

    @cached_property
    def chaos(self) -> dict[str, Chaos]:
        """Each number as a polynomial of what scatters, where samples are enough; see `polynomial_chaos`."""
        lower, upper = np.array(self.scattered.design.bounds).T
        good = [trial for trial in self.independent if not trial.failed]
        places = (np.array([trial.values for trial in good]).reshape(-1, len(lower)) - lower) / (upper - lower)
        found = {
            name: polynomial_chaos(places, np.array([trial.numbers[name] for trial in good]), self.scattered.normal)
            for name in (self.names if len(good) > 1 else ())
        }
        return {name: one for name, one in found.items() if one is not None}

    def told_by_polynomials(self, name: str) -> Chaos | None:
        """Give the polynomials of a number, where they leave little of its variance."""
        chaos = self.chaos.get(name)
        return chaos if chaos is not None and chaos.left < MOST_LEFT else None

    @cached_property
    def passed(self) -> dict[Bound, Truths]:
        """Whether each independent sample keeps each limit, ``(samples,)``; failed ones keep none."""
        found = {}
        for bound in bounds_of(self.scattered.design.study):
            numbers = np.array([trial.numbers[bound.of] for trial in self.independent])
            with np.errstate(invalid="ignore"):
                found[bound] = bound.sign * (numbers - bound.limit) <= 0
        return found

    def kept(self) -> tuple[float, float, float]:
        """Share of the samples that keep all limits (yield), and the ends of its 95 % interval by Wilson.

        They are NaN where there are no samples.
        """
        from scipy.stats import binomtest  # noqa: PLC0415  (slow to import)

        if not self.samples:
            return np.nan, np.nan, np.nan
        good = np.logical_and.reduce([*self.passed.values(), np.ones(len(self.independent), dtype=bool)])
        interval = binomtest(int(good.sum()), len(good)).proportion_ci(0.95, method="wilson")
        return float(good.mean()), float(interval.low), float(interval.high)


@led
def spread(
    scene: Scene,
    folder: str | Path | None = None,
    *,
    samples: int = 128,
    sampling: str = "sobol",
    indices: bool = False,
    seed: int = 0,
    jobs: int = 1,
    progress: Callable[[int], None] = lambda count: None,
) -> Spread:
    """Find how the numbers of a scene's study scatter with what `study.scatter` states.

    Parameters
    ----------
    scene
        The scene, with its study.
    folder
        Where finished trials are kept, with ``spread.csv``, ``samples.csv``, ``polynomials.csv`` and ``indices.csv``.
    samples
        How many; 0 for the linear estimate alone.
    sampling
        "sobol" or "latin-hypercube".
    indices
        Find Sobol indices too: the samples times the number of variables plus 2 are analysed.
    seed
        Of random numbers.
    jobs
        Processes of this machine that share trials. Those of `mpirun` share them too: all call this and get the same.
    progress
        Called with the number of samples that are begun.

    Raises
    ------
    SceneError
        When the study is not valid, or the scene fails at the means.
    MechanismError
        When no file can be written.

    Examples
    --------
    >>> strip = {"numbers": ["sections.strip.area"], "tolerance": "5 %"}
    >>> study = {"scatter": {"strip": strip}, "results": ["mass[coupler]"]}
    >>> scene = fm.load("demos/four_bar.toml").changed(study=study)
    >>> low, high = fm.spread(scene, samples=64).data["result"].quantile([0, 1], "sample")[:, 0]
    >>> round(float(high / low), 2)
    1.1
    """
    begun, scattered = time.perf_counter(), Scattered.of(scene)
    with kept_folder(folder) as kept, Workers(jobs) as workers:
        points = _points(scattered, (samples, sampling, seed), indices)
        trials = _trials(scattered, kept / "trials", workers)
        explorer = Explorer(trials)
        explorer.first  # noqa: B018  (it says what is wrong at the means)
        explorer.derivatives(explorer.to_unit(scattered.design.start))  # they are kept
        numbers = count(1)
        run = trials.run(points.reshape(-1, points.shape[-1]).tolist(), counted=lambda: progress(next(numbers)))
        found = Spread(scattered, explorer, tuple(run), points.shape[1], time.perf_counter() - begun)
        if folder is not None:
            _write(found, kept)
    return found


def _trials(scattered: Scattered, folder: Path, workers: Workers) -> Trials:
    """Prepare the trials, with the numbers and curves of the study."""
    design, study = scattered.design, scattered.design.study
    bounds_of(study)  # which says what is wrong with a limit
    count = min(MOST_ANGLES, design.scene.analysis.sub_intervals)
    angles = 2 * np.pi * np.arange(count) / count
    looked_at: list[Quantity] = [*read_all(study.names)]
    looked_at += [Curve.at(name, angles) for name in dict.fromkeys(study.curves)]
    if not looked_at:
        hint = 'Write results = ["strain.max"], curves = ["torque"] or limits'
        raise SceneError("the study looks at no number", place="study", hint=hint)
    return Trials(design, tuple(looked_at), folder, workers).with_fixed_effects()


def _points(scattered: Scattered, how: tuple[int, str, int], indices: bool) -> Array:
    """Give the points in SI, ``(samples, width, variables)``."""
    (count, sampling, seed), variables = how, len(scattered.design.variables)
    width = variables + 2 if indices else 1
    if count * width > MOST_TRIALS:
        raise SceneError(f"{count * width} trials, and at most {MOST_TRIALS} are run", place="spread")
    if not count:
        return np.zeros((0, width, variables))
    if not indices:
        return scattered.values(drawn(sampling, count, variables, seed))[:, None]
    return scattered.values(saltelli_points(drawn(sampling, count, 2 * variables, seed)))


def _write(found: Spread, folder: Path) -> None:
    """Write the statistics, the samples and the indices."""
    design = found.scattered.design
    rows = [[name, *statistics(found, name)] for name in found.names]
    write_table(folder / "spread.csv", [["number", *STATISTICS], *rows])
    samples = [[*one.values, *(one.numbers[name] for name in found.names), one.error] for one in found.independent]
    write_table(folder / "samples.csv", [[*(one.name for one in design.variables), *found.names, "error"], *samples])
    if found.chaos:
        rows = [
            [name, variable.name, one.first[k], one.total[k], one.degree, one.left]
            for name, one in found.chaos.items()
            for k, variable in enumerate(design.variables)
        ]
        write_table(folder / "polynomials.csv", [["number", "variable", "first", "total", "degree", "left"], *rows])
    if found.indices:
        shares = [
            [name, variable.name, one.first[k], one.doubt[0, k], one.total[k], one.doubt[1, k]]
            for name, one in found.indices.items()
            for k, variable in enumerate(design.variables)
        ]
        write_table(folder / "indices.csv", [["number", "variable", "first", "doubt", "total", "doubt"], *shares])


STATISTICS = ("nominal", "mean", "deviation", "linear deviation", *(f"{100 * share:g} %" for share in QUANTILES))


def statistics(found: Spread, name: str) -> list[float]:
    """Give the `STATISTICS` of a number; those of samples are NaN where there are none."""
    values = np.array([trial.numbers[name] for trial in found.independent if not trial.failed])
    linear = float(np.linalg.norm(found.contributions[name]))
    enough = len(values) > 1
    moments = [float(values.mean()), float(values.std(ddof=1))] if enough else [np.nan, np.nan]
    quantiles = np.quantile(values, QUANTILES).tolist() if enough else [np.nan] * len(QUANTILES)
    return [found.explorer.first.numbers[name], *moments, linear, *quantiles]
