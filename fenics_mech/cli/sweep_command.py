"""`fenics-mech sweep`."""

from __future__ import annotations

import math
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fenics_mech._console import loading, make_folder, one_voice, out, progress_bar, tell_written
from fenics_mech.cli.common import (
    OutFolder,
    Refine,
    SceneFile,
    Strict,
    Units,
    refined_scene,
    scene_in_space,
    unit_names,
)
from fenics_mech.errors import MechanismError

if TYPE_CHECKING:
    from fenics_mech.scene.in_space import SpatialScene


class Where(StrEnum):
    """Where a sweep estimates errors."""

    AUTO = "auto"
    ALL = "all"
    PEAKS = "peaks"


def sweep(
    scene: SceneFile,
    over: Annotated[
        list[str],
        typer.Option(
            help="Number of the scene and its values: PATH=START:STOP:COUNT, such as drive.speed=10:60:200 or "
            "drive.speed='100 rpm:600 rpm:51'. Several make a grid.",
            show_default=False,
        ),
    ],
    folder: OutFolder = Path("out"),
    refine_peaks: Annotated[
        int,
        typer.Option(min=0, max=100_000, help="Most points to add where the strain curve is not resolved."),
    ] = 0,
    member: Annotated[
        str | None,
        typer.Option(help="Member in the waterfall plot and in maps.", show_default="the one with the largest strain"),
    ] = None,
    s: Annotated[float, typer.Option(min=0, max=1, help="Place on the members where harmonics are kept.")] = 0.5,
    fibre: Annotated[str, typer.Option(help="Side of the members for these harmonics, + or -.")] = "+",
    harmonics: Annotated[int, typer.Option(min=1, max=10_000, help="Number of harmonics that are kept.")] = 20,
    jobs: Annotated[
        int, typer.Option("-j", "--jobs", min=1, max=1024, help="Processes of this machine that share the points.")
    ] = 1,
    estimates: Annotated[
        Where,
        typer.Option(
            help="Where errors are estimated: at all points, or at the peaks of the strains and the ends of the "
            "ranges. auto takes peaks for more than 24 points, where nothing is chosen by estimates."
        ),
    ] = Where.AUTO,
    refine: Refine = 0,
    units: Units = None,
    strict: Strict = False,
) -> None:
    """Analyse a scene at many values of speed, damping or any other number: write sweep.nc, sweep.html and plots.

    A sweep that was interrupted goes on when it is started again with the same folder. Under mpirun the processes
    share the points.
    """
    with loading():
        from fenics_mech.studies.gauge import Gauge  # noqa: PLC0415
        from fenics_mech.studies.sweep import run_sweep  # noqa: PLC0415
        from fenics_mech.studies.sweep_axes import parse_axes  # noqa: PLC0415
        from fenics_mech.views.page.sweep_page import can_show, sweep_report  # noqa: PLC0415
        from fenics_mech.views.sweep_plots import check_member, plot_sweep  # noqa: PLC0415
        from fenics_mech.views.sweep_summary import sweep_summary  # noqa: PLC0415

    if (in_space := scene_in_space(scene)) is not None:
        _in_space(in_space, over, folder, jobs)
        return
    first, named = one_voice(), None if units is None else unit_names(units)
    loaded = refined_scene(scene, refine, strict, cases=True)
    axes, gauge = parse_axes(loaded, over), Gauge(s, fibre, harmonics)
    check_member(list(loaded.members()), member)
    with progress_bar(math.prod(len(axis.values) for axis in axes) + refine_peaks) as step:
        found = run_sweep(
            loaded,
            axes,
            folder,
            gauge=gauge,
            refine_peaks=refine_peaks,
            jobs=jobs,
            estimates=estimates.value,
            progress=lambda done, points: step(f"point {done + 1} of {points}"),
        )
    if first:
        found = found if named is None else found.told_in(named)
        page = [sweep_report(found, folder / "sweep.html")] if can_show(found) else []
        plots = plot_sweep(found, folder, member)
        out.print(sweep_summary(found))
        tell_written([Path("sweep.nc"), Path("timings.csv"), *page, *plots], folder)
        if (found.data["error"] != "").all():
            raise MechanismError("every point of the sweep failed; the lines above and sweep.nc say why")
        if strict and (warned := int((found.data["warnings"] != "").sum())):
            raise MechanismError(f"{warned} points warn, and warnings are errors with --strict: sweep.nc holds them")


def _in_space(scene: SpatialScene, over: list[str], folder: Path, jobs: int) -> None:
    """Sweep a scene in space: write sweep.nc, and a plot where one number varies."""
    with loading():
        from fenics_mech._files import write_whole  # noqa: PLC0415
        from fenics_mech.studies.spatial_sweep import parsed_axis, sweep_in_space  # noqa: PLC0415
        from fenics_mech.views.space.sweep import plot_sweep_in_space, told_sweep  # noqa: PLC0415

    values = dict(parsed_axis(scene, text) for text in over)
    make_folder(folder)
    with progress_bar(math.prod(map(len, values.values()))) as step:
        found = sweep_in_space(
            scene, values, jobs=jobs, progress=lambda done, points: step(f"point {done} of {points}")
        )
    write_whole(folder / "sweep.nc", lambda temporary: found.to_netcdf(temporary, engine="h5netcdf"))
    plots = plot_sweep_in_space(found, folder)
    out.print(told_sweep(found))
    tell_written([Path("sweep.nc"), *plots], folder)
    if (found["error"] != "").all():
        raise MechanismError("every point of the sweep failed; the lines above and sweep.nc say why")
