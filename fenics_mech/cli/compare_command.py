"""`fenics-mech compare`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fenics_mech._console import make_folder, out, progress_bar, tell_written
from fenics_mech.cli.common import OutFolder, Units, loaded_scene, with_units
from fenics_mech.errors import MechanismError

if TYPE_CHECKING:
    from fenics_mech.scene import Scene
    from fenics_mech.studies.compare import Curves, Quantity


def compare(
    files: Annotated[
        list[Path],
        typer.Argument(
            help="Results (.nc), measured strains (.csv) and scenes (.toml), the reference first. One scene alone is "
            "analysed as rigid links, by the linear equation (5.1), and with all effects.",
            show_default=False,
        ),
    ],
    folder: OutFolder = Path("out"),
    member: Annotated[str | None, typer.Option(help="Member on which a .csv was measured.", show_default=False)] = None,
    s: Annotated[float, typer.Option(min=0, max=1, help="Place of that gauge along the member.")] = 0.5,
    fibre: Annotated[str, typer.Option(help="Its side, + or -.")] = "+",
    units: Units = None,
) -> None:
    """Compare curves over the cycle: difference, root mean square, phase shift. Write compare.csv and plots.

    A measurement that a scene names is compared at its place there, without further options.
    """
    from fenics_mech.recovery import Result  # noqa: PLC0415
    from fenics_mech.studies.compare import Quantity, by_theories, curves_of_result, with_vibration  # noqa: PLC0415
    from fenics_mech.studies.compare import compare as compared  # noqa: PLC0415
    from fenics_mech.views.comparison import comparison_table, plot_comparison, write_comparison  # noqa: PLC0415
    from fenics_mech.views.reading import reading_of_a_file  # noqa: PLC0415

    _check_files(files, fibre)
    gauge = None if member is None else Quantity("strain", member, s, fibre)
    scenes, sources = [], []
    with progress_bar(3 * sum(path.suffix == ".toml" for path in files) or 1) as step:
        for path in files:
            if path.suffix == ".nc":
                result = Result.load(path)
                scenes.append(result.scene)
                sources.append(curves_of_result(result, _label(path, files)))
            elif path.suffix == ".toml":
                scenes.append(loaded_scene(path, strict=False))
                sources += by_theories(scenes[-1], step) if len(files) == 1 else [_analysed(scenes[-1], path, files)]
        sources += [with_vibration(one, sources[0]) for one in _measured(files, scenes, gauge)]
    if len(sources) < 2:
        raise MechanismError("there is nothing to compare with: name two files or more, or one scene")
    with reading_of_a_file():
        data = compared(sources)
    told = with_units(scenes[0], units).answer_units
    make_folder(folder)
    written = [write_comparison(data, folder / "compare.csv"), *plot_comparison(sources, data, folder, told)]
    out.print(comparison_table(sources, data, told))
    tell_written(written, folder)


def _check_files(files: list[Path], fibre: str) -> None:
    """Raise where a file cannot be compared, or the first is no result."""
    for path in files:
        if path.suffix not in (".nc", ".csv", ".toml"):
            raise MechanismError(f"{path}: compared are results (.nc), measured strains (.csv) and scenes (.toml)")
    if files[0].suffix == ".csv":
        raise MechanismError(f"{files[0]}: the reference, which stands first, must be a result or a scene")
    if fibre not in ("+", "-"):
        raise MechanismError(f"--fibre is + or -, found {fibre!r}")


def _label(path: Path, files: list[Path]) -> str:
    """Give the name of a file, with its folder where names are alike."""
    return path.stem if [other.name for other in files].count(path.name) == 1 else str(path)


def _analysed(scene: Scene, path: Path, files: list[Path]) -> Curves:
    """Analyse a scene as it is."""
    from fenics_mech.analysis import analyse  # noqa: PLC0415
    from fenics_mech.studies.compare import curves_of_result  # noqa: PLC0415

    return curves_of_result(analyse(scene), _label(path, files))


def _measured(files: list[Path], scenes: list[Scene], gauge: Quantity | None) -> list[Curves]:
    """Read measurements: those that are named, at the gauge or where a scene places them, or those of the scenes."""
    from fenics_mech.recovery.measured import read_measurement  # noqa: PLC0415
    from fenics_mech.studies.compare import Quantity, curves_of_measurement  # noqa: PLC0415

    stated = {
        measurement.file.resolve(): Quantity("strain", measurement.member, measurement.s, measurement.fibre)
        for scene in scenes
        for measurement in scene.measurements
    }
    named = {path.resolve(): path for path in files if path.suffix == ".csv"}
    for path in named.values():
        place = stated.get(path.resolve(), gauge)
        if place is None:
            raise MechanismError(f"{path}: no scene says where this was measured: add --member, --s and --fibre")
        if place.part not in scenes[0].members():
            known = ", ".join(scenes[0].members())
            raise MechanismError(f"{path}: the reference has no member {place.part!r}; it has {known}")
        stated[path.resolve()] = place
    wanted = named if named else {path: path for path in stated}
    return [
        curves_of_measurement(*read_measurement(path), stated[key], f"measured ({path.stem})")
        for key, path in wanted.items()
    ]
