"""`fenics-mech export`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from fenics_mech._console import loading, make_folder, progress_bar, tell
from fenics_mech.cli.common import Units, any_result, quantity, scene_of_file, unit_names
from fenics_mech.errors import MechanismError

if TYPE_CHECKING:
    from fenics_mech.recovery import Result
    from fenics_mech.recovery.spatial_result import SpatialResult
    from fenics_mech.scene import Scene

OF_RESULTS, OF_SCENES, OF_MATRICES = (".pvd", ".mat", ".csv", ".xlsx"), (".py", ".mbd", ".dxf"), (".mat", ".nc")
IN_UNITS = (".csv", ".xlsx")  # the others are in SI, and drawings in mm
IN_SPACE = (".pvd", ".mat", ".csv")  # kinds of files of a result in space
OF_MODES = ("modal_coordinate", "energy_share")  # tables of the part of each mode in the motion
SOLVING = ("kinematics", "beams", "modes", "response")  # steps of solving a scene anew


def export(
    source: Annotated[Path, typer.Argument(help="Result (.nc), or scene (.toml).", show_default=False)],
    files: Annotated[
        list[Path] | None,
        typer.Argument(
            help="Files to write: .xlsx for spreadsheets, .pvd for ParaView, .mat for MATLAB and Octave, .dxf for the "
            "links' outlines, .py for Exudyn, .mbd for MBDyn, and the table of a variable by its name, such as "
            "stress_range.csv.",
            show_default=False,
        ),
    ] = None,
    every: Annotated[int, typer.Option(min=1, help="Of how many positions one goes into a .pvd or .xlsx.")] = 1,
    angle: Annotated[
        str | None,
        typer.Option(help="Drive angle of a .dxf, such as '30 deg'; otherwise the start.", show_default=False),
    ] = None,
    matrices: Annotated[
        Path | None, typer.Option(help="File (.mat or .nc) for M, C and K at all positions.", show_default=False)
    ] = None,
    units: Units = None,
) -> None:
    """Write results for spreadsheets, ParaView or MATLAB, outlines, matrices, and scenes for Exudyn or MBDyn."""
    files = files or []
    _refuse_unfit(source, files, matrices)
    names, radians = (
        [] if units is None else unit_names(units),
        None if angle is None else quantity(angle, "rad", "--angle"),
    )
    if names and (in_si := [path for path in (*files, *filter(None, [matrices])) if path.suffix not in IN_UNITS]):
        raise MechanismError(f"{in_si[0]}: --units is for tables (.csv, .xlsx); files for other programs are in SI")
    if angle is not None and not any(path.suffix == ".dxf" for path in files):
        raise MechanismError("--angle is for the outlines of the links: name a .dxf to write")
    loaded = None if source.suffix == ".toml" else any_result(source)
    if loaded is not None and not hasattr(loaded, "cases"):
        if matrices is not None:
            raise MechanismError(f"{matrices}: {source} is a result in space, and matrices are of scenes in the plane")
        _write_in_space(cast("SpatialResult", loaded), files, every, names)
        return
    result = cast("Result | None", loaded)
    scene = scene_of_file(source) if result is None else result.scene
    for path in files:
        make_folder(path.parent)
        if result is None or path.suffix in OF_SCENES:
            _write_model(scene, path, radians)
        else:
            _write_result(result, path, every, names)
        tell(f"Wrote {path}")
    if matrices is not None:
        make_folder(matrices.parent)
        _write_matrices(scene, matrices)
        tell(f"Wrote {matrices}")


def _refuse_unfit(source: Path, files: list[Path], matrices: Path | None) -> None:
    """Raise where no file is named, or one that cannot be written of a result or of a scene."""
    if not files and matrices is None:
        raise MechanismError("name a file to write, such as motion.pvd or stress_range.csv, or --matrices matrices.mat")
    if matrices is not None and matrices.suffix not in OF_MATRICES:
        raise MechanismError(f"{matrices}: matrices are written as {' or '.join(OF_MATRICES)}")
    if unknown := [path for path in files if path.suffix not in OF_RESULTS + OF_SCENES]:
        known = ".pvd (ParaView), .mat (MATLAB), .xlsx (spreadsheets), .dxf (outlines), .py (Exudyn), .mbd (MBDyn)"
        raise MechanismError(f"{unknown[0]}: exported are {known} and .csv (table of a variable, by its name)")
    if source.suffix == ".toml" and (lacking := [path for path in files if path.suffix in OF_RESULTS]):
        raise MechanismError(f"{lacking[0]}: {source} is a scene, and this file shows a result. Run the scene first")


def _write_in_space(result: SpatialResult, files: list[Path], every: int, units: list[str]) -> None:
    """Write a result in space for ParaView or MATLAB, or the variable by whose name the file is called."""
    if unfit := [path for path in files if path.suffix not in IN_SPACE]:
        known = ".pvd (ParaView), .mat (MATLAB) and .csv (table of a variable, by its name)"
        raise MechanismError(f"{unfit[0]}: of a result in space are exported {known}")
    for path in files:
        make_folder(path.parent)
        if path.suffix == ".pvd":
            result.to_vtk(path, every)
        elif path.suffix == ".mat":
            result.to_mat(path)
        else:
            result.to_table(path.stem, path, units)
        tell(f"Wrote {path}")


def _write_result(result: Result, path: Path, every: int, units: list[str]) -> None:
    """Write a result for spreadsheets, ParaView or MATLAB, or the variable by whose name the file is called."""
    from fenics_mech.views.reading import reading_of_a_file  # noqa: PLC0415

    with reading_of_a_file():
        if path.suffix == ".pvd":
            result.to_vtk(path, every)
        elif path.suffix == ".xlsx":
            from fenics_mech.views.workbook import write_workbook  # noqa: PLC0415

            write_workbook(result.told_in(units) if units else result, path, every)
        elif path.stem in OF_MODES and path.suffix == ".csv":
            _write_modes(result.scene, path, units)
        elif path.suffix == ".csv":
            result.to_table(path.stem, path, units)
        else:
            result.to_mat(path)


def _write_modes(scene: Scene, path: Path, units: list[str]) -> None:
    """Write the part of each mode in the motion of a scene, which is solved anew."""
    with loading():
        from fenics_mech.recovery.exports import write_table  # noqa: PLC0415
        from fenics_mech.studies.system_matrices import participation  # noqa: PLC0415

    with progress_bar(len(SOLVING), alike=False) as step:
        found = participation(scene, step)[path.stem]
    write_table(found, path, units)


def _write_matrices(scene: Scene, path: Path) -> None:
    """Write the matrices of a scene's equation, for MATLAB or as NetCDF."""
    with loading():
        from fenics_mech.recovery.exports import to_mat  # noqa: PLC0415
        from fenics_mech.studies.system_matrices import matrices  # noqa: PLC0415

    with progress_bar(len(SOLVING), alike=False) as step:
        found = matrices(scene, step)
    if path.suffix == ".mat":
        to_mat(found.data, path)
    else:
        found.save(path)


def _write_model(scene: Scene, path: Path, angle: float | None) -> None:
    """Write a scene as a script for Exudyn or an input file of MBDyn, or the outlines of its links at an angle."""
    if path.suffix == ".dxf":
        with loading():
            from fenics_mech.views.outlines import write_outlines  # noqa: PLC0415

        write_outlines(scene, path, angle)
        return
    with loading():
        from fenics_mech._files import write_whole  # noqa: PLC0415
        from fenics_mech.other_programs.exudyn_script import exudyn_script  # noqa: PLC0415
        from fenics_mech.other_programs.mbdyn_input import mbdyn_input  # noqa: PLC0415

    text = mbdyn_input(scene) if path.suffix == ".mbd" else exudyn_script(scene)
    write_whole(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))
