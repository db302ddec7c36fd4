"""`fenics-mech export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import make_folder, tell
from fenics_mech.errors import MechanismError


def export(
    result: Annotated[Path, typer.Argument(help="Result (.nc).", show_default=False)],
    files: Annotated[
        list[Path],
        typer.Argument(help="Files to write: .pvd for ParaView, .mat for MATLAB and Octave.", show_default=False),
    ],
    every: Annotated[int, typer.Option(min=1, help="Of how many positions one goes into a .pvd.")] = 1,
) -> None:
    """Write a result for other programs: a time series for ParaView, a file for MATLAB."""
    from fenics_mech.recovery import Result  # noqa: PLC0415

    if unknown := [path for path in files if path.suffix not in (".pvd", ".mat")]:
        raise MechanismError(f"{unknown[0]}: exported are .pvd (ParaView) and .mat (MATLAB); tables by run --csv")
    loaded = Result.load(result)
    for path in files:
        make_folder(path.parent)
        loaded.to_vtk(path, every) if path.suffix == ".pvd" else loaded.to_mat(path)
        tell(f"Wrote {path}")
