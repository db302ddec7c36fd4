"""How a run grows with elements, links and positions: processor time and memory, each run in a process of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from multiprocessing import get_context
from typing import Any

import numpy as np
import xarray as xr

from benchmarks.run_table import FAILURE, RunTable, labelled
from benchmarks.timing import TIMES, machine, peak_memory, timed
from fenics_mech._version import __version__
from fenics_mech.analysis import analyse
from fenics_mech.effects.known import COUPLING
from fenics_mech.errors import MechanismError
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar

LONGEST_LINE_RUN = 15.0  # seconds of a run, after which a line is not made longer
THICKER = 0.03  # of each stage's inertias against the one before: no two links are alike
RATIO, RETARDATION = 0.02, 1e-4  # damping of all modes, which makes matrices full, and by the material (s)
SOLVERS = {"sub-intervals": (), "collocation": (COUPLING,)}  # and the effects that they are run with
PER_POSITION = "per position"
NUMBERS = TIMES | {  # by variable: unit, meaning
    "memory": ("MB", "largest memory of the process"),
    "memory_before": ("MB", "the same before the run: libraries, forms and a small run"),
}
SETTINGS = {
    "series": "what varies",
    "solver": "solver of the periodic response",
    "elements": "elements per link",
    "links": "moving links",
    "positions": "positions in a cycle (sub-intervals)",
} | FAILURE
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Size:
    """How large a run is.

    Parameters
    ----------
    series
        What varies: "elements", "links", "positions", or `PER_POSITION`, where elements and positions do.
    solver
        Of `SOLVERS`.
    elements, links, positions
        Elements per link, moving links, sub-intervals.
    """

    series: str
    solver: str
    elements: int = 3
    links: int = 3
    positions: int = 120

    @property
    def line(self) -> tuple[str, str]:
        """The runs that it is compared with."""
        return self.series, self.solver

    def scene(self) -> Scene:
        """Give the scene of the run. It is as coarse as it is asked for: what it costs counts, not how good it is."""
        damping = {"material": RETARDATION} if self.solver == "collocation" else {"ratio": RATIO}
        return chain(
            self.links // 2,
            effects=SOLVERS[self.solver],
            damping=damping,
            mesh__elements=self.elements,
            analysis__solver=self.solver,
            analysis__sub_intervals=self.positions,
            analysis__allow_coarse=True,
            analysis__allow_ringing=True,
            analysis__allow_unstable=True,
        )


@dataclass(frozen=True)
class Scaling(RunTable):
    """What runs of many sizes cost: variables as in `NUMBERS` and `SETTINGS`, NaN or an empty text for none."""

    KIND = "table of sizes"
    NEEDED = ("fenics_mech", "machine", "sizes")


def chain(stages: int, **rest: Any) -> Scene:
    """Make a chain of four-bars on one crank: the seed, then parallelograms, each driven by the follower before it.

    It has 2 stages + 1 moving links and as many closed loops as stages; the pins between stages go through three links.

    Parameters
    ----------
    stages
        Number of four-bars.
    **rest
        Other values, as `Scene.changed` takes them.
    """
    data = seed_four_bar(name=f"chain of {stages} four-bars").model_dump()
    links, joints, sections, pins = data["links"], data["joints"], data["sections"], data["ground"]["points"]
    pitch, start = links["coupler"]["points"]["B"][0], pins["C"][0]
    for stage in range(2, stages + 1):
        before = "" if stage == 2 else str(stage - 1)
        for kind in ("coupler", "follower"):
            section = sections[kind] | {"inertia": sections[kind]["inertia"] * (1 + THICKER) ** (stage - 1)}
            sections[f"{kind}{stage}"] = section
            members = {name: member | {"section": f"{kind}{stage}"} for name, member in links[kind]["members"].items()}
            links[f"{kind}{stage}"] = links[kind] | {"members": members}
        links[f"coupler{stage}"]["angle"] = 0.0
        pins[f"C{stage}"] = (start + (stage - 1) * pitch, 0.0)
        joints[f"B{before}"]["connect"] = (*joints[f"B{before}"]["connect"], f"coupler{stage}.A")
        joints[f"B{stage}"] = {"connect": (f"coupler{stage}.B", f"follower{stage}.B")}
        joints[f"C{stage}"] = {"connect": (f"ground.C{stage}", f"follower{stage}.C")}
    return Scene.read(data).changed(**rest)


def sizes(quick: bool = False) -> list[Size]:
    """Give all runs, each line from small to large.

    Parameters
    ----------
    quick
        With few and small runs.
    """
    along: dict[str, tuple[int, ...]] = {  # by series
        "elements": (3, 10, 20, 100, 300),
        "links": (3, 7, 15, 29),
        "positions": (60, 400, 2500, 10_000),
    }
    fineness: tuple[int, ...] = (8, 32, 128)
    count = 1000
    if quick:
        along = {series: values[:2] for series, values in along.items()}
        fineness, count = fineness[:2], 60
    return [*_lines(along), *_pairs(fineness, (count, 2 * count))]


def _lines(along: dict[str, tuple[int, ...]]) -> Iterator[Size]:
    for series, values in along.items():
        for solver in SOLVERS:
            for value in values:
                yield Size(series, solver, **{series: value})  # type: ignore[arg-type]


def _pairs(fineness: Sequence[int], positions: Sequence[int]) -> Iterator[Size]:
    """Runs whose differences are the cost of a position."""
    for solver in SOLVERS:
        for elements in fineness:
            for count in positions:
                yield Size(PER_POSITION, solver, elements=elements, positions=count)


def measure_scaling(
    asked: Sequence[Size], progress: Progress = lambda step: None, run: Callable[[Size], dict[str, float]] | None = None
) -> Scaling:
    """Run all sizes.

    Parameters
    ----------
    asked
        The sizes, each line from small to large.
    progress
        Called with the name of each run before it.
    run
        Gives the numbers of one run, of `NUMBERS`; `in_own_process` by itself.
    """
    work, slow = run or in_own_process, set()
    rows: list[dict[str, Any]] = []
    for size in asked:
        progress(f"{size.solver}: {size.elements} elements, {size.links} links, {size.positions}")
        row: dict[str, Any] = asdict(size) | {"failure": "", "message": ""}
        try:
            if size.line in slow:
                raise TimeoutError(f"a smaller run took more than {LONGEST_LINE_RUN:g} s")
            row |= work(size)
        except (MechanismError, TimeoutError) as error:
            row |= {"failure": type(error).__name__, "message": str(error)}
        if row.get("seconds", 0.0) > LONGEST_LINE_RUN and size.series != PER_POSITION:
            slow.add(size.line)
        rows.append(row)
    return Scaling(
        labelled(rows, SETTINGS, NUMBERS).assign_attrs({"fenics_mech": __version__, "sizes": len(rows)} | machine())
    )


def in_own_process(size: Size) -> dict[str, float]:
    """Measure one size in a process of its own, so that its largest memory is that of this run.

    Parameters
    ----------
    size
        What to measure.

    Returns
    -------
    dict
        Of `NUMBERS`.

    Raises
    ------
    MechanismError
        When the run ends with an error, or the system ends the process, as it does where there is no memory left.
    """
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        try:
            return pool.submit(_measure_size, size).result()
        except BrokenProcessPool as error:
            raise MechanismError("the process was ended from outside: there may be too little memory") from error


def _measure_size(size: Size) -> dict[str, float]:
    """Measure one size in this process: of `NUMBERS`."""
    with suppress(MechanismError):  # it compiles, or reads forms
        analyse(replace(size, elements=3, links=3, positions=60).scene())
    scene, before = size.scene(), peak_memory() / 1e6
    _, timing = timed(lambda: analyse(scene))
    return timing.numbers | {"memory": peak_memory() / 1e6, "memory_before": before}


def cost_per_position(data: xr.Dataset) -> list[tuple[str, int, float]]:
    """Give solver, elements per link and processor time per position (s), by two runs that differ in their positions.

    What is done once for all positions is in neither.

    Parameters
    ----------
    data
        Table of the runs, as of `Scaling.data`.
    """
    found = []
    pairs = data.isel(run=np.flatnonzero((data["series"] == PER_POSITION).to_numpy()))
    few, many = pairs.isel(run=slice(0, None, 2)), pairs.isel(run=slice(1, None, 2))
    added = (many["seconds"].to_numpy() - few["seconds"].to_numpy()) / (many["positions"] - few["positions"]).to_numpy()
    for solver, elements, each in zip(few["solver"].to_numpy(), few["elements"].to_numpy(), added):
        found.append((str(solver), int(elements), float(each)))
    return found
