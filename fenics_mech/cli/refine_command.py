"""`fenics-mech refine`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import loading, make_folder, out, progress_bar, tell_written
from fenics_mech.cli.common import OutFolder, SceneFile, Strict, Units, loaded_scene, with_units


def refine(
    scene: SceneFile,
    folder: OutFolder = Path("out"),
    levels: Annotated[int, typer.Option(min=3, max=8, help="Meshes, each with halved elements; and step lengths.")] = 3,
    units: Units = None,
    strict: Strict = False,
) -> None:
    """Refine mesh and steps: strain, stress and frequency at each level, observed order, extrapolated answer.

    Writes refine.nc, refine.csv and plots.
    """
    with loading():
        from fenics_mech.studies.refine import refine as refine_scene  # noqa: PLC0415
        from fenics_mech.views.refine_views import plot_refinement, refinement_table, write_refinement  # noqa: PLC0415

    loaded = with_units(loaded_scene(scene, strict, cases=True), units)
    make_folder(folder)
    with progress_bar(2 * levels - 1) as step:
        found = refine_scene(loaded, levels, step)
    written = [
        found.save(folder / "refine.nc"),
        write_refinement(found, folder / "refine.csv"),
        *plot_refinement(found, folder),
    ]
    out.print(refinement_table(found))
    tell_written(written, folder)
