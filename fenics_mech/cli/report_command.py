"""`fenics-mech report`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import loading, make_folder, tell
from fenics_mech.cli.common import Units, any_result, unit_names
from fenics_mech.errors import ResultError, StrangeError


def report(
    result: Annotated[Path, typer.Argument(help="Result file (result.nc), or a sweep (sweep.nc).", show_default=False)],
    file: Annotated[Path, typer.Option("-o", "--out", help="File to write, ending in .html.")] = Path("report.html"),
    units: Units = None,
) -> None:
    """Write a result as one page for a browser: verdict, mechanism in motion, curves, tables. It needs no network.

    The page of a sweep has its curves beside a slider.
    """
    with loading():
        from fenics_mech.studies.sweep import Sweep  # noqa: PLC0415  (numerical libraries take a second: not for --help)
        from fenics_mech.views.page.report import report as write  # noqa: PLC0415
        from fenics_mech.views.page.sweep_page import sweep_report  # noqa: PLC0415

    try:
        sweep = Sweep.load(result)
    except StrangeError:  # a sweep, though not one to be shown
        raise
    except ResultError:
        loaded = any_result(result, units)
        make_folder(file.parent)
        write(loaded, file)
    else:
        make_folder(file.parent)
        sweep_report(sweep if units is None else sweep.told_in(unit_names(units)), file)
    tell(f"Wrote {file}")
