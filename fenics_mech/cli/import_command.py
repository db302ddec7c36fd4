"""`fenics-mech import`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import make_folder, tell
from fenics_mech.cli.common import refuse_own_source


def import_scene(
    source: Annotated[
        Path,
        typer.Argument(
            help="Sketch (.svg, .dxf), drawing (.geo, .msh, .inp) or mechanism of pylinkage (.json).",
            show_default=False,
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="Scene file to write.")] = Path("scene.toml"),
    unit: Annotated[
        str | None, typer.Option(help="Unit of its lengths; by default mm, of pylinkage m.", show_default=False)
    ] = None,
) -> None:
    """Write a scene file from a sketch, a drawing or a linkage of pylinkage."""
    from fenics_mech._files import write_whole  # noqa: PLC0415
    from fenics_mech.scene.importing import imported  # noqa: PLC0415

    refuse_own_source(out, source)
    text = imported(source, unit)
    make_folder(out.parent)
    write_whole(out, lambda temporary: temporary.write_text(text, encoding="utf-8"))
    tell(f"Wrote {out}: material, section, driven joint and speed are assumed. Correct them there")
