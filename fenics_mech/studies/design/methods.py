"""Methods of optimisation: those of SciPy for one aim, and NSGA-II of pymoo for several."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.studies.design.problem import WITHIN, Problem
from fenics_mech.studies.design.trial import Trial


@dataclass(frozen=True)
class Search:
    """How far a search goes.

    Parameters
    ----------
    generations
        Steps of a method with gradients, or generations of a population.
    population
        Members of a population.
    seed
        Of random numbers.
    tolerance
        Change of aim or variables, relative, at which a search ends.

    Examples
    --------
    >>> fm.Search(generations=10).population
    20
    """

    generations: int = 50
    population: int = 20
    seed: int = 0
    tolerance: float = 1e-6


@dataclass(frozen=True)
class Ending:
    """How a search ended."""

    message: str  # what the method said
    converged: bool  # whether it ended by itself, and not at its limit of steps or where it was lost


Method = Callable[[Problem, Array, Search], Ending]
SHRINK, LEAST_BOX = 0.2, 1e-3  # of move limits: their factor where a search is lost, and the least, as shares of ranges
LAST, SETTLED = 0.2, 0.01  # share of generations, in which a trade-off that is found grows by less than the other
PATIENCE = 8, 2  # trials in a row without progress, and for each variable, after which a search is lost


class _LostError(Exception):
    """A search goes on without a better trial."""


def by_gradients(name: str) -> Method:
    """Give a method of SciPy's `minimize` that takes gradients and limits: "SLSQP" or "trust-constr"."""
    # Largest values have kinks, where a method may jump to where the limits cannot be kept. It begins again from the
    # best trial then, with smaller move limits about it.
    # Source: Haftka and Gürdal, Elements of Structural Optimization, 3rd edition, 1992, section 6.1 (move limits).

    def search(problem: Problem, start: Array, limits: Search) -> Ending:
        box, left, middle = 1.0, limits.generations, start
        problem.run([start])
        while left > 0 and box > LEAST_BOX:
            guided, shrink = _Guided(problem, problem.best), SHRINK
            try:
                ending, at = guided.search(name, (middle, box), replace(limits, generations=left))
                inside = np.abs(at - middle).max() < box * (1 - WITHIN)
                if guided.steps >= left or (ending.converged and (inside or box == 1.0)):
                    return ending
                shrink = 1.0 if ending.converged else SHRINK  # it goes on beyond its move limits
            except _LostError:
                pass
            left -= max(guided.steps, 1)
            assert problem.best is not None
            middle, box = problem.to_unit(problem.best.values), shrink * box
        said = "no better trial within the least move limits" if left > 0 else f"{limits.generations} steps"
        return Ending(said, left > 0)

    return search


@dataclass
class _Guided:
    """A search of SciPy that is watched."""

    problem: Problem
    best: Trial | None  # the best trial as it was last
    # idle, steps: trials without progress, and steps of the method
    idle: int = 0
    steps: int = 0
    beyond: float = math.inf  # the least excess beyond a limit since the best was found; half of it is progress too

    def trial(self, unit: Array) -> Trial:
        """Run a trial, or raise `_LostError` where there were many without progress."""
        count = len(self.problem.history)
        found = self.problem.run([unit])[0]
        if len(self.problem.history) > count:
            self._judge(self.problem.rank(found)[0])
        if self.idle > PATIENCE[0] + PATIENCE[1] * len(unit):
            raise _LostError
        return found

    def _judge(self, beyond: float) -> None:
        """Count a trial that is neither the best, nor nearer by half to the limits."""
        self.idle += 1
        if self.problem.best is not self.best:
            self.best, self.beyond, self.idle = self.problem.best, math.inf, 0
        elif 0 < beyond < self.beyond / 2:
            self.beyond, self.idle = beyond, 0

    def search(self, name: str, place: tuple[Array, float], limits: Search) -> tuple[Ending, Array]:
        """Search within move limits, given by their middle and half their width; give where it ended too."""
        from scipy.optimize import NonlinearConstraint, minimize  # noqa: PLC0415  (slow to import)

        (middle, box), problem = place, self.problem
        within = NonlinearConstraint(
            lambda unit: problem.excess_of(self.trial(unit)), -np.inf, 0.0, jac=lambda unit: problem.jacobian(unit)[1]
        )

        def count(*_: object) -> None:
            self.steps += 1

        # with its own barrier of 0.1 SciPy may end the search some hundredths of the aim before its limits
        barrier = dict.fromkeys(("initial_barrier_parameter", "initial_barrier_tolerance"), limits.tolerance)
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "delta_grad == 0.0", UserWarning)  # of an aim that is linear
            found = minimize(
                lambda unit: float(problem.aims_of(self.trial(unit))[0]),
                middle,
                jac=lambda unit: problem.jacobian(unit)[0][0],
                bounds=list(zip(np.clip(middle - box, 0, 1), np.clip(middle + box, 0, 1))),
                constraints=[within] if problem.bounds else [],
                method=name,
                tol=limits.tolerance,
                options={"maxiter": limits.generations} | (barrier if name == "trust-constr" else {}),
                callback=count,
            )
        assert problem.best is not None
        there = problem.rank(problem.run([found.x])[0]) <= problem.rank(problem.best)
        converged = bool(found.success) and there and self.steps < limits.generations
        return Ending(str(found.message), converged), found.x


def least_squares(problem: Problem, start: Array, limits: Search) -> Ending:
    """Minimise the sum of the squares of all aims."""
    from scipy.optimize import least_squares as solve  # noqa: PLC0415

    found = solve(
        lambda unit: problem.aims_of(problem.run([unit])[0]),
        np.clip(start, 1e-9, 1 - 1e-9),  # its start is inside of the bounds
        jac=lambda unit: problem.jacobian(unit)[0],
        bounds=(0, 1),
        xtol=limits.tolerance,
        ftol=limits.tolerance,
        max_nfev=limits.generations,
    )
    return Ending(str(found.message), found.status > 0)


def differential_evolution(problem: Problem, start: Array, limits: Search) -> Ending:
    """Search by a population; choices are whole numbers."""
    from scipy.optimize import NonlinearConstraint  # noqa: PLC0415
    from scipy.optimize import differential_evolution as solve  # noqa: PLC0415

    spans = np.array([v.upper - v.lower if v.choices else 1.0 for v in problem.trials.design.variables])

    def run(points: Array) -> list[Any]:
        return problem.run(list((points.reshape(len(start), -1) / np.where(spans > 0, spans, 1)[:, None]).T))

    within = NonlinearConstraint(lambda x: np.array([problem.excess_of(t) for t in run(x)]).T, -np.inf, 0.0)
    found = solve(
        lambda x: np.array([problem.aims_of(trial)[0] for trial in run(x)]),
        [(0, span) for span in spans],
        constraints=(within,) if problem.bounds else (),
        integrality=[bool(v.choices) for v in problem.trials.design.variables],
        x0=start * spans,
        popsize=max(2, limits.population // len(start)),
        maxiter=limits.generations,
        tol=limits.tolerance,
        seed=limits.seed,
        vectorized=True,
        updating="deferred",
        polish=False,
    )
    return Ending(str(found.message), bool(found.success))


def nsga2(problem: Problem, start: Array, limits: Search) -> Ending:
    """Search for the trade-offs between several aims by NSGA-II."""
    # Source: Deb, Pratap, Agarwal and Meyarivan, IEEE Trans. Evol. Comput. 6 (2002) 182.
    from pymoo.algorithms.moo.nsga2 import NSGA2  # noqa: PLC0415  (slow to import)
    from pymoo.core.problem import Problem as Vectorised  # noqa: PLC0415
    from pymoo.optimize import minimize  # noqa: PLC0415

    class Study(Vectorised):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__(len(start), len(problem.aims), n_ieq_constr=len(problem.bounds), xl=0.0, xu=1.0)

        def _evaluate(self, x: Array, out: dict[str, Array], *_: object, **__: object) -> None:
            trials = problem.run(list(x))
            out["F"] = np.array([problem.aims_of(trial) for trial in trials])
            if problem.bounds:
                out["G"] = np.array([problem.excess_of(trial) for trial in trials])

    first = np.random.default_rng(limits.seed).random((limits.population, len(start)))
    first[0] = start
    algorithm, begun = NSGA2(pop_size=limits.population, sampling=first), len(problem.history)
    minimize(Study(), algorithm, ("n_gen", limits.generations), seed=limits.seed, verbose=False)
    last = math.ceil((1 - LAST) * (len(problem.history) - begun))
    grown = 1 - _covered(problem, begun + last) / (_covered(problem, len(problem.history)) or 1.0)
    said = f"{limits.generations} generations of {limits.population}"
    return Ending(f"{said}, in the last {LAST:.0%} of which the trade-off grew by {grown:.1%}", grown < SETTLED)


def _covered(problem: Problem, count: int) -> float:
    """Give what the first trials are better than, as a volume over the aims up to the worst of the trade-off."""
    # Source: Zitzler and Thiele, IEEE Trans. Evol. Comput. 3 (1999) 257.
    from pymoo.indicators.hv import HV  # noqa: PLC0415  (slow to import)

    aims = np.array([problem.aims_of(trial) for trial in problem.front])
    if not len(aims):
        return 0.0
    known = [problem.aims_of(trial) for trial in problem.history[:count] if problem.rank(trial)[0] == 0]
    worst, span = aims.max(axis=0), np.ptp(aims, axis=0)
    beyond = worst + LAST * np.where(span > 0, span, np.abs(worst))  # one best trial has no span
    return float(HV(beyond)(np.array(known))) if known else 0.0


METHODS: dict[str, Method] = {
    "slsqp": by_gradients("SLSQP"),
    "trust-constr": by_gradients("trust-constr"),
    "least-squares": least_squares,
    "differential-evolution": differential_evolution,
    "nsga2": nsga2,
}
