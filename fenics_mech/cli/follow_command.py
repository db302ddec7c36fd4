"""`fenics-mech follow`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import loading, make_folder, out, progress_bar, tell_written
from fenics_mech.cli.common import OutFolder, Refine, SceneFile, Strict, Units, loaded_scene, with_units


def follow(
    scene: SceneFile,
    over: Annotated[
        str,
        typer.Option(
            help="Number of the scene and its range: PATH=START:STOP, such as drive.speed=20:60 or "
            "drive.speed='200 rpm:600 rpm'.",
            show_default=False,
        ),
    ],
    folder: OutFolder = Path("out"),
    points: Annotated[int, typer.Option(min=1, max=100_000, help="Smallest number of points over the range.")] = 40,
    most_points: Annotated[int, typer.Option(min=2, max=1_000_000, help="Give up after this many points.")] = 2000,
    refine: Refine = 0,
    units: Units = None,
    strict: Strict = False,
) -> None:
    """Follow the steady state along speed, damping or any other number, through folds: write branch.nc and plots.

    It finds stable and unstable motions, also several at one value.
    """
    with loading():
        from fenics_mech.scene import refined  # noqa: PLC0415
        from fenics_mech.studies.follow import follow as follow_branch  # noqa: PLC0415
        from fenics_mech.studies.sweep_axes import parse_range  # noqa: PLC0415
        from fenics_mech.views.branch_plots import branch_summary, plot_branch  # noqa: PLC0415

    loaded = with_units(refined(loaded_scene(scene, strict, cases=True), refine), units)
    path, ends = parse_range(loaded, over)
    make_folder(folder)
    with progress_bar(points) as step:
        found = follow_branch(
            loaded,
            path,
            ends,
            points=points,
            most_points=most_points,
            progress=lambda value: step(f"{path} = {value:.6g}"),
            keep=lambda branch: branch.save(folder / "branch.nc"),
        )
    written = [found.save(folder / "branch.nc"), *plot_branch(found, folder)]
    out.print(branch_summary(found))
    tell_written(written, folder)
