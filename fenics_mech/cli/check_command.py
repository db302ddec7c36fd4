"""`fenics-mech check`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import loading, make_folder, out, start_libraries, tell
from fenics_mech.cli.common import SceneFile, Strict, loaded_scene, refuse_in_space, scene_in_space


def check(
    scene: SceneFile,
    strict: Strict = False,
    draw: Annotated[
        Path | None, typer.Option("--draw", help="Also draw the model at its start: a .png, .pdf or .svg.")
    ] = None,
    update: Annotated[
        bool, typer.Option("--update", help="First rewrite a file of an earlier version. Comments stay.")
    ] = False,
) -> None:
    """Check a scene file without analysing it."""
    spatial = scene_in_space(scene)
    if spatial is not None:
        refuse_in_space(update=update)
    if update:
        _update(scene)
    with loading():
        from fenics_mech.effects import active  # noqa: PLC0415
        from fenics_mech.machine.reach import reachable_range  # noqa: PLC0415
        from fenics_mech.views.tables import scene_overview  # noqa: PLC0415

    if spatial is not None:
        start_libraries()  # sections of any shape are solved
        from fenics_mech.views.space.overview import spatial_overview  # noqa: PLC0415

        out.print(spatial_overview(spatial), highlight=False)
    else:
        loaded = loaded_scene(scene, strict, cases=True)
        active(loaded)
        out.print(scene_overview(loaded, reachable_range(loaded)), highlight=False)
    if draw is not None:
        from fenics_mech.views.figures import figure_in, save  # noqa: PLC0415
        from fenics_mech.views.model_plots import plot_scene  # noqa: PLC0415

        make_folder(draw.parent)
        tell(f"Wrote {save(figure_in(plot_scene(spatial or loaded)), draw)}")


def _update(path: Path) -> None:
    """Rewrite a scene file without keys that have gone, and say what holds now."""
    with loading():
        from fenics_mech._files import write_whole  # noqa: PLC0415
        from fenics_mech.scene.files import read_toml, text_of  # noqa: PLC0415
        from fenics_mech.scene.updating import updated  # noqa: PLC0415

    read_toml(text := text_of(path), path.name, lambda data: data)
    text, left_out = updated(text)
    if left_out:
        write_whole(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))
    for key, now in left_out.items():
        tell(f"Left out analysis.{key}: {now}")
    if not left_out:
        tell("Nothing to update")
