"""One machine by this program and by others, in one run: error of the mid-span strains against time.

All have the same mechanism, the same damping and the same quantity: the strain of the + fibre at mid-span. Every
program is measured against its own converged answer, and against that of the other program which solves the same
equation. Exudyn is the peer of every linkage of beams on pins and guides, with damping of the material. The seed
four-bar has peers that know no other machine: see `seed_programs`.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from benchmarks.converged import Converged, converged, difference, extrapolated
from benchmarks.cost import Cost, Progress, RunOutcome, dataset
from benchmarks.cost_grid import TRUNCATED, meshed
from benchmarks.peers.exudyn_cycle import Integration, import_exudyn, steady_cycle
from benchmarks.peers.peer_runs import COUPLED, EXACT, EXUDYN, OURS, Entry, Note
from benchmarks.peers.seed_programs import CHAPTER_5, by_hand, converged_by_hand, is_seed
from benchmarks.timing import machine, timed
from fenics_mech._arrays import Array
from fenics_mech.analysis import analyse
from fenics_mech.effects.known import COUPLING, EXACT_STRAINS
from fenics_mech.errors import MechanismError
from fenics_mech.other_programs.beam_linkage import BeamLinkage, beam_linkage, with_material_damping
from fenics_mech.recovery.result import stamp
from fenics_mech.scene import Scene

SEED_MEMBERS = ("coupler", "follower")
EXUDYN_RUNS = (  # elements a member, coarse cycles and their steps, fine cycles and theirs, tolerance of Newton
    (2, 0, 0, 4, 120, 1e-4),
    (2, 0, 0, 5, 120, 1e-4),
    (2, 1, 180, 2, 360, 1e-4),
    (2, 2, 240, 2, 480, 1e-4),
    (4, 4, 120, 3, 240, 1e-4),
    (4, 4, 180, 2, 360, 1e-4),
    (4, 2, 240, 3, 840, 1e-4),
    (4, 2, 270, 3, 1080, 1e-3),
    (4, 2, 360, 2, 1080, 1e-5),
    (4, 2, 360, 2, 1440, 1e-5),
    (6, 4, 540, 3, 2160, 1e-3),
    (6, 4, 540, 3, 2160, 1e-4),
    (8, 4, 720, 4, 2880, 1e-4),
)
EXUDYN_ANGLES = 120
COLLOCATION = (  # sub-intervals, Radau points in each, elements a member
    (24, 2, 2), (24, 3, 2), (40, 2, 2), (40, 3, 2), (60, 3, 3), (50, 4, 4), (60, 4, 4), (80, 3, 4), (80, 4, 6),
    (120, 3, 6), (80, 4, 7), (100, 4, 8), (240, 3, 8),
)  # fmt: skip
SERIES_RUNS = ((48, 3), (60, 4), (60, 6), (72, 8))  # harmonics, elements a member


def compare_peers(scene: Scene, *, quick: bool = False, progress: Progress = lambda step: None) -> Cost:
    """Run all programs that know a machine.

    Parameters
    ----------
    scene
        The seed four-bar, or another linkage that `beam_linkage` can take.
    quick
        Few and coarse runs; of the seed, without SciPy and Exudyn.
    progress
        Called with the name of each step before it.

    Returns
    -------
    Cost
        Of it "error_mid_span" is against the program's own converged answer, "error_all_mid_span" against that of the
        other program that solves the equation: hand-coded Gauss-Legendre collocation, or Exudyn.

    Raises
    ------
    SceneError
        When other programs cannot be given the scene.
    MechanismError
        When Exudyn is not installed, or a converged answer is not found.
    """
    require_ready(scene, quick)
    entries, known = entries_of(scene, quick), {}
    for ours, equation in _references(entries):
        progress(f"converged solution: {equation}, {OURS if ours else 'peers'}")
        known[ours, equation] = _converged(scene, ours, equation, quick)
    outcomes = []
    for number, entry in enumerate(entries):
        progress(f"{number + 1} of {len(entries)}: {entry.program}, {entry.equation}")
        outcomes.append(_run(entry, known))
    references = {
        f"{equation}, {OURS if ours else 'peers'}": {"how": found.how, **vars(found.uncertainty)}
        for (ours, equation), found in known.items()
    }
    between = {
        equation: found.error(known[False, equation].strain).mid_span
        for (ours, equation), found in known.items()
        if ours
    }
    attributes = stamp(scene) | machine() | {"references": json.dumps(references), "between": json.dumps(between)}
    return Cost(dataset(outcomes).assign_attrs(attributes | {"equation": "the other program's"}))


def require_ready(scene: Scene, quick: bool = False) -> None:
    """Refuse a scene that there are no peers for, and a computer without Exudyn where that is to run.

    Parameters
    ----------
    scene
        The scene.
    quick
        With few and coarse runs; of the seed, without Exudyn.

    Raises
    ------
    SceneError
        When other programs cannot be given the scene.
    MechanismError
        When Exudyn is not installed.
    """
    beam_linkage(scene_of(scene, EXACT))
    if not (quick and is_seed(scene)):
        import_exudyn()


def entries_of(scene: Scene, quick: bool = False) -> list[Entry]:
    """Give all runs.

    Parameters
    ----------
    scene
        The scene.
    quick
        With few and coarse runs; of the seed, without SciPy and Exudyn.
    """
    seed = is_seed(scene)
    entries = [*by_hand(quick)] if seed else []
    if not (quick and seed):
        entries += _by_exudyn(scene, quick)
    return [*entries, *_ours(scene, seed, quick)]


def steps_of(scene: Scene, quick: bool = False) -> int:
    """Give the number of steps that `compare_peers` reports.

    Parameters
    ----------
    scene
        The scene.
    quick
        With few and coarse runs; of the seed, without SciPy and Exudyn.
    """
    entries = entries_of(scene, quick)
    return len(entries) + len(_references(entries))


def scene_of(scene: Scene, equation: str) -> Scene:
    """Give a scene with an equation that peers solve; strains at mid-span, without stability.

    Parameters
    ----------
    scene
        The scene.
    equation
        `TRUNCATED`, `COUPLED` or `EXACT`.
    """
    lean = scene.changed(
        tolerance=None,
        analysis={"method": "periodic", "stations": 3, "stability": False, "allow_coarse": True},
        effects={TRUNCATED: (), COUPLED: (COUPLING,), EXACT: (COUPLING, EXACT_STRAINS)}[equation],
    )
    return with_material_damping(lean) if equation == EXACT else lean


def _references(entries: Sequence[Entry]) -> list[tuple[bool, str]]:
    """Whose converged answers are needed, this program's or its peers', and of which equations."""
    return sorted({(ours, each.equation) for each in entries for ours in (each.program.startswith(OURS), False)})


def _run(entry: Entry, known: dict[tuple[bool, str], Converged]) -> RunOutcome:
    """Make one run, whatever it ends with."""
    solving: list[float] = []
    try:
        strain, timing = timed(lambda: entry.work(solving.append))
    except (MechanismError, ArithmeticError) as error:
        return RunOutcome(entry.program, entry.equation, entry.settings, {}, type(error).__name__, str(error))
    numbers = timing.numbers
    if solving:
        numbers["solver_seconds"] = float(np.median(solving[-timing.repeats :]))
    own, other = (known.get((ours, entry.equation)) for ours in (entry.program.startswith(OURS), False))
    for name, reference in {"error_mid_span": own, "error_all_mid_span": other}.items():
        if reference is not None:
            numbers[name] = reference.error(strain).mid_span
    return RunOutcome(entry.program, entry.equation, entry.settings, numbers)


def _converged(scene: Scene, ours: bool, equation: str, quick: bool) -> Converged:
    """Find the converged answer of this program or of its peers."""
    if ours:
        found = converged(scene_of(scene, equation), (3, 2, 1) if quick else (8, 6, 4), quick)
        places = [list(scene.members()).index(member) for member in _members(scene, equation)]
        return Converged(found.strain[:, places, 1:2, :1], found.uncertainty, found.how)
    if equation != EXACT:
        return converged_by_hand(equation, quick)
    linkage = beam_linkage(scene_of(scene, EXACT))
    steps, cycles, (most, fewer) = (480, 5, (4, 2)) if quick else (5760, 11, (12, 8))
    fine, half, check, rough = (
        _exudyn(linkage, Integration(elements, (count // 2,) * 4 + (count,) * (cycles - 4), 1e-6), lambda seconds: None)
        for elements, count in ((most, steps), (most, steps // 2), (fewer, steps // 2), (fewer, steps // 4))
    )
    strain, other = extrapolated(fine, half, 2), extrapolated(check, rough, 2)
    how = (
        f"Exudyn, {most} elements, {cycles} cycles, extrapolated from {steps // 2} and {steps} steps a cycle; "
        f"checked by {fewer}, half the steps"
    )
    return Converged(strain, difference(other, strain), how)


def _members(scene: Scene, equation: str) -> Sequence[str]:
    """Members whose strains are compared: hand-coded programs give those of two links."""
    return list(scene.members()) if equation == EXACT else SEED_MEMBERS


def _by_exudyn(scene: Scene, quick: bool) -> Iterator[Entry]:
    linkage = beam_linkage(scene_of(scene, EXACT))
    for elements, leading, coarse, cycles, steps, tolerance in EXUDYN_RUNS[:1] if quick else EXUDYN_RUNS:
        how = Integration(elements, (coarse,) * leading + (steps,) * cycles, tolerance)
        settings = {"elements": elements, "sub_intervals": steps, "cycles": leading + cycles, "tolerance": tolerance}
        yield Entry(EXUDYN, EXACT, partial(_exudyn, linkage, how), settings)


def _exudyn(linkage: BeamLinkage, how: Integration, note: Note) -> Array:
    found = steady_cycle(linkage, how, EXUDYN_ANGLES)
    note(found.seconds)
    return found.strain[:, :, :1, None]


def _ours(scene: Scene, seed: bool, quick: bool) -> Iterator[Entry]:
    """Runs of this program: of the seed chapter 5, and collocation by Radau points and harmonic balance of all."""
    for count, modes, elements in () if quick or not seed else CHAPTER_5:
        settings = {"elements": elements, "sub_intervals": count, "modes": modes}
        yield _analysis(scene, "sub-intervals", TRUNCATED, settings)
    equations = ([COUPLED] if seed else []) + ([] if quick and seed else [EXACT])
    for equation in equations:
        for count, stages, elements in COLLOCATION[3:4] if quick else COLLOCATION:
            settings = {"elements": elements, "sub_intervals": count, "stages": stages}
            yield _analysis(scene, "collocation", equation, settings)
        for harmonics, elements in () if quick else SERIES_RUNS:
            settings = {"elements": elements, "sub_intervals": 5 * harmonics, "harmonics": harmonics}
            yield _analysis(scene, "harmonic-balance", equation, settings)


def _analysis(scene: Scene, solver: str, equation: str, settings: dict[str, Any]) -> Entry:
    """Give a run of this program, whose solver is the step "response" of the analysis."""
    analysis = {name: value for name, value in settings.items() if name != "elements"} | {"solver": solver}
    changes = {f"analysis__{name}": value for name, value in analysis.items()}
    stated = meshed(scene_of(scene, equation).changed(**changes), settings["elements"])
    members = _members(scene, equation)

    def work(note: Note) -> Array:
        begun: list[tuple[float, str]] = []
        result = analyse(stated, lambda step: begun.append((time.process_time(), step)))
        note(sum(end - start for (start, step), (end, _) in pairwise(begun) if step == "response"))
        return np.stack([result.strain_at(member) for member in members], axis=1)[..., None, None]

    return Entry(f"{OURS}, {solver.replace('-balance', ' balance')}", equation, work, settings)
