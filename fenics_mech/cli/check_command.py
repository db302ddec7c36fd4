"""`fenics-mech check`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import loading, make_folder, out, progress_bar, start_libraries, tell
from fenics_mech.cli.common import Strict, loaded_scene
from fenics_mech.errors import MechanismError


def check(
    scene: Annotated[Path | None, typer.Argument(help="Scene file to check.", show_default=False)] = None,
    strict: Strict = False,
    draw: Annotated[
        Path | None, typer.Option("--draw", help="Also draw the model at its start: a .png, .pdf or .svg.")
    ] = None,
) -> None:
    """Check a scene file without analysing it. Without a file, check this installation against the dissertation."""
    with loading():
        from fenics_mech.effects import active  # noqa: PLC0415
        from fenics_mech.kinematics import reachable_range  # noqa: PLC0415
        from fenics_mech.views.tables import check_table, scene_overview  # noqa: PLC0415

    if scene is not None:
        loaded = loaded_scene(scene, strict, cases=True)
        active(loaded)
        out.print(scene_overview(loaded, reachable_range(loaded)), highlight=False)
        if draw is not None:
            from fenics_mech.views.figures import figure_in, save  # noqa: PLC0415
            from fenics_mech.views.model_plots import plot_scene  # noqa: PLC0415

            make_folder(draw.parent)
            tell(f"Wrote {save(figure_in(plot_scene(loaded)), draw)}")
        return
    if draw is not None:
        raise MechanismError("--draw draws the model of a scene: name a scene file")
    start_libraries()
    from fenics_mech.studies.check import CHECKS  # noqa: PLC0415

    findings = []
    with progress_bar(len(CHECKS)) as step:
        for name, examine in CHECKS.items():
            step(name)
            findings += examine()
    out.print(check_table(findings))
    if not all(finding.holds for finding in findings):
        raise MechanismError("some checks failed: do not use the numbers of this installation")
