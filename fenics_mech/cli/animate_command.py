"""`fenics-mech animate`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fenics_mech._console import loading, make_folder, progress_bar, tell
from fenics_mech.cli.common import (
    Refine,
    SceneFile,
    Units,
    analysed,
    any_result,
    refuse_in_space,
    scene_in_space,
    with_units,
)
from fenics_mech.errors import MechanismError

if TYPE_CHECKING:
    from fenics_mech.recovery import Result
    from fenics_mech.recovery.spatial_result import SpatialResult


def animate(
    scene: SceneFile,
    file: Annotated[Path, typer.Option("-o", "--out", help="File to write: .gif, .mp4 or .png.")] = Path("motion.mp4"),
    magnify: Annotated[float | None, typer.Option(help="Factor on the deflection.", show_default="selected")] = None,
    frames: Annotated[int, typer.Option(min=2, max=10_000, help="Pictures in one cycle.")] = 120,
    colour: Annotated[str, typer.Option(help="What the colours show: stress or strain.")] = "stress",
    names: Annotated[bool, typer.Option("--names", help="Name joints, points of [points] and loads.")] = False,
    true_width: Annotated[
        bool, typer.Option("--true-width", help="Draw members as wide as their sections in the plane of motion.")
    ] = False,
    refine: Refine = 0,
    units: Units = None,
) -> None:
    """Draw the moving linkage, its deflection magnified, each side coloured by its stress. SCENE may be a result.nc."""
    with loading():
        from fenics_mech.views import animation  # noqa: PLC0415
        from fenics_mech.views.picture_files import check_ending  # noqa: PLC0415

    check_ending(file)
    if colour not in animation.COLOURED:
        raise MechanismError(f"--colour is {' or '.join(animation.COLOURED)}, found {colour!r}")
    make_folder(file.parent)
    result: Result | SpatialResult
    if scene.suffix == ".nc" and not refine:
        result = any_result(scene, units)
    elif scene.suffix != ".nc" and (spatial := scene_in_space(scene)) is not None:
        refuse_in_space(refine=refine, true_width=true_width)
        with loading():
            from fenics_mech.analysis import analyse  # noqa: PLC0415
        with progress_bar(1) as step:
            step("response")
            result = analyse(with_units(spatial, units))
    else:
        result = analysed(scene, units, strict=False, refine=refine)
    with progress_bar(frames) as step:
        animation.animate(
            result,
            file,
            magnify=magnify,
            frames=frames,
            colour=colour,
            names=names,
            true_width=true_width,
            progress=lambda index, count: step(f"frame {index + 1} of {count}"),
        )
    tell(f"Wrote {file}")
