"""`fenics-mech cost`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import loading, make_folder, out, progress_bar, tell_written
from fenics_mech.cli.common import OutFolder, SceneFile


def cost(
    scene: SceneFile,
    folder: OutFolder = Path("out"),
    peers: Annotated[bool, typer.Option("--peers", help="Also run other programs, Exudyn above all.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="A few coarse runs, to try it out.")] = False,
) -> None:
    """Measure what accuracy costs: error and time of many settings. Write cost.csv, cost.nc and a figure."""
    with loading():
        from fenics_mech.scene import load  # noqa: PLC0415
        from fenics_mech.studies.cost import measure_costs, steps_of  # noqa: PLC0415
        from fenics_mech.views.cost_plots import cost_summary, write_cost  # noqa: PLC0415

    loaded = load(scene)
    if peers:
        from fenics_mech.studies.peers import compared  # noqa: PLC0415

        compared.require_ready(loaded, quick)
    make_folder(folder)
    with progress_bar(steps_of(loaded, quick)) as step:
        found = {"cost": measure_costs(loaded, quick=quick, progress=step)}
    if peers:
        with progress_bar(compared.steps_of(loaded, quick)) as step:
            found["cost_peers"] = compared.compare_peers(loaded, quick=quick, progress=step)
    for name, each in found.items():
        written = write_cost(each, folder, name)
        out.print(cost_summary(each))
        tell_written(written, folder)
