"""What accuracy costs: error against time of every method and setting, in one run.

Every run is measured against two converged answers. That of its own equation shows the error of solver and mesh.
That of the equation with all effects that the scene calls for also shows the error of effects left out.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
import xarray as xr

from benchmarks.converged import Converged, converged, converged_quasi_static, strains
from benchmarks.cost_grid import (
    QUASI_STATIC,
    SETTINGS,
    TRUNCATED,
    GridRun,
    equations_of,
    grid,
    reference_meshes,
)
from benchmarks.run_table import FAILURE, RunTable, labelled
from benchmarks.timing import TIMES, bare_seconds, machine, timed
from fenics_mech._constants import TINY
from fenics_mech.analysis import analyse
from fenics_mech.errors import MechanismError, SolverError
from fenics_mech.estimate.error_sources import NUMERICAL
from fenics_mech.estimate.quantities import MEASURE
from fenics_mech.recovery import Result
from fenics_mech.recovery.result import stamp
from fenics_mech.scene import Scene

LONGEST_RUN = 12.0  # seconds of a run, after which a method is not made finer
NUMBERS = TIMES | {  # by variable: unit, meaning
    "solver_seconds": ("s", "of it the solver alone, where programs are compared"),
    "error": ("1", "largest difference of strains from the converged ones of the same equation, over the largest"),
    "error_mid_span": ("1", "the same at mid-span"),
    "error_all": ("1", "the same from the converged strains with all effects"),
    "error_all_mid_span": ("1", "the same at mid-span"),
    "estimate": ("1", "the program's own estimate of the error, by steps, mesh, modes and harmonics"),
    "estimate_ratio": ("1", "estimate over error"),
}
TEXTS = {"method": "solver", "equation": "equation that is solved"} | FAILURE
TEXT_SETTINGS = ("join",)
Progress = Callable[[str], None]


@dataclass(frozen=True)
class RunOutcome:
    """What one run of the grid gave.

    Parameters
    ----------
    method, equation, settings
        Which run it is.
    numbers
        Of `NUMBERS`, as far as they are known.
    failure, message
        Kind and text of the error that it ended with.
    """

    method: str
    equation: str
    settings: dict[str, Any]
    numbers: dict[str, float] = field(default_factory=dict)
    failure: str = ""
    message: str = ""


@dataclass(frozen=True)
class Cost(RunTable):
    """What the runs of a grid cost and how good they are.

    Parameters
    ----------
    data
        Dimension "run"; variables as in `NUMBERS`, `TEXTS` and `cost_grid.SETTINGS`, NaN or an empty text where a run
        has none. Attributes: scene, machine, threads, versions, times of imports and compiling, overhead, and
        "references": how the converged answers were found and how sure they are.
    """

    KIND: ClassVar[str] = "table of costs"
    NEEDED: ClassVar[tuple[str, ...]] = ("fenics_mech", "references")

    @property
    def references(self) -> dict[str, dict[str, Any]]:
        """By equation: how its converged answer was found, its uncertainty, or the error that it ended with."""
        return dict(json.loads(self.data.attrs["references"]))


def measure_costs(scene: Scene, *, quick: bool = False, progress: Progress = lambda step: None) -> Cost:
    """Run the grid of a scene.

    Parameters
    ----------
    scene
        A scene with a periodic response.
    quick
        Few and coarse runs, against coarse references.
    progress
        Called with the name of each step before it; there are `steps_of` many.

    Raises
    ------
    SceneError
        When the scene has no periodic response.
    MechanismError
        When the converged answer with all effects is not found: there is nothing to measure by then.
    """
    imports = time.process_time()
    equations = equations_of(scene)
    runs, meshes = grid(equations, quick), reference_meshes(scene, quick)
    compiling = _compiling(runs)
    references = _references(equations, meshes, quick, progress)
    known = {name: found for name, found in references.items() if isinstance(found, Converged)}
    whole = list(equations)[-1]
    if whole not in known:
        raise SolverError(f"there is no converged solution to measure errors by: {references[whole]}")
    outcomes: list[RunOutcome] = []
    slow: set[tuple[str, str]] = set()
    for number, each in enumerate(runs):
        progress(f"{number + 1} of {len(runs)}: {each.method}, {each.equation}")
        outcome = _run(each, known.get(each.equation), known[whole], (each.method, each.equation) in slow)
        outcomes.append(outcome)
        if outcome.numbers.get("seconds", 0.0) > LONGEST_RUN:
            slow.add((each.method, each.equation))
    progress("overhead")
    described = {
        name: found if isinstance(found, str) else {"how": found.how, **vars(found.uncertainty)}
        for name, found in references.items()
    }
    attributes: dict[str, Any] = stamp(scene) | machine() | {"import_seconds": imports, "compile_seconds": compiling}
    attributes |= {"references": json.dumps(described), "equation": whole, "meshes": list(meshes)}
    return Cost(dataset(outcomes).assign_attrs(attributes | _overhead(equations[whole])))


def steps_of(scene: Scene, quick: bool = False) -> int:
    """Give the number of steps that `measure_costs` reports.

    Parameters
    ----------
    scene
        The scene.
    quick
        With few and coarse runs.
    """
    equations = equations_of(scene)
    return len(grid(equations, quick)) + len(equations) + 2


def _overhead(scene: Scene) -> dict[str, float]:
    """Time of an analysis of a scene as it stands, and inside the libraries' linear algebra alone (s)."""
    coarse = scene.changed(analysis__allow_coarse=True, analysis__solver="auto", analysis__allow_ringing=True)
    _, timing = timed(lambda: analyse(coarse))
    bare = bare_seconds(lambda: analyse(coarse))
    return {"analyse_seconds": timing.seconds, "bare_seconds": bare}


def _compiling(runs: Sequence[GridRun]) -> float:
    """Time by which the first run of each equation is longer than the second: it compiles, or reads forms."""
    found = 0.0
    for scene in {each.equation: each.scene for each in reversed(runs)}.values():
        times = [time.process_time()]
        for _ in range(2):
            with suppress(MechanismError):  # what fails is reported when it is measured
                analyse(scene)
            times.append(time.process_time())
        found += max(0.0, 2 * times[1] - times[0] - times[2])
    return found


def _references(
    equations: dict[str, Scene], meshes: tuple[int, int, int], quick: bool, progress: Progress
) -> dict[str, Converged | str]:
    """Find converged answers, or the messages of what they ended with."""
    found: dict[str, Converged | str] = {}
    for name, scene in {QUASI_STATIC: equations[TRUNCATED], **equations}.items():
        progress(f"converged solution: {name}")
        try:
            if name == QUASI_STATIC:
                found[name] = converged_quasi_static(scene, meshes[0])
            else:
                found[name] = converged(scene, meshes, quick)
        except MechanismError as error:
            found[name] = str(error)
    return found


def _run(run: GridRun, own: Converged | None, whole: Converged, slow: bool) -> RunOutcome:
    """Make one run, whatever it ends with."""
    identity = (run.method, run.equation, run.settings)
    if slow:
        return RunOutcome(*identity, {}, "not run", f"a coarser run took more than {LONGEST_RUN:g} s")
    try:
        result, timing = timed(lambda: analyse(run.scene))
    except MechanismError as error:
        return RunOutcome(*identity, {}, type(error).__name__, str(error))
    return RunOutcome(*identity, timing.numbers | _errors_of(result, own, whole))


def _errors_of(result: Result, own: Converged | None, whole: Converged) -> dict[str, float]:
    """Give the errors of a result, and what the program estimates of them, as far as they are known: of `NUMBERS`.

    `own` are the strains of the equation that was solved, and `whole` those of the equation with all effects.
    """
    found = strains(result)
    numbers: dict[str, float] = {}
    if own is not None:
        error = own.error(found)
        numbers |= {"error": error.everywhere, "error_mid_span": error.mid_span}
    error = whole.error(found)
    numbers |= {"error_all": error.everywhere, "error_all_mid_span": error.mid_span}
    sources = [source for source in NUMERICAL if source in result.data["source"]]
    if sources:
        largest = np.abs(found).max(axis=(0, 2, 3))
        of_each = result.data["strain_error"].sel(source=sources).sum("source").to_numpy()
        numbers["estimate"] = float((of_each / np.maximum(largest, MEASURE.small_member * largest.max())).max())
        if own is not None:
            numbers["estimate_ratio"] = numbers["estimate"] / max(numbers["error"], TINY)
    return numbers


def dataset(outcomes: Sequence[RunOutcome]) -> xr.Dataset:
    """Label the numbers of some runs.

    Parameters
    ----------
    outcomes
        What came of each run.
    """
    rows = []
    for outcome in outcomes:
        settings: dict[str, Any] = dict.fromkeys(SETTINGS, np.nan) | dict.fromkeys(TEXT_SETTINGS, "")
        settings |= {name: 0 if value == "all" else value for name, value in outcome.settings.items()}
        rows.append({name: getattr(outcome, name) for name in TEXTS} | settings | outcome.numbers)
    return labelled(rows, TEXTS | SETTINGS, NUMBERS)
