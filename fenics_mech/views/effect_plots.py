"""Effects compared: strain curves with effects added one at a time, and what each costs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.table import Table

from fenics_mech.views.figures import COLOURS, curve, finish, new_figure, save
from fenics_mech.views.prefixes import labelled
from fenics_mech.views.tables import table_of

if TYPE_CHECKING:
    from fenics_mech.studies.effect_costs import Run


RUN_COLUMNS = "effect added", "strain differs from\nthe last row by", "time (s)", "compiled\nforms", "PETSc\nmatrices"


def plot_effects(runs: Sequence[Run], path: str | Path) -> Path:
    """Plot the mid-span strain of every member that bends most, one panel a member, one curve a run."""
    result = runs[-1].result
    last, units = result.data["strain"], result.scene.answer_units
    peaks = abs(last).max(("theta", "s", "fibre")).to_series().sort_values(ascending=False)
    members = list(peaks.index[:2])
    figure, panels = new_figure(rows=len(members), height=3.4 * len(members))
    for axes, member in zip(panels, members):
        for i, run in enumerate(runs):
            theta, strain = run.result.data["theta"].to_numpy(), run.result.strain_at(member)
            axes.plot(
                *curve(theta, strain / units.size("strain")),
                label=run.name,
                color=COLOURS[i % len(COLOURS)],
                linestyle="-",
                linewidth=1.2 + (run is runs[-1]),
            )
        finish(
            axes, f"Strain of {member} at mid-span, + side: effects added in turn", labelled(units, "strain"), columns=3
        )
    return save(figure, path)


def runs_table(runs: Sequence[Run]) -> Table:
    """Tabulate by how much the strains of every run differ from those of the last one, and what the run took."""
    table = table_of("Effects added one at a time", *RUN_COLUMNS)
    for run in runs:
        off = "" if run is runs[-1] else f"{100 * run.difference:.3g} %"
        table.add_row(run.name, off, f"{run.count.seconds:.3f}", str(run.count.forms), str(run.count.matrices))
    return table
