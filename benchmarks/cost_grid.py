"""The runs of `fenics-mech cost`: which equations, which solvers, and how fine."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from fenics_mech.answers.by_poses import planned
from fenics_mech.effects.known import COUPLING
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene
from fenics_mech.scene.bodies import Mesh
from fenics_mech.scene.meshing import with_meshes

QUASI_STATIC, TRUNCATED = "quasi-static", "(5.1)"
SETTINGS = {  # of the table, and their meaning
    "elements": "elements per member",
    "sub_intervals": "sub-intervals of the cycle",
    "modes": "modes kept, 0: all",
    "join": "how sub-intervals are joined",
    "stages": "collocation points in a sub-interval",
    "harmonics": "harmonics of the Fourier series",
    "tolerance": "relative tolerance of an integration in time",
    "cycles": "cycles of an integration in time",
}
REFERENCE_MESHES = ((12, 8, 6), (8, 6, 4), (6, 4, 3), (4, 3, 2), (3, 2, 1))  # elements per member, finest first
MOST_ELEMENTS = 28  # of all members together, in a reference: the time grows with their third power


@dataclass(frozen=True)
class GridRun:
    """One run of the grid.

    Parameters
    ----------
    method
        Name of the solver: one line of the figure.
    equation
        Name of the equation that it solves.
    scene
        What is analysed.
    settings
        Its settings, of `SETTINGS`.
    """

    method: str
    equation: str
    scene: Scene
    settings: dict[str, Any] = field(default_factory=dict)


def equations_of(scene: Scene) -> dict[str, Scene]:
    """Give the scene with effects added one at a time, by name; the last has all that it lists, or else calls for.

    The first is the truncated equation (5.1), with what the scene states. Stability is not judged, and answers that are
    too coarse are let pass: their error is what is measured.

    Parameters
    ----------
    scene
        A scene with a periodic response.

    Raises
    ------
    SceneError
        When the scene has no periodic response, or one with a motor.
    """
    if scene.analysis.method != "periodic" or not scene.drives:
        raise SceneError(
            f"the cost of accuracy needs a periodic response, and the method is {scene.analysis.method}"
            + ("" if scene.drives else " without a drive"),
            place="analysis.method",
            hint="Write method = 'periodic', and a [drive]",
        )
    if any(drive.motor is not None for drive in scene.drives):
        raise SceneError(
            "the cost of accuracy cannot be measured with a motor, which has one solver only", place="drive"
        )
    wanted = scene.named_effects or planned(scene.changed(effects="auto")).named_effects
    effects = sorted(wanted, key=lambda name: name != COUPLING)
    lenient = {"analysis__stability": False, "analysis__allow_coarse": True, "analysis__allow_large": True}
    plain = scene.changed(effects=(), tolerance=None, analysis__error_estimates=True, **lenient)
    found = {TRUNCATED: plain}
    for count in range(1, len(effects) + 1):
        found[" + ".join(effects[:count])] = plain.changed(effects=tuple(effects[:count]))
    return found


def meshed(scene: Scene, elements: int) -> Scene:
    """Give a scene whose members have so many elements each.

    Parameters
    ----------
    scene
        The scene.
    elements
        Elements per member.
    """
    return with_meshes(scene, Mesh(elements=elements), lambda mesh: None)


def reference_meshes(scene: Scene, quick: bool = False) -> tuple[int, int, int]:
    """Elements per member of a converged answer: three meshes, the finest first, as fine as time allows.

    Parameters
    ----------
    scene
        The scene, for its number of members.
    quick
        With the coarsest meshes.
    """
    if quick:
        return REFERENCE_MESHES[-1]
    members = len(scene.members())
    return next((mesh for mesh in REFERENCE_MESHES if mesh[0] * members <= MOST_ELEMENTS), REFERENCE_MESHES[-1])


def grid(equations: dict[str, Scene], quick: bool = False) -> list[GridRun]:
    """Give all runs, each method from coarse to fine.

    Parameters
    ----------
    equations
        By name, from `equations_of`.
    quick
        Few and coarse ones.
    """
    runs = list(_quasi_static(equations[TRUNCATED], quick))
    runs += _sub_intervals(equations[TRUNCATED], quick)
    for name, scene in equations.items():
        if name != TRUNCATED or len(equations) == 1:
            runs += _whole_equation(name, scene, quick)
    return runs


def grid_run(method: str, equation: str, scene: Scene, /, **settings: Any) -> GridRun:
    """Make a run from its settings; other keywords are of the analysis, and not of the table."""
    named = {name: settings[name] for name in settings if name in SETTINGS}
    analysis = {f"analysis__{name}": value for name, value in settings.items() if name != "elements"}
    return GridRun(method, equation, meshed(scene.changed(**analysis), settings["elements"]), named)


def _quasi_static(scene: Scene, quick: bool) -> Iterator[GridRun]:
    for count in (24,) if quick else (60, 240):
        for elements in (1, 3):
            yield grid_run(
                QUASI_STATIC, QUASI_STATIC, scene, method="quasi-static", elements=elements, sub_intervals=count
            )


def _sub_intervals(scene: Scene, quick: bool) -> Iterator[GridRun]:
    """Chapter 5: joins, modes and sub-intervals, and two meshes."""
    settings: list[tuple[str, tuple[int | str, ...], tuple[int, ...], tuple[int, ...]]] = [
        ("physical", (3, 5, 8), (60, 120, 240, 480), (3,)),
        ("physical", (5, 8, "all"), (240, 480), (6,)),
        ("projected", (5,), (60, 240, 480), (3,)),
        ("modal", (5,), (60, 240), (3,)),
    ]
    if quick:
        settings = [("physical", (3,), (24, 48), (2,)), ("modal", (3,), (24,), (2,))]
    for join, modes, counts, meshes in settings:
        for elements in meshes:
            for kept in modes:
                for count in counts:
                    yield grid_run(
                        f"sub-intervals, {join}", TRUNCATED, scene, solver="sub-intervals", elements=elements,
                        sub_intervals=count, modes=kept, join=join,
                    )  # fmt: skip


def _whole_equation(name: str, scene: Scene, quick: bool) -> Iterator[GridRun]:
    """Collocation with its stages, and harmonic balance."""
    steps: dict[int, tuple[tuple[int, int], ...]] = {
        1: ((720, 3),),
        2: ((120, 3), (240, 3), (360, 3), (240, 6)),
        3: ((40, 2), (80, 2), (80, 3), (80, 4), (120, 3), (120, 4), (120, 6), (240, 6), (240, 8)),
    }
    series: tuple[tuple[int, int], ...] = ((30, 3), (60, 3), (60, 4), (60, 6), (90, 4))
    if quick:
        steps, series = {3: ((24, 1), (80, 2))}, ((8, 2),)
    for stages, settings in steps.items():
        for count, elements in settings:
            yield grid_run(
                "collocation", name, scene, solver="collocation", elements=elements, sub_intervals=count, stages=stages
            )
    for harmonics, elements in series:
        count = 60 * (4 * harmonics // 60 + 1)  # more than four times as many are needed
        yield grid_run("harmonic balance", name, scene, solver="harmonic-balance", elements=elements,
                    sub_intervals=count, harmonics=harmonics)  # fmt: skip
