"""`fenics-mech synthesise`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fenics_mech._console import loading, make_folder, out, tell, warn
from fenics_mech.cli.common import Strict, Units, answer_units, refuse_own_source
from fenics_mech.errors import MechanismError

if TYPE_CHECKING:
    from rich.table import Table

    from fenics_mech.scene.answer_units import AnswerUnits
    from fenics_mech.studies.synthesis.synthesise import Synthesised

MOST = 12  # four-bars with one task in closed form


def synthesise(
    task: Annotated[Path, typer.Argument(help="File with what the four-bar is to do (TOML).", show_default=False)],
    file: Annotated[Path, typer.Option("-o", "--out", help="Scene file to write.")] = Path("linkage.toml"),
    draw: Annotated[
        Path | None, typer.Option(help="Also draw the four-bar in its positions: a PNG, PDF or SVG file.")
    ] = None,
    starts: Annotated[int, typer.Option(min=1, max=100_000, help="Searches for a path, from random starts.")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="Seed of their starts.")] = 0,
    take: Annotated[
        int, typer.Option(min=1, max=MOST, help="Which one to write where several four-bars do it; 1 is the best.")
    ] = 1,
    units: Units = None,
    strict: Strict = False,
) -> None:
    """Find the dimensions of a four-bar for a function, positions or a path, and write it as a scene."""
    with loading():
        from fenics_mech.scene import load_task, write_scene  # noqa: PLC0415
        from fenics_mech.studies.synthesis.synthesise import four_bars  # noqa: PLC0415

    wanted, told = load_task(task), answer_units(units)
    refuse_own_source(file, task)
    if draw is not None:  # before anything is written
        from fenics_mech.views.figures import refuse_ending, save  # noqa: PLC0415
        from fenics_mech.views.synthesis_plots import synthesis_figure  # noqa: PLC0415

        refuse_ending(draw)
    every = four_bars(wanted, starts=starts, seed=seed)
    if take > len(every):
        known = "is 1 four-bar" if len(every) == 1 else f"are {len(every)} four-bars"
        raise MechanismError(f"--take {take}: there {known} for this task")
    found = every[take - 1]
    warn(found.defects, strict)
    make_folder(file.parent)
    write_scene(found.scene, file, f"{found.scene.name}, by fenics-mech synthesise")
    out.print(_summary(found, told))
    if len(every) > 1:
        out.print(_table(every, take, told))
    tell(f"Wrote {file}")
    if draw is not None:
        make_folder(draw.parent)
        tell(f"Wrote {save(synthesis_figure(found), draw)}")


def _table(every: Sequence[Synthesised], taken: int, units: AnswerUnits) -> Table:
    """List all four-bars that do it, the best first."""
    from math import degrees  # noqa: PLC0415

    from rich.table import Table  # noqa: PLC0415

    title = f"{len(every)} four-bars do this; number {taken} is written, and --take gives another"
    heading = f"crank, coupler, follower, ground ({units.label('length')})"
    table = Table("", "kind", heading, "transmission", "defects", title=title)
    for number, one in enumerate(every, 1):
        lengths = ", ".join(f"{units.number(length, 'length'):.4g}" for length in one.linkage.lengths)
        defects = ", ".join(defect.split(":")[0] for defect in one.defects) or "none"
        table.add_row(
            str(number), one.linkage.kind, lengths, f"{degrees(one.transmission):.3g}\N{DEGREE SIGN}", defects
        )
    return table


def _summary(found: Synthesised, units: AnswerUnits) -> str:
    """Write the dimensions and what the linkage is like."""
    from math import degrees  # noqa: PLC0415

    linkage, degree = found.linkage, "\N{DEGREE SIGN}"
    names = ("crank", "coupler", "follower", "ground")
    lengths = ", ".join(f"{name} {units.text(x, 'length', 5)}" for name, x in zip(names, linkage.lengths))
    passed = ", ".join(f"{degrees(found.course.start + one):.4g}" for one in found.course.turned[:8])
    more = " and so on" if len(found.course.turned) > 8 else ""
    error = 0.0 if found.error < 1e-9 * max(linkage.lengths) else found.error
    return "\n".join(
        [
            f"{linkage.kind[:1].upper()}{linkage.kind[1:]}",
            lengths,
            f"The crank {'turns' if linkage.turns else 'swings'}, and passes {passed}{degree}{more}.",
            f"Smallest transmission angle: {degrees(found.transmission):.4g}{degree}",
            f"Largest distance from what is asked: {units.text(error, 'length', 3)}",
        ]
    )
