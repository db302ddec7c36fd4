"""`fenics-mech export`."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import make_folder, tell
from fenics_mech.cli.common import SceneFile


class Program(StrEnum):
    """Programs that scenes can be written for."""

    EXUDYN = "exudyn"


def export(
    scene: SceneFile,
    to: Annotated[Program, typer.Option("--to", help="The other program.")] = Program.EXUDYN,
    file: Annotated[Path, typer.Option("-o", "--out", help="File to write.")] = Path("exudyn_model.py"),
) -> None:
    """Write a scene as a script of another program: a second opinion on the same beams, joints and drive."""
    from fenics_mech.recovery.result import write_whole  # noqa: PLC0415
    from fenics_mech.scene import load  # noqa: PLC0415
    from fenics_mech.studies.peers.exudyn_script import exudyn_script  # noqa: PLC0415

    text = exudyn_script(load(scene))
    make_folder(file.parent)
    write_whole(file, lambda temporary: temporary.write_text(text, encoding="utf-8"))
    tell(f"Wrote {file}: run it with Python where Exudyn is installed")
