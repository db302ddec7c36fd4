"""`fenics-mech effects`."""

from __future__ import annotations

from dataclasses import replace
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
        list[str] | None,
        typer.Option("--tol", help="Largest error, such as 1e-3 or deflection=1%. Effects above half of it count."),
    ] = None,
    units: Units = None,
    strict: Strict = False,
) -> None:
    """Estimate the influence of each effect without running the scene, and say which effects the scene needs."""
    with loading():
        from fenics_mech.accuracy.theory_ladder import EXACT_STRAINS  # noqa: PLC0415
        from fenics_mech.by_poses import choices_of, has_poses, planned  # noqa: PLC0415
        from fenics_mech.kinematics.free_linkage import with_freedoms  # noqa: PLC0415
        from fenics_mech.planning.effect_choice import rungs  # noqa: PLC0415
        from fenics_mech.planning.law_choice import choose_laws  # noqa: PLC0415
        from fenics_mech.studies.effect_costs import added_one_by_one  # noqa: PLC0415
        from fenics_mech.views.effect_plots import plot_effects, runs_table  # noqa: PLC0415
        from fenics_mech.views.tables import effects_table  # noqa: PLC0415

    stated = with_units(refined_scene(scene, 0, strict, tolerance), units)
    loaded = stated.changed(effects="auto")
    with progress_bar(1) as step:
        step("effects")
        lawful, laws = choose_laws(loaded)
        moving = with_freedoms(lawful) if lawful.analysis.method == "transient" else lawful
        (chosen, choices), *exact = rungs(moving)
    choices = (*choices, *laws)
    threshold: float | None = loaded.neglected / 2
    if has_poses(loaded):  # what is estimated is told; what acts is not chosen by it
        chosen, exact, threshold = planned(loaded), [], None
        sizes = {choice.effect.name: choice.size for choice in choices}
        choices = tuple(replace(taken, size=sizes.get(taken.effect.name)) for taken in choices_of(chosen))
    out.print(effects_table(choices, threshold, EXACT_STRAINS if exact else ""))
    names = ", ".join(f'"{choice.effect.name}"' for choice in choices if choice.effect.name in chosen.effects)
    enough = "" if chosen.analysis.method == loaded.analysis.method else ", and method = 'quasi-static' is enough"
    tell(f"effects = 'auto' selects effects = [{names}]{enough}")
    if exact:
        tell(f"A run takes {EXACT_STRAINS} too if its answer shows that linear strains leave out too much.")
    if stated.effects != "auto":
        tell("This scene does not state effects = 'auto': a run takes the effects that the scene states.")
    if compare:
        make_folder(folder)
        runs = added_one_by_one(loaded)
        out.print(runs_table(runs))
        tell_written([plot_effects(runs, folder / "effects.png")], folder)
