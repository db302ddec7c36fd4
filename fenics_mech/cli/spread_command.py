"""`fenics-mech spread`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import loading, one_voice, out, progress_bar, tell_written
from fenics_mech.cli.common import OutFolder, SceneFile, Strict, Units, jobs_of, loaded_scene, study_of, with_units


def spread(
    scene: SceneFile,
    samples: Annotated[
        int, typer.Option("-n", "--samples", min=0, max=1_000_000, help="Samples; 0 for the linear estimate alone.")
    ] = 128,
    sampling: Annotated[str, typer.Option(help="sobol or latin-hypercube.")] = "sobol",
    indices: Annotated[
        bool, typer.Option("--indices", help="Find Sobol indices: samples times (variables + 2) analyses.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of random numbers.")] = 0,
    jobs: Annotated[int, jobs_of("samples")] = 1,
    folder: OutFolder = Path("out"),
    units: Units = None,
    strict: Strict = False,
) -> None:
    """Find how results scatter with tolerances and other scatter in the study of the scene.

    Writes spread.csv, samples.csv, polynomials.csv and plots. Finished samples are kept in the folder, and are not run
    again. Under mpirun the processes share the samples.
    """
    with loading():
        from fenics_mech.studies.design.spread import spread as scattered  # noqa: PLC0415
        from fenics_mech.views.spread_views import plot_spread, spread_summary  # noqa: PLC0415

    first, loaded = one_voice(), with_units(loaded_scene(scene, strict, cases=True), units)
    width = 1 if not indices or loaded.study is None else len(loaded.study.scatter) + 2
    with study_of(scene), progress_bar(max(samples * width, 1)) as step:
        found = scattered(
            loaded,
            folder,
            samples=samples,
            sampling=sampling,
            indices=indices,
            seed=seed,
            jobs=jobs,
            progress=lambda count: step(f"sample {count}"),
        )
    if not first:
        return
    plots = plot_spread(found, folder)
    out.print(spread_summary(found))
    more = {"polynomials.csv": found.chaos, "indices.csv": found.indices}
    tables = ["spread.csv", "samples.csv", *(name for name, held in more.items() if held)]
    tell_written([*map(Path, tables), *plots], folder)
