"""`fenics-mech identify`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import loading, one_voice, out, progress_bar, tell_written
from fenics_mech.cli.common import (
    OutFolder,
    SceneFile,
    Starts,
    Strict,
    TrialJobs,
    Units,
    loaded_scene,
    study_of,
    with_units,
)

EXPECTED = 12  # trials of one search, for the progress


def identify(
    scene: SceneFile,
    data: Annotated[
        list[Path] | None,
        typer.Argument(help="Measured curves or numbers (CSV).", show_default="the scene's measurements"),
    ] = None,
    starts: Starts = 1,
    seed: Annotated[int, typer.Option(min=0, help="Seed of their starts.")] = 0,
    jobs: TrialJobs = 1,
    folder: OutFolder = Path("out"),
    units: Units = None,
    strict: Strict = False,
) -> None:
    """Find the variables in the study of the scene from measured data, and say how well the data tell them.

    Writes identified.toml, identified.csv and plots of prediction and measurement. Finished trials are kept in the
    folder, and not run again. Under mpirun the processes share the trials.
    """
    with loading():
        from fenics_mech.studies.design.identify import identify as search  # noqa: PLC0415
        from fenics_mech.studies.design.trial import Trial  # noqa: PLC0415
        from fenics_mech.views.identify_views import identify_summary, plot_identified  # noqa: PLC0415

    first, loaded = one_voice(), with_units(loaded_scene(scene, strict, cases=True), units)
    with study_of(scene), progress_bar(EXPECTED * starts, alike=False) as step:

        def told(count: int, trial: Trial, best: Trial | None) -> None:
            step(f"trial {count}")

        found = search(loaded, data or (), folder, starts=starts, seed=seed, jobs=jobs, like=scene, progress=told)
    if not first:
        return
    plots = plot_identified(found, folder)
    out.print(identify_summary(found))
    tell_written([Path("identified.toml"), Path("identified.csv"), *plots], folder)
