"""Methods of optimisation: those of SciPy for one aim, and NSGA-II of pymoo for several."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import MechanismError, SceneError
from fenics_mech.studies.design.problem import Problem


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
    """

    generations: int = 50
    population: int = 20
    seed: int = 0
    tolerance: float = 1e-6


Method = Callable[[Problem, Array, Search], str]


def by_gradients(name: str) -> Method:
    """Give a method of SciPy's `minimize` that takes gradients and limits: "SLSQP" or "trust-constr"."""

    def search(problem: Problem, start: Array, limits: Search) -> str:
        from scipy.optimize import NonlinearConstraint, minimize  # noqa: PLC0415  (slow to import)

        def excess(unit: Array) -> Array:
            return problem.excess_of(problem.run([unit])[0])

        bounds = problem.bounds
        within = NonlinearConstraint(excess, -np.inf, 0.0, jac=lambda unit: problem.jacobian(unit)[1])
        found = minimize(
            lambda unit: float(problem.aims_of(problem.run([unit])[0])[0]),
            start,
            jac=lambda unit: problem.jacobian(unit)[0][0],
            bounds=[(0, 1)] * len(start),
            constraints=[within] if bounds else [],
            method=name,
            tol=limits.tolerance,
            options={"maxiter": limits.generations},
        )
        return str(found.message)

    return search


def least_squares(problem: Problem, start: Array, limits: Search) -> str:
    """Minimise the sum of the squares of all aims."""
    from scipy.optimize import least_squares as solve  # noqa: PLC0415

    if problem.bounds:
        raise SceneError("least squares know no limits", place="study.limits", hint="Take --method slsqp")
    found = solve(
        lambda unit: problem.aims_of(problem.run([unit])[0]),
        np.clip(start, 1e-9, 1 - 1e-9),  # its start is inside of the bounds
        jac=lambda unit: problem.jacobian(unit)[0],
        bounds=(0, 1),
        xtol=limits.tolerance,
        ftol=limits.tolerance,
        max_nfev=limits.generations,
    )
    return str(found.message)


def differential_evolution(problem: Problem, start: Array, limits: Search) -> str:
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
    return str(found.message)


def nsga2(problem: Problem, start: Array, limits: Search) -> str:
    """Search for the trade-offs between several aims by NSGA-II.

    Source: Deb, Pratap, Agarwal and Meyarivan, IEEE Trans. Evol. Comput. 6 (2002) 182.
    """
    try:
        from pymoo.algorithms.moo.nsga2 import NSGA2  # noqa: PLC0415
        from pymoo.core.problem import Problem as Vectorised  # noqa: PLC0415
        from pymoo.optimize import minimize  # noqa: PLC0415
    except ImportError as error:
        message = "several aims need the library pymoo, which is not installed: pip install 'fenics_mech[optimise]'"
        raise MechanismError(message) from error

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
    algorithm = NSGA2(pop_size=limits.population, sampling=first)
    minimize(Study(), algorithm, ("n_gen", limits.generations), seed=limits.seed, verbose=False)
    return f"{limits.generations} generations of {limits.population}"


METHODS: dict[str, Method] = {
    "slsqp": by_gradients("SLSQP"),
    "trust-constr": by_gradients("trust-constr"),
    "least-squares": least_squares,
    "differential-evolution": differential_evolution,
    "nsga2": nsga2,
}
