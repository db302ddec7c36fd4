"""The seed four-bar by this program and by others, in one run: error of the mid-span strains against time.

All have the same mechanism, the same damping and the same quantity: the strain of the + fibre at mid-span of coupler
and follower. Every program is measured against its own converged answer, and against that of the other program which
solves the same equation. Peers are Kaminski's chapter 5 and Gauss-Legendre collocation by hand, matrix exponentials of
the coupled equation by hand, SciPy's `solve_ivp`, and Exudyn.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.analysis import analyse
from fenics_mech.errors import MechanismError, SceneError
from fenics_mech.kinematics import solve_motion
from fenics_mech.recovery.result import stamp
from fenics_mech.reference import NineElementModel, gauss_legendre_periodic, link_strain, periodic_response
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.studies.converged import Converged, converged, difference, extrapolated
from fenics_mech.studies.cost import Cost, Line, Progress, dataset
from fenics_mech.studies.cost_grid import REDUCED, TRUNCATED, meshed
from fenics_mech.studies.peers.by_hand import by_exponentials, by_solve_ivp
from fenics_mech.studies.peers.exudyn_four_bar import SEED_RETARDATION, strain_curves
from fenics_mech.studies.peers.exudyn_model import import_exudyn
from fenics_mech.studies.timing import Clock, machine, timed

MEMBERS = ("coupler", "follower")
COUPLED, EXACT = "coupling", "moderate or exact rotations"
OURS, EXUDYN = "fenics_mech", "Exudyn"
CHAPTER_5 = ((60, 3, 3), (120, 5, 3), (240, 5, 3), (480, 8, 6))  # sub-intervals, modes, elements a link
GAUSS_LEGENDRE = ((80, 2), (80, 3), (120, 3), (120, 4), (180, 4), (240, 6), (240, 8))  # steps a cycle, elements a link
EXPONENTIALS = ((360, 3), (1440, 3), (2880, 3), (5760, 4))  # the same
EXUDYN_STEPS = ((360, 4), (720, 4), (720, 8), (1080, 8), (1440, 8), (2880, 16))  # the same
COLLOCATION = ((80, 2), (80, 3), (80, 4), (120, 4), (120, 6), (240, 6), (240, 8))  # the same, by 3 Radau points
SERIES = ((48, 3), (60, 4), (60, 6), (72, 8))  # harmonics, elements a link
SOLVE_IVP = ((1e-2, 2), (1e-2, 3), (1e-3, 3))  # relative tolerance, elements a link
CYCLES = 8  # of Exudyn's integration: the start has died away to 3e-4 by then


@dataclass(frozen=True)
class Entry:
    """One run of a program.

    Parameters
    ----------
    program, equation
        Who solves what.
    work
        Gives the mid-span strains, ``(angles, 2, 1, 1)``.
    settings
        Its settings, of `cost_grid.SETTINGS`.
    """

    program: str
    equation: str
    work: Callable[[], Array]
    settings: dict[str, Any] = field(default_factory=dict)


def require_seed(scene: Scene) -> None:
    """Refuse every scene but the seed four-bar, for which alone there are peers; its analysis may be another.

    Raises
    ------
    SceneError
        When the scene is another one.
    """
    if not is_seed(scene):
        raise SceneError(
            f"there are peers of the seed four-bar only (demos/four_bar.toml), and {scene.name!r} is another machine",
            place="--peers",
            hint="Leave --peers out",
        )


def is_seed(scene: Scene) -> bool:
    """Tell whether a scene is the seed four-bar, whatever its mesh, effects and analysis."""
    return bool(_machine(scene) == _machine(seed_four_bar()))


def _machine(scene: Scene) -> Any:
    """Numbers that a machine is the same by, whatever its sections and materials are called."""
    half = np.array([0.5])
    members = {}
    for label in scene.members():
        section = scene.rigidity(label, half)
        numbers = [section.axial, section.bending, section.line_density, section.fibre, scene.member_ends(label)]
        members[label] = [np.round(np.ravel(part) / np.abs(part).max(), 9).tolist() for part in map(np.array, numbers)]
        members[label] += [f"{np.abs(np.array(part)).max():.9g}" for part in numbers]
    others = ("ground", "joints", "masses", "gravity", "loads", "impulses", "springs", "dampers", "drive", "damping")
    branch = np.round(solve_motion(scene, np.zeros(1)).angle[0], 6).tolist() if len(members) == 3 else None
    return members, branch, {name: scene.model_dump(mode="json")[name] for name in others}


def compare_peers(
    scene: Scene, *, quick: bool = False, progress: Progress = lambda step: None, clock: Clock = time.process_time
) -> Cost:
    """Run all programs on the seed four-bar.

    Parameters
    ----------
    scene
        The seed four-bar.
    quick
        Few and coarse runs, without SciPy and Exudyn.
    progress
        Called with the name of each step before it.
    clock
        Gives the time by which runs are measured (s).

    Returns
    -------
    Cost
        Of it "error_mid_span" is against the program's own converged answer, "error_all_mid_span" against that of the
        other program that solves the equation: hand-coded Gauss-Legendre collocation, or Exudyn.

    Raises
    ------
    SceneError
        When the scene is another one.
    MechanismError
        When Exudyn is not installed, or a converged answer is not found.
    """
    require_ready(scene, quick)
    entries, known = entries_of(quick), {}
    for ours, equation in _references(entries):
        progress(f"converged solution: {equation}, {OURS if ours else 'peers'}")
        known[ours, equation] = _converged(ours, equation, quick)
    lines = []
    for number, entry in enumerate(entries):
        progress(f"{number + 1} of {len(entries)}: {entry.program}, {entry.equation}")
        lines.append(_run(entry, known, clock))
    references = {
        f"{equation}, {OURS if ours else 'peers'}": {"how": found.how, **vars(found.uncertainty)}
        for (ours, equation), found in known.items()
    }
    attributes = stamp(scene) | machine() | {"references": json.dumps(references), "equation": "the other program's"}
    return Cost(dataset(lines).assign_attrs(attributes))


def require_ready(scene: Scene, quick: bool = False) -> None:
    """Refuse a scene that there are no peers for, and a machine without Exudyn where that is to run.

    Raises
    ------
    SceneError
        When the scene is not the seed four-bar.
    MechanismError
        When Exudyn is not installed.
    """
    require_seed(scene)
    if not quick:
        import_exudyn()


def entries_of(quick: bool = False) -> list[Entry]:
    """Give all runs."""
    return [*_by_hand(quick), *([] if quick else [*_by_scipy(), *_by_exudyn()]), *_ours(quick)]


def steps_of(quick: bool = False) -> int:
    """Give the number of steps that `compare_peers` reports."""
    entries = entries_of(quick)
    return len(entries) + len(_references(entries))


def _references(entries: Sequence[Entry]) -> list[tuple[bool, str]]:
    """Whose converged answers are needed, this program's or its peers', and of which equations."""
    return sorted({(ours, each.equation) for each in entries for ours in (each.program.startswith(OURS), False)})


def _run(entry: Entry, known: dict[tuple[bool, str], Converged], clock: Clock) -> Line:
    """Make one run, whatever it ends with."""
    try:
        strain, timing = timed(entry.work, clock)
    except (MechanismError, ArithmeticError) as error:
        return Line(entry.program, entry.equation, entry.settings, {}, type(error).__name__, str(error))
    numbers = timing.numbers
    own, other = (known.get((ours, entry.equation)) for ours in (entry.program.startswith(OURS), False))
    for name, reference in {"error_mid_span": own, "error_all_mid_span": other}.items():
        if reference is not None:
            numbers[name] = reference.error(strain).mid_span
    return Line(entry.program, entry.equation, entry.settings, numbers)


def _scene(equation: str) -> Scene:
    """Give the seed with the equation that peers solve; strains at mid-span, without stability."""
    seed = seed_four_bar(analysis__stations=3, analysis__stability=False, analysis__allow_coarse=True)
    if equation == EXACT:
        damping = {"ratio": 0.0, "material": SEED_RETARDATION}
        return seed.changed(effects=("coupling", "moderate-rotations"), damping=damping)
    return seed.changed(effects=("coupling",) if equation == COUPLED else ())


def _converged(ours: bool, equation: str, quick: bool) -> Converged:
    """Find the converged answer of this program or of its peers."""
    if ours:
        found = converged(_scene(equation), (3, 2, 1) if quick else (8, 6, 4), quick)
        return Converged(_middle(found.strain), found.uncertainty, found.how)
    if equation == EXACT:
        fine, half, check, rough = (
            _exudyn(elements, steps, cycles=16) for elements, steps in ((16, 2880), (16, 1440), (8, 1440), (8, 720))
        )
        strain, other = extrapolated(fine, half, 2), extrapolated(check, rough, 2)
        how = "Exudyn, 16 elements, 16 cycles, extrapolated from 1440 and 2880 steps; checked by 8, half the steps"
        return Converged(strain, difference(other, strain), how)
    meshes, steps = ((3, 2, 1), 120) if quick else ((8, 6, 4), 480)
    runs = [_gauss_legendre(n, count, equation) for n, count in zip(meshes, (steps, steps, steps // 2))]
    strain, other = (extrapolated(runs[i], runs[i + 1], meshes[i] / meshes[i + 1]) for i in (0, 1))
    how = (
        f"Gauss-Legendre collocation by hand, {steps} steps, extrapolated from {meshes[0]} and {meshes[1]} elements; "
        f"checked by {meshes[1]} and {meshes[2]}, the last with half the steps"
    )
    return Converged(strain, difference(other, strain), how)


def _by_hand(quick: bool) -> Iterator[Entry]:
    """Chapter 5, Gauss-Legendre collocation and matrix exponentials on hand-coded matrices."""
    for count, modes, elements in CHAPTER_5[:1] if quick else CHAPTER_5:
        settings = {"elements": elements, "sub_intervals": count, "modes": modes}
        yield Entry("chapter 5 by hand", TRUNCATED, partial(_chapter_5, elements, count, modes), settings)
    for count, elements in GAUSS_LEGENDRE[:1] if quick else GAUSS_LEGENDRE:
        settings = {"elements": elements, "sub_intervals": count}
        yield Entry("Gauss-Legendre by hand", COUPLED, partial(_gauss_legendre, elements, count, COUPLED), settings)
    for count, elements in ((60, 1),) if quick else EXPONENTIALS:
        settings = {"elements": elements, "sub_intervals": count}
        yield Entry("exponentials by hand", COUPLED, partial(_exponentials, elements, count), settings)


def _by_scipy() -> Iterator[Entry]:
    for tolerance, elements in SOLVE_IVP:
        settings = {"elements": elements, "tolerance": tolerance}
        yield Entry("solve_ivp by hand", COUPLED, partial(_solve_ivp, elements, tolerance), settings)


def _by_exudyn() -> Iterator[Entry]:
    for count, elements in EXUDYN_STEPS:
        yield Entry(EXUDYN, EXACT, partial(_exudyn, elements, count), {"elements": elements, "sub_intervals": count})


def _ours(quick: bool) -> Iterator[Entry]:
    """Runs of this program: chapter 5, collocation by Radau points, and harmonic balance."""
    for count, modes, elements in () if quick else CHAPTER_5:
        settings = {"elements": elements, "sub_intervals": count, "modes": modes}
        yield Entry(
            f"{OURS}, sub-intervals", TRUNCATED, _analysis(TRUNCATED, solver="sub-intervals", **settings), settings
        )
    for equation in (COUPLED,) if quick else (COUPLED, EXACT):
        for count, elements in COLLOCATION[:1] if quick else COLLOCATION:
            settings = {"elements": elements, "sub_intervals": count, "stages": 3}
            work = _analysis(equation, solver="collocation", **settings)
            yield Entry(f"{OURS}, collocation", equation, work, settings)
        for count, stages, elements, cutoff in () if quick else REDUCED:
            settings = {"elements": elements, "sub_intervals": count, "stages": stages, "cutoff": cutoff}
            work = _analysis(equation, solver="collocation", reduction="craig-bampton", **settings)
            yield Entry(f"{OURS}, reduced", equation, work, settings)
        for harmonics, elements in () if quick else SERIES:
            settings = {"elements": elements, "sub_intervals": 5 * harmonics, "harmonics": harmonics}
            work = _analysis(equation, solver="harmonic-balance", **settings)
            yield Entry(f"{OURS}, harmonic balance", equation, work, settings)


def _analysis(equation: str, elements: int, **analysis: Any) -> Callable[[], Array]:
    changes = {f"analysis__{name}": value for name, value in analysis.items()}
    scene = meshed(_scene(equation).changed(**changes), elements)

    def work() -> Array:
        result = analyse(scene)
        return np.stack([result.strain_at(member) for member in MEMBERS], axis=1)[..., None, None]

    return work


def _chapter_5(elements: int, count: int, modes: int) -> Array:
    model = NineElementModel(elements=elements)
    found = periodic_response(model, count, modes=modes)
    return _middles(link_strain(model, found.theta, found.displacement, found.acceleration).total)


def _exponentials(elements: int, count: int) -> Array:
    return _middles(by_exponentials(count, elements))


def _solve_ivp(elements: int, tolerance: float) -> Array:
    return _middles(by_solve_ivp(tolerance, elements))


def _gauss_legendre(elements: int, count: int, equation: str) -> Array:
    model = NineElementModel(elements=elements)
    found = gauss_legendre_periodic(model, count, coupling=equation == COUPLED)
    return _middles(link_strain(model, found.theta, found.displacement, found.acceleration).total)


def _exudyn(elements: int, steps: int, cycles: int = CYCLES) -> Array:
    found = strain_curves(_scene(EXACT), SEED_RETARDATION, elements=elements, steps=steps, cycles=cycles, angles=360)
    return found.strain[:, [found.members.index(member) for member in MEMBERS], :1, None]


def _middles(strain: Array) -> Array:
    """Strains of crank, coupler and follower, ``(angles, 3)``, as those of coupler and follower."""
    return strain[:, 1:, None, None]


def _middle(strain: Array) -> Array:
    """Take coupler and follower, mid-span and the + fibre from strains of the seed."""
    return strain[:, 1:, 1:2, :1]
