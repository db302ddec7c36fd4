"""`fenics-mech report`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import loading, make_folder, tell
from fenics_mech.cli.common import Units, loaded_result


def report(
    result: Annotated[Path, typer.Argument(help="Result file (result.nc).", show_default=False)],
    file: Annotated[Path, typer.Option("-o", "--out", help="File to write, ending in .html.")] = Path("report.html"),
    units: Units = None,
) -> None:
    """Write a result as one page for a browser: verdict, mechanism in motion, curves, tables. It needs no network."""
    with loading():
        from fenics_mech.views.page.report import report as write  # noqa: PLC0415  (numerical libraries take a second: not for --help)

    loaded = loaded_result(result, units)
    make_folder(file.parent)
    write(loaded, file)
    tell(f"Wrote {file}")
