"""`fenics-mech compare`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fenics_mech._console import loading, make_folder, out, progress_bar, tell, tell_written
from fenics_mech.cli.common import OutFolder, Units, loaded_result, loaded_scene, with_units
from fenics_mech.errors import MechanismError

if TYPE_CHECKING:
    from fenics_mech.recovery import Result
    from fenics_mech.scene import Scene
    from fenics_mech.studies.compare import Curves, Quantity

PEAK, MID_SPAN = "peak", "mid-span"


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
    fibre: Annotated[str, typer.Option(help="Its side, and that of --at, + or -.")] = "+",
    at: Annotated[
        str | None,
        typer.Option(
            help="Where members are compared: peak (of the reference), mid-span, or a share 0..1 of the length. "
            "Without it at the peak, and one scene alone at mid-span, as in the figures of the dissertation.",
            show_default=False,
        ),
    ] = None,
    units: Units = None,
) -> None:
    """Compare curves over the cycle: difference, root mean square, phase shift. Write compare.csv and plots.

    The largest difference anywhere along each member is told too. A measurement that a scene names is compared at its
    place there, without further options.
    """
    with loading():
        from fenics_mech.analysis import analyse  # noqa: PLC0415
        from fenics_mech.studies.compare import (  # noqa: PLC0415
            Quantity,
            by_theories,
            curves_of_result,
            with_vibration,
        )
        from fenics_mech.studies.compare import compare as compared  # noqa: PLC0415
        from fenics_mech.views.comparison import comparison_table, plot_comparison, write_comparison  # noqa: PLC0415
        from fenics_mech.views.reading import reading_of_a_file  # noqa: PLC0415

    _check_files(files, fibre)
    place = _place(at or (MID_SPAN if len(files) == 1 and files[0].suffix == ".toml" else PEAK), fibre)
    gauge = None if member is None else Quantity("strain", member, s, fibre)
    scenes, sources = [], []
    with progress_bar(3 * sum(path.suffix == ".toml" for path in files) or 1) as step:
        for path in files:
            if path.suffix == ".nc":
                result = loaded_result(path)
                scenes.append(result.scene)
                with reading_of_a_file():
                    sources.append(curves_of_result(result, _with_case(_label(path, files), result), place))
            elif path.suffix == ".toml":
                scenes.append(loaded_scene(path, strict=False, cases=True))
                if len(files) == 1:
                    sources += by_theories(scenes[-1], step, place)
                else:
                    result = analyse(scenes[-1])
                    sources.append(curves_of_result(result, _with_case(_label(path, files), result), place))
        measured, absent = _measured(files, scenes, gauge)
        with reading_of_a_file():
            sources += [with_vibration(one, sources[0]) for one in measured]
    for line in absent:
        tell(line)
    if len(sources) < 2:
        raise MechanismError("there is nothing to compare with: name two files or more, or one scene")
    with reading_of_a_file():
        data = compared(sources)
    told = with_units(scenes[0], units)
    _tell_speeds(files, scenes, told)
    make_folder(folder)
    written = [write_comparison(data, folder / "compare.csv"), *plot_comparison(sources, data, folder, told)]
    out.print(comparison_table(sources, data, told))
    tell_written(written, folder)


def _tell_speeds(files: list[Path], scenes: list[Scene], told: Scene) -> None:
    """Say so where the runs differ in speed."""
    from fenics_mech.views.comparison import differing_speeds  # noqa: PLC0415

    named = dict(zip((_label(path, files) for path in files if path.suffix != ".csv"), scenes))
    if differing := differing_speeds(named, told):
        tell(differing)


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
    """Give the name of a file, with as many of its folders as set it apart from the others."""
    alike = [other for other in files if other != path and other.name == path.name]
    if not alike:
        return path.stem
    parts = path.parts
    short = (Path(*parts[-count:]) for count in range(2, len(parts)))
    return str(
        next((one for one in short if not any(other.parts[-len(one.parts) :] == one.parts for other in alike)), path)
    )


def _with_case(label: str, result: Result) -> str:
    """Name a result by its label, and of several load cases the governing one, whose curves it has."""
    return f"{label} ({result.case})" if result.cases else label


def _place(at: str, fibre: str) -> tuple[float, str] | None:
    """Read where members are compared; None is the place of the peak."""
    if at == PEAK:
        return None
    try:
        s = 0.5 if at == MID_SPAN else float(at)
    except ValueError:
        s = -1.0
    if not 0 <= s <= 1:
        raise MechanismError(f"--at is {PEAK}, {MID_SPAN} or a share of the length from 0 to 1, found {at!r}")
    return s, fibre


def _measured(files: list[Path], scenes: list[Scene], gauge: Quantity | None) -> tuple[list[Curves], list[str]]:
    """Read measurements: those that are named, at the gauge or where a scene places them, or those of the scenes.

    Those of the scenes whose member the reference lacks are left out, with a line for each that says so.
    """
    from fenics_mech.recovery.measured import read_measurement  # noqa: PLC0415
    from fenics_mech.studies.compare import Quantity, curves_of_measurement  # noqa: PLC0415

    stated = {
        measurement.file.resolve(): Quantity("strain", measurement.member, measurement.s, measurement.fibre)
        for scene in scenes
        for measurement in scene.measurements
    }
    members = scenes[0].members()
    named = {path.resolve(): path for path in files if path.suffix == ".csv"}
    for path in named.values():
        place = stated.get(path.resolve(), gauge)
        if place is None:
            raise MechanismError(f"{path}: no scene says where this was measured: add --member, --s and --fibre")
        if place.part not in members:
            raise MechanismError(f"{path}: the reference has no member {place.part!r}; it has {', '.join(members)}")
        stated[path.resolve()] = place
    wanted = named if named else {path: path for path in stated}
    absent = [
        f"{path}: left out, the reference has no member {stated[key].part!r}; it has {', '.join(members)}"
        for key, path in wanted.items()
        if stated[key].part not in members
    ]
    measured = [
        curves_of_measurement(*read_measurement(path), stated[key], f"measured ({path.stem})")
        for key, path in wanted.items()
        if stated[key].part in members
    ]
    return measured, absent
