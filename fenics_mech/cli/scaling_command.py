"""`fenics-mech scaling`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import loading, make_folder, out, progress_bar, tell_written
from fenics_mech.cli.common import OutFolder


def scaling(
    folder: OutFolder = Path("out"),
    quick: Annotated[bool, typer.Option("--quick", help="A few small runs, to try it out.")] = False,
) -> None:
    """Measure how time and memory grow with elements, links and positions. Write scaling.csv, scaling.nc, a figure."""
    with loading():
        from fenics_mech.studies.scaling import measure_scaling, sizes  # noqa: PLC0415
        from fenics_mech.views.scaling_plots import scaling_summary, write_scaling  # noqa: PLC0415

    make_folder(folder)
    asked = sizes(quick)
    with progress_bar(len(asked)) as step:
        found = measure_scaling(asked, step)
    written = write_scaling(found, folder)
    out.print(scaling_summary(found))
    tell_written(written, folder)
