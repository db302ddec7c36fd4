"""What several commands have in common: their arguments and options, and how a scene file is loaded."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, cast

import typer

from fenics_mech._console import loading, progress_bar, warn
from fenics_mech.errors import MechanismError, SceneError

if TYPE_CHECKING:
    from fenics_mech.recovery import Result
    from fenics_mech.recovery.spatial_result import SpatialResult
    from fenics_mech.scene import Scene
    from fenics_mech.scene.answer_units import AnswerUnits
    from fenics_mech.scene.in_space import SpatialScene

AnyScene = TypeVar("AnyScene", "Scene", "SpatialScene")
LEFT_OUT = "the scene is taken without its load cases. Write {}@{}.toml for one of them"
SceneFile = Annotated[
    Path, typer.Argument(help="Scene file (TOML); NAME@CASE.toml takes one of its load cases.", show_default=False)
]
Refine = Annotated[int, typer.Option(min=0, max=20, help="Halve every element this many times.")]
Strict = Annotated[bool, typer.Option("--strict", help="Treat warnings as errors.")]
Tolerance = Annotated[
    list[str] | None,
    typer.Option("--tol", help="Largest error, such as 1e-3 (strain) or deflection=1%. It selects mesh and steps."),
]
Units = Annotated[
    str | None,
    typer.Option(help="Units of numbers and plots, such as 'in, psi, lbf, lbf in, rpm'.", show_default=False),
]
Starts = Annotated[int, typer.Option(min=1, max=1000, help="Searches; all but the first start at random.")]


def jobs_of(what: str) -> Any:
    """Give the option of how many processes share the work."""
    said = f"Processes of this machine that share {what}."
    return typer.Option("-j", "--jobs", min=1, max=1024, help=said)


TrialJobs = Annotated[int, jobs_of("trials")]
OutFolder = Annotated[Path, typer.Option("-o", "--out", help="Folder for the files; it is created if missing.")]


def loaded_result(path: Path, units: str | None = None) -> Result:
    """Load a result in the plane, or one of its load cases; its numbers are in the units of its scene, or in others."""
    result = any_result(path, units)
    if not hasattr(result, "cases"):
        raise MechanismError(
            f"{path} is a result in space: report, plot, animate and export take it, other commands do not"
        )
    return cast("Result", result)


def any_result(path: Path, units: str | None = None) -> Result | SpatialResult:
    """Load a result, in the plane or in space; see `loaded_result`."""
    with loading():  # numerical libraries take a second: not for --help
        from fenics_mech.recovery import Result  # noqa: PLC0415
        from fenics_mech.recovery.spatial_result import SpatialResult  # noqa: PLC0415
        from fenics_mech.scene.base import known  # noqa: PLC0415

    if path.suffix == ".toml":
        raise MechanismError(
            f"{path} is a scene, and a result is expected: `fenics-mech run {path} -o out` writes out/result.nc"
        )
    file, case = case_in(path)
    result: Result | SpatialResult = Result.load(file)
    if result.data.attrs.get("dimension") == 3:
        refuse_in_space(**{f"the load case {case}": bool(case)})
        result = SpatialResult(result.data)
    elif case:
        result = known(cast("Result", result).cases, case, "load case", "result")
    return result if units is None else result.told_in(unit_names(units))


def refuse_in_space(**options: object) -> None:
    """Raise where options are given that a scene in space does not know; their names have "_" for "-"."""
    given = [name if " " in name else f"--{name.replace('_', '-')}" for name, value in options.items() if value]
    if given:
        fine = "" if {"--refine", "--tol"}.isdisjoint(given) else ": set mesh.elements and analysis.positions"
        raise MechanismError(f"{' and '.join(given)} cannot be used here, as the scene is in space{fine}")


def analysed(path: Path, units: str | None, strict: bool, refine: int = 0) -> Result:
    """Load a result in the plane, or analyse such a scene."""
    if path.suffix == ".nc":
        if refine:
            raise MechanismError("a result cannot be refined: analyse its scene file with --refine")
        return loaded_result(path, units)
    with loading():
        from fenics_mech.analysis import STEPS, analyse  # noqa: PLC0415

    scene = with_units(refined_scene(path, refine, strict, cases=True), units)
    with progress_bar(len(STEPS), alike=False) as step:
        return analyse(scene, step)


def case_in(path: Path) -> tuple[Path, str]:
    """Give a file, and the load case that its name tells before its ending: ``engine@idle.toml``; "" for none."""
    stem, at, case = path.stem.partition("@")
    if not at or path.exists():
        return path, ""
    return path.with_stem(stem), case


def quantity(text: str, unit: str, option: str) -> float:
    """Read a quantity with a unit, in SI; errors name the option that states it."""
    from fenics_mech.scene.units import in_unit  # noqa: PLC0415

    try:
        return float(in_unit(unit)(text))
    except ValueError as error:
        raise MechanismError(f"{option}: {error}") from error


def unit_names(units: str) -> list[str]:
    """Names of units that are written after one another, as one option."""
    from fenics_mech.scene.answer_units import named_units  # noqa: PLC0415

    names = [name.strip() for name in units.split(",")]
    named_units(names, "--units")
    return names


def answer_units(units: str | None) -> AnswerUnits:
    """Units of answers: the usual ones, but for those that an option names."""
    from fenics_mech.scene.answer_units import AnswerUnits  # noqa: PLC0415

    return AnswerUnits() if units is None else AnswerUnits.of(unit_names(units))


def refuse_own_source(file: Path, source: Path) -> None:
    """Raise where a file to be written is that which is read."""
    if file.exists() and source.exists() and file.samefile(source):
        raise MechanismError(f"{file} is the file that is read: give another for the scene with -o")


@contextmanager
def study_of(path: Path) -> Iterator[None]:
    """Name the file and the line in errors about the study that a scene file states."""
    from fenics_mech.scene.files import located  # noqa: PLC0415

    try:
        yield
    except SceneError as error:
        of_study = error.place.startswith("study") and not Path(error.place).is_file()  # such as study.csv
        raise (located(error, path) if of_study else error) from None


def with_units(scene: AnyScene, units: str | None) -> AnyScene:
    """Give a scene whose answers are told in its own units, or in others that an option names."""
    return scene if units is None else scene.changed(units=unit_names(units))


def scene_of_file(path: Path) -> Scene:
    """Load a scene file, or one load case of it; see `case_in`."""
    from fenics_mech.scene import in_case  # noqa: PLC0415  (numerical libraries take a second: not for --help)
    from fenics_mech.scene.files import load_planar  # noqa: PLC0415

    file, case = case_in(path)
    return in_case(load_planar(file), case) if case else load_planar(file)


def scene_in_space(path: Path) -> SpatialScene | None:
    """Load a scene file in space; None where it is of the plane."""
    from fenics_mech.scene.files import load_in_space  # noqa: PLC0415

    file, case = case_in(path)
    scene = load_in_space(file)
    if scene is not None:
        refuse_in_space(**{f"the load case {case}": bool(case)})
    return scene


def loaded_scene(path: Path, strict: bool, cases: bool = False) -> Scene:
    """Load a scene file, and warn of implausible numbers and unchosen assemblies; with `strict` they are errors.

    Commands that do not answer load cases, which `cases` says, warn that these are left out.
    """
    from fenics_mech.machine.start_notices import assembly_notices  # noqa: PLC0415
    from fenics_mech.scene.plausibility import implausible  # noqa: PLC0415

    scene = scene_of_file(path)
    left_out = [] if cases or not scene.cases else [f"cases: {LEFT_OUT.format(path.stem, scene.cases[0].name)}"]
    warn((*left_out, *implausible(scene), *assembly_notices(scene)), strict)
    return scene


def refined_scene(
    path: Path, refine: int, strict: bool, tolerance: list[str] | None = None, cases: bool = False
) -> Scene:
    """Load a scene that is to be analysed, with the tolerance of the command and a refined mesh; see `loaded_scene`.

    A tolerance chooses the mesh itself: with one, a refinement is an error.
    """
    from fenics_mech.scene import refined, stated_tolerance  # noqa: PLC0415

    scene = loaded_scene(path, strict, cases)
    scene = scene.changed(tolerance=stated_tolerance(tolerance)) if tolerance else scene
    if refine and scene.tolerance is not None:
        shares = " and ".join(f"{share:g}" for share in scene.tolerances.values())
        what = f"--refine states the mesh, which the tolerance of {shares} selects"
        raise MechanismError(f"{what}: leave one of them out")
    return refined(scene, refine)
