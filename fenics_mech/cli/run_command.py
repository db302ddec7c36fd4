"""`fenics-mech run`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fenics_mech._console import loading, make_folder, one_voice, out, print_json, progress_bar, tell, warn
from fenics_mech.cli.common import (
    OutFolder,
    Refine,
    SceneFile,
    Strict,
    Tolerance,
    Units,
    jobs_of,
    refined_scene,
    refuse_in_space,
    scene_in_space,
    with_units,
)
from fenics_mech.errors import MechanismError, printable

if TYPE_CHECKING:
    from fenics_mech.recovery import Result
    from fenics_mech.recovery.spatial_result import SpatialResult
    from fenics_mech.scene import Scene
    from fenics_mech.scene.in_space import SpatialScene


def run(
    scene: SceneFile,
    folder: OutFolder = Path("out"),
    plots: Annotated[bool, typer.Option(help="Write plots.")] = True,
    report: Annotated[bool, typer.Option(help="Write report.html, a page for a browser.")] = True,
    csv: Annotated[bool, typer.Option(help="Also write every variable as a CSV table.")] = False,
    refine: Refine = 0,
    tolerance: Tolerance = None,
    strict: Strict = False,
    jobs: Annotated[int, jobs_of("load cases")] = 1,
    details: Annotated[bool, typer.Option("--details", help="Print all that is known, not a summary only.")] = False,
    units: Units = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the key figures as JSON in SI instead.")] = False,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing but warnings and errors.")] = False,
) -> None:
    """Analyse a scene: write result.nc, warnings.txt, report.html and plots, print a summary.

    With --strict a warning ends it with an error: about numbers of the scene before anything is written, about the
    result, such as a tolerance that is not met, after all is written.

    A scene with load cases is answered in all of them, and what governs is named.

    Under mpirun the processes share the positions.
    """
    if as_json and (quiet or units or details):
        raise MechanismError("--json prints key figures in SI: leave --quiet, --units and --details out")
    with loading():  # dolfinx and matplotlib take a second: not for --help
        from fenics_mech._ranks import shared  # noqa: PLC0415
        from fenics_mech.analysis import STEPS, analyse  # noqa: PLC0415
        from fenics_mech.scene import Scene  # noqa: PLC0415
        from fenics_mech.scene.plausibility import implausible  # noqa: PLC0415
        from fenics_mech.studies.case_runs import analyse_cases  # noqa: PLC0415
        from fenics_mech.views.key_figures import key_figures  # noqa: PLC0415
        from fenics_mech.views.result_figures import plot_all  # noqa: PLC0415
        from fenics_mech.views.summary import summary  # noqa: PLC0415

    def prepared() -> Scene | SpatialScene:
        if (spatial := scene_in_space(scene)) is not None:
            refuse_in_space(refine=refine, tol=tolerance, jobs=jobs > 1)
            loaded: Scene | SpatialScene = with_units(spatial, units)
        else:
            loaded = with_units(refined_scene(scene, refine, strict, tolerance, cases=True), units)
        make_folder(folder)
        return loaded

    def answered(step: Callable[[str], None]) -> Result | SpatialResult:
        if isinstance(loaded, Scene):
            return analyse_cases(loaded, jobs, step)
        step("response")
        return analyse(loaded)

    first = one_voice()
    loaded = shared(prepared)
    steps = len(STEPS) * max(1, len(loaded.cases)) if isinstance(loaded, Scene) else 1
    with progress_bar(steps + 1 + report + plots + csv, alike=False, quiet=quiet) as step:
        result = shared(lambda: answered(step))
        if not first:
            return
        step("writing result.nc")
        written: dict[str, list[Path]] = {"": [result.save(folder / "result.nc"), _write_warnings(result, folder)]}
        if csv:
            step("writing tables")
            written["tables"] = result.to_csv(folder)
        failed: Exception | None = None
        try:
            if report:
                step("report")
                written |= _write_report(result, folder, written[""])
            if plots:
                step("plots")
                with loading():  # the many parts of figures stay to the end of the command, which is near
                    written["plots"] = plot_all(result, folder)
        except (MechanismError, MemoryError, OSError) as error:  # what was computed is told first
            failed = error
    if as_json:
        files = [str(path) for paths in written.values() for path in paths]
        print_json(key_figures(result) | {"files": files})
    elif not quiet:
        out.print(summary(result, details))
        tell(_told(written, folder))
    if failed is not None:
        raise failed
    if strict or quiet:  # else the summary tells them
        known = implausible(loaded) if isinstance(loaded, Scene) else ()
        warn([text for text in result.warnings if text not in known], strict)


def _write_warnings(result: Result | SpatialResult, folder: Path) -> Path:
    """Write warnings.txt, a warning a line; without any it is empty, so that none of an earlier run is left."""
    from fenics_mech._files import write_whole  # noqa: PLC0415
    from fenics_mech.recovery import Result  # noqa: PLC0415
    from fenics_mech.views.judgements import warnings_of  # noqa: PLC0415

    said = warnings_of(result) if isinstance(result, Result) else result.warnings
    path, text = folder / "warnings.txt", "".join(f"{printable(line)}\n" for line in said)
    write_whole(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))
    return path


def _write_report(result: Result | SpatialResult, folder: Path, files: list[Path]) -> dict[str, list[Path]]:
    """Write report.html, and beside it a page of each other load case."""
    from fenics_mech.recovery import Result  # noqa: PLC0415
    from fenics_mech.views.page.report import pages_of_cases, report  # noqa: PLC0415

    page = report(result, folder / "report.html")
    others = [*pages_of_cases(result, page).values()] if isinstance(result, Result) else []
    return {"": [*files, page], "page of the other case" if len(others) == 1 else "pages of other cases": others}


def _told(written: dict[str, list[Path]], folder: Path) -> str:
    """Say what was written: names of single files, and how many tables and plots."""
    parts = [path.name for path in written.pop("")]
    parts += [f"{len(paths)} {kind}" for kind, paths in written.items() if paths]
    return f"Wrote {', '.join(parts[:-1])}{' and ' if len(parts) > 1 else ''}{parts[-1]} to {folder}"
