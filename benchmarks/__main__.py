"""`python -m benchmarks cost SCENE` and `python -m benchmarks scaling`, from the root of the repository."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from benchmarks.cost import measure_costs, steps_of
from benchmarks.cost_plots import cost_summary, write_cost
from benchmarks.peers import compared
from benchmarks.scaling import measure_scaling, sizes
from benchmarks.scaling_plots import scaling_summary, write_scaling
from fenics_mech._console import make_folder, out, progress_bar, tell, tell_written
from fenics_mech.cli.common import OutFolder, SceneFile
from fenics_mech.errors import MechanismError
from fenics_mech.scene import load

app = typer.Typer(help="Measure what accuracy costs.", no_args_is_help=True, add_completion=False)


@app.command()
def cost(
    scene: SceneFile,
    folder: OutFolder = Path("out"),
    peers: Annotated[bool, typer.Option("--peers", help="Also run other programs, Exudyn above all.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="A few coarse runs, to try it out.")] = False,
) -> None:
    """Measure error and time of many settings. Write cost.csv, cost.nc and a figure."""
    loaded = load(scene)
    if peers:
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


@app.command()
def scaling(
    folder: OutFolder = Path("out"),
    quick: Annotated[bool, typer.Option("--quick", help="A few small runs, to try it out.")] = False,
) -> None:
    """Measure how time and memory grow with elements, links and positions. Write scaling.csv, scaling.nc, a figure."""
    make_folder(folder)
    asked = sizes(quick)
    with progress_bar(len(asked)) as step:
        found = measure_scaling(asked, step)
    written = write_scaling(found, folder)
    out.print(scaling_summary(found))
    tell_written(written, folder)


if __name__ == "__main__":
    try:
        app()
    except MechanismError as error:
        tell(f"error: {error}")
        sys.exit(1)
