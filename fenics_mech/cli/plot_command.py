"""`fenics-mech plot`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import loading, make_folder, tell_written
from fenics_mech.cli.common import OutFolder, Units, any_result


def plot(
    result: Annotated[Path, typer.Argument(help="Result file (result.nc).", show_default=False)],
    folder: OutFolder = Path("plots"),
    only: Annotated[
        list[str] | None,
        typer.Option(
            help="Plot to make: strain, strain_map, deflection, section_forces, joint_forces, force_paths, "
            "point_paths, spectrum or frequencies; in space stress, section_moments, deflection, joint_forces, "
            "drive_torque, frequencies or views."
        ),
    ] = None,
    ending: Annotated[str, typer.Option("--as", help="Kind of the files: png, pdf or svg.")] = "png",
    units: Units = None,
) -> None:
    """Draw a saved result: strains where they are largest, maps, deflections, forces, spectrum, frequencies."""
    with loading():
        from fenics_mech.errors import ViewError  # noqa: PLC0415  (numerical libraries take a second: not for --help)
        from fenics_mech.views.result_figures import plot_all  # noqa: PLC0415

    loaded = any_result(result, units)
    make_folder(folder)
    if not (written := plot_all(loaded, folder, only or (), f".{ending.lower().lstrip('.')}")):
        if loaded.data.sizes["theta"] == 1:
            raise ViewError("there is nothing to plot over one position: `fenics-mech report` shows it")
        raise ViewError(f"the result has nothing for {' and '.join(only or ())}: leave --only out to draw what it has")
    tell_written(written, folder)
