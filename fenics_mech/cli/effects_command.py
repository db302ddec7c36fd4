"""`fenics-mech effects`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import loading, make_folder, out, progress_bar, tell, tell_written
from fenics_mech.cli.common import OutFolder, SceneFile, Strict, Units, refined_scene, with_units


def effects(
    scene: SceneFile,
    compare: Annotated[bool, typer.Option("--compare", help="Also run it with effects added one at a time.")] = False,
    folder: OutFolder = Path("out"),
    tolerance: Annotated[
        list[str] | None, typer.Option("--tol", help="Largest error, such as 1e-3 or deflection=1%.")
    ] = None,
    units: Units = None,
    strict: Strict = False,
) -> None:
    """Say which effects act where the program chooses them, and what exact strains change."""
    with loading():
        from fenics_mech.analysis import analyse  # noqa: PLC0415
        from fenics_mech.planning.law_choice import choose_laws  # noqa: PLC0415
        from fenics_mech.recovery.dataset import choices_in  # noqa: PLC0415
        from fenics_mech.studies.effect_costs import added_one_by_one  # noqa: PLC0415
        from fenics_mech.views.effect_plots import plot_effects, runs_table  # noqa: PLC0415
        from fenics_mech.views.tables import effects_table  # noqa: PLC0415

    stated = with_units(refined_scene(scene, 0, strict, tolerance), units)
    loaded = stated.changed(effects="auto")
    with progress_bar(1) as step:
        step("effects")
        lawful, laws = choose_laws(loaded)
        result = analyse(lawful)
    choices = [*choices_in(result.data), *laws]
    out.print(effects_table(choices))
    names = ", ".join(
        f'"{choice.effect.name}"' for choice in choices if choice.effect.name in result.scene.named_effects
    )
    tell(f"effects = 'auto' selects effects = [{names}]")
    if stated.effects != "auto":
        tell("This scene does not state effects = 'auto': a run takes the effects that the scene states.")
    if compare:
        make_folder(folder)
        runs = added_one_by_one(loaded)
        out.print(runs_table(runs))
        tell_written([plot_effects(runs, folder / "effects.png")], folder)
