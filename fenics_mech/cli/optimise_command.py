"""`fenics-mech optimise`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import loading, one_voice, out, progress_bar, tell_written, warn
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
from fenics_mech.errors import MechanismError


def optimise(
    scene: SceneFile,
    method: Annotated[
        str | None,
        typer.Option(
            help="slsqp, trust-constr, least-squares, differential-evolution, or nsga2 for several aims.",
            show_default="by the study",
        ),
    ] = None,
    starts: Starts = 1,
    steps: Annotated[int, typer.Option(min=1, max=10_000, help="Most steps, or generations, of a search.")] = 50,
    population: Annotated[int, typer.Option(min=4, max=10_000, help="Members of a population.")] = 20,
    seed: Annotated[int, typer.Option(min=0, help="Seed of random numbers.")] = 0,
    jobs: TrialJobs = 1,
    folder: OutFolder = Path("out"),
    units: Units = None,
    strict: Strict = False,
) -> None:
    """Search for the best values of the variables in the study of the scene: write best.toml, history.csv and plots.

    Trials that are finished are kept in the folder. A search that was interrupted goes on when it is started again.
    Under mpirun the processes share the trials.
    """
    with loading():
        from fenics_mech.scene.plausibility import implausible  # noqa: PLC0415
        from fenics_mech.studies.design.methods import Search  # noqa: PLC0415
        from fenics_mech.studies.design.optimise import optimise as search  # noqa: PLC0415
        from fenics_mech.studies.design.trial import Trial  # noqa: PLC0415
        from fenics_mech.views.judgements import warnings_of  # noqa: PLC0415
        from fenics_mech.views.study_views import (  # noqa: PLC0415
            best_so_far,
            missed,
            plot_study,
            study_summary,
        )

    first, loaded = one_voice(), with_units(loaded_scene(scene, strict, cases=True), units)
    with study_of(scene), progress_bar(steps * starts, alike=False) as step:

        def told(count: int, trial: Trial, best: Trial | None) -> None:
            step(f"trial {count}{best_so_far(loaded, best)}")

        found = search(
            loaded,
            folder,
            method=method,
            starts=starts,
            search=Search(steps, population, seed),
            jobs=jobs,
            like=scene,
            progress=told,
        )
    if not first:
        return
    plots = plot_study(found, folder)
    out.print(study_summary(found))
    front = [Path("front.csv")] if found.problem.trades_off else []
    tell_written([Path("best.toml"), Path("history.csv"), *front, Path("result.nc"), *plots], folder)
    warn([text for text in warnings_of(found.result) if text not in implausible(loaded)], strict)
    if not found.within_limits:
        raise MechanismError(f"no trial keeps all limits: {missed(found)}; best.toml is the nearest")
