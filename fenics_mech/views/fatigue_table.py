"""A table of the damage by fatigue, for people, and one in a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.text import Text

from fenics_mech._files import write_frame
from fenics_mech.recovery import Result
from fenics_mech.recovery.stress_figures import fatigue
from fenics_mech.views.prefixes import prefixed
from fenics_mech.views.tables import number, table_of
from fenics_mech.views.words import share

MEANING = "range, mean and ratio (least over largest stress) of the material and place of the largest damage"


def fatigue_table(result: Result, found: xr.Dataset) -> Group:
    """Tabulate the worst place of each member: its stresses, its damage, and how long it lasts."""
    units, cycle = prefixed(result, result.scene.answer_units), "stress_range" in found
    unit = units.label("stress")
    stresses = [f"range\n({unit})", f"mean\n({unit})", "ratio"] if cycle else []
    table = table_of(
        "Damage by fatigue", "member", "s, side", *stresses, "damage of\na cycle", "life\n(cycles)", "hours"
    )
    damage = found["damage"].transpose("member", "s", "fibre").to_numpy()
    for i, member in enumerate(found["member"].to_numpy()):
        if np.isnan(damage[i]).all():
            continue
        j, f = np.unravel_index(int(np.nanargmax(damage[i])), damage[i].shape)
        fibre = str(found["fibre"].to_numpy()[f])
        cells = [f"{float(found['s'][j]):.3g}, {fibre}".replace("-", "\N{MINUS SIGN}")]
        if cycle:
            place = found.sel(member=member, fibre=fibre).isel(s=j)
            cells += [number(units.number(float(place[f"stress_{name}"]), "stress")) for name in ("range", "mean")]
            cells += [f"{float(place['stress_ratio']):.2f}"]
        lasts = [float(found[name].sel(member=member)) for name in ("life_cycles", "life_hours")]
        words = ["without end" if np.isinf(value) else f"{value:.3g}" for value in lasts]
        table.add_row(escape(str(member)), *cells, f"{damage[i, j, f]:.3g}", *words)
    table.caption = MEANING
    return Group(Text(result.scene.name, style="bold"), table)


def cases_fatigue(result: Result, found: xr.Dataset) -> Group:
    """Tabulate the damage of every load case, and the share of the life that all of them use."""
    parts: list[RenderableType] = [fatigue_table(one, fatigue(one)) for one in result.cases.values()]
    if "life_used" not in found:
        text = "The cases tell no `cycles` or `share`, so that the worst of them decides."
        return Group(*parts, Text(text))
    names = [str(name) for name in found["case"].to_numpy()]
    table = table_of("Life used by all load cases", "member", *(f"in {name}" for name in names), "in all")
    for member in found["member"].to_numpy():
        one = found.sel(member=member)
        if np.isnan(float(one["life_used"])):
            continue
        shares = [share(float(value)) for value in [*one["used"].sel(case=names).to_numpy(), one["life_used"]]]
        table.add_row(escape(str(member)), *shares)
    cycles = ", ".join(f"{name} {result.cycles[name]:.3g}" for name in names)
    table.caption = f"at 100 % a member breaks; cycles of the machine: {cycles}"
    return Group(*parts, table)


def write_fatigue(found: xr.Dataset, path: Path) -> Path:
    """Write a CSV of the damage at every place."""
    table = found["damage"].to_dataframe().dropna().reset_index()
    write_frame(path, table)
    return path
