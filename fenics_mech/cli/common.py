"""What several commands have in common: their arguments and options, and how a scene file is loaded."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fenics_mech._console import warn
from fenics_mech.errors import MechanismError, SceneError

if TYPE_CHECKING:
    from fenics_mech.recovery import Result
    from fenics_mech.scene import Scene
    from fenics_mech.scene.answer_units import AnswerUnits
    from fenics_mech.scene.in_space import SpatialScene

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
TrialJobs = Annotated[
    int, typer.Option("-j", "--jobs", min=1, max=1024, help="Processes of this machine that share trials.")
]
OutFolder = Annotated[Path, typer.Option("-o", "--out", help="Folder for the files; it is created if missing.")]


def loaded_result(path: Path, units: str | None = None) -> Result:
    """Load a result file; its numbers are told in the units of its scene, or in others."""
    from fenics_mech.recovery import Result  # noqa: PLC0415  (numerical libraries take a second: not for --help)

    refuse_scene(path)
    file, case = case_in(path)
    result = of_case(Result.load(file), case)
    return result if units is None else result.told_in(unit_names(units))


def case_in(path: Path) -> tuple[Path, str]:
    """Give a file, and the load case that its name tells before its ending: ``engine@idle.toml``; "" for none."""
    stem, at, case = path.stem.partition("@")
    if not at or path.exists():
        return path, ""
    return path.with_stem(stem), case


def of_case(result: Result, case: str) -> Result:
    """Give the result of one of its load cases; itself where none is named."""
    from fenics_mech.scene.base import check_known  # noqa: PLC0415

    if case:
        check_known(case, result.cases, "load case", "result")
        return result.cases[case]
    return result


def refuse_scene(path: Path) -> None:
    """Raise where a scene is named in place of a result."""
    if path.suffix == ".toml":
        raise MechanismError(
            f"{path} is a scene, and a result is expected: `fenics-mech run {path} -o out` writes out/result.nc"
        )


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


def with_units(scene: Scene, units: str | None) -> Scene:
    """Give a scene whose answers are told in its own units, or in others that an option names."""
    return scene if units is None else scene.changed(units=unit_names(units))


def scene_of_file(path: Path) -> Scene:
    """Load a scene file, or one load case of it; see `case_in`."""
    from fenics_mech.scene import in_case  # noqa: PLC0415  (numerical libraries take a second: not for --help)
    from fenics_mech.scene.files import load_planar  # noqa: PLC0415

    file, case = case_in(path)
    return in_case(load_planar(file), case) if case else load_planar(file)


def scene_in_space(path: Path) -> SpatialScene | None:
    """Load a scene in space; None where the file is of the plane, or names a load case."""
    from fenics_mech.scene.files import load_in_space  # noqa: PLC0415

    return load_in_space(path) if path.exists() and path.suffix == ".toml" else None


def loaded_scene(path: Path, strict: bool, cases: bool = False) -> Scene:
    """Load a scene file, and warn of implausible numbers and unchosen assemblies; with `strict` they are errors.

    Commands that do not answer load cases, which `cases` says, warn that these are left out.
    """
    from fenics_mech.kinematics import assembly_notices  # noqa: PLC0415
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
