"""`fenics-mech modes`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fenics_mech._console import loading, make_folder, out, progress_bar, tell, tell_written
from fenics_mech.cli.common import (
    OutFolder,
    Refine,
    SceneFile,
    Strict,
    Units,
    loaded_scene,
    refuse_in_space,
    scene_in_space,
    with_units,
)
from fenics_mech.errors import SceneError

if TYPE_CHECKING:
    from fenics_mech.scene.in_space import SpatialScene


def modes(
    scene: SceneFile,
    folder: OutFolder = Path("out"),
    draw: Annotated[
        Path | None, typer.Option("--draw", help="Also draw the mode shapes: a .png, .pdf or .svg, moving in a .gif.")
    ] = None,
    angle: Annotated[float, typer.Option(help="Drive angle (deg) at which mode shapes are drawn.")] = 0.0,
    refine: Refine = 0,
    units: Units = None,
    strict: Strict = False,
) -> None:
    """Solve for the natural frequencies over the cycle: write frequencies.csv and a plot, print a table.

    They are those of the mechanism held at each position. Where spin and axial forces change them by 0.5 % or more,
    those in the motion stand below, and in running_frequencies.csv.

    Beside Hz the table has them in the unit of speed that is named by --units or by the scene, such as rpm.
    """
    with loading():
        from fenics_mech.scene import refined  # noqa: PLC0415
        from fenics_mech.scene.answer_units import named_units  # noqa: PLC0415
        from fenics_mech.studies.natural_frequencies import modes as solved  # noqa: PLC0415
        from fenics_mech.views.figures import figure_in, new_axes, save  # noqa: PLC0415
        from fenics_mech.views.frequency_views import (  # noqa: PLC0415
            TOLD,
            changes,
            draw_frequencies,
            frequency_table,
            write_frequencies,
        )

    spatial = scene_in_space(scene)
    if spatial is not None:
        refuse_in_space(refine=refine, draw=draw, angle=angle)
        _modes_in_space(spatial, folder)
        return
    loaded = with_units(refined(loaded_scene(scene, strict), refine), units)
    speed = named_units(loaded.units).get("speed")
    make_folder(folder)
    with progress_bar(4, alike=False) as step:
        found = solved(loaded, step)
        step("plot")
        supported = dict(zip(found.data["member"].to_numpy(), found.data["supported"].to_numpy()))
        frequency, theta = found.data["frequency"].to_numpy(), found.data["theta"].to_numpy()
        running = found.data["running_frequency"].to_numpy()
        written = [write_frequencies(theta, frequency, folder / "frequencies.csv")]
        if (changes(frequency, running) >= TOLD).any():
            written.append(write_frequencies(theta, running, folder / "running_frequencies.csv"))
        drawn = draw_frequencies(frequency, theta, supported, new_axes(height=4.8))
        written.append(save(figure_in(drawn), folder / "frequencies.png"))
    assurance, error = found.data["assurance"].to_numpy(), found.data["frequency_error"].to_numpy()
    theory = found.data["theory_error"].to_numpy()
    out.print(frequency_table(frequency, assurance, error, supported, speed, running, theory))
    for decision in found.decisions:
        tell(f"Effects: {decision}")
    for freedom in found.free:
        tell(f"Rigid-body motion: {freedom}")
    for warning in found.warnings:
        tell(f"Warning: {warning}.")
    tell_written(written, folder)
    if draw is not None:
        from fenics_mech.views.model_plots import animate_modes, plot_mode_shapes  # noqa: PLC0415

        make_folder(draw.parent)
        if draw.suffix.lower() == ".gif":
            animate_modes(found, draw, math.radians(angle))
        else:
            save(plot_mode_shapes(found, math.radians(angle)), draw)
        tell(f"Wrote {draw}")


def _modes_in_space(scene: SpatialScene, folder: Path) -> None:
    """Print and draw the frequencies of a linkage in space by position, held by its drives, at rest."""
    with loading():
        from fenics_mech.analysis import analyse  # noqa: PLC0415
        from fenics_mech.views.frequency_views import write_frequencies  # noqa: PLC0415
        from fenics_mech.views.space.plots import spatial_plots  # noqa: PLC0415
        from fenics_mech.views.space.summary import frequency_table  # noqa: PLC0415

    method = "quasi-static" if scene.drives and scene.analysis.method != "static" else "static"
    plain: dict[str, Any] = {
        "method": method,
        "duration": None,
        "start_speeds": {},
        "multipliers": 0,
        "error_estimates": False,
    }
    make_folder(folder)
    analysis = scene.analysis.model_copy(update=plain).model_dump(by_alias=True)
    result = analyse(scene.changed(analysis=analysis))
    if "frequency" not in result.data:
        raise SceneError("no link bends, or analysis.modes is 0: there are no frequencies", place="analysis.modes")
    out.print(frequency_table(result))
    theta, frequency = result.data["theta"].to_numpy(), result.data["frequency"].to_numpy()
    written = [write_frequencies(theta, frequency, folder / "frequencies.csv")]
    tell_written(written + spatial_plots(result, folder, ["frequencies"], ".png"), folder)
