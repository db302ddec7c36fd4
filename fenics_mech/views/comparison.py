"""Comparisons for people: a table of differences, curves above one another, and a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from fenics_mech._constants import TINY
from fenics_mech._files import write_frame
from fenics_mech.errors import ViewError, percent
from fenics_mech.scene import Scene
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.studies.compare import COLUMNS, Curves, Quantity
from fenics_mech.views.figures import COLOURS, curve, finish, new_figure, save
from fenics_mech.views.plots import MEASURED
from fenics_mech.views.prefixes import fitted, without_rounding
from fenics_mech.views.reading import place_along
from fenics_mech.views.tables import drive_of, number, table_of
from fenics_mech.views.words import DEGREE, MINUS, in_degrees, sentence

KINDS = {"deflection": "length", "joint_force": "force", "shaking_force": "force"}  # of units, by kind of quantity
POINTS: dict[str, Any] = MEASURED | {"color": "#000000"}
SAME_SPEED = 1e-9  # relative difference of speeds that are alike
MOST_PANELS = 8  # in one figure
MEANING = (
    "rms: root mean square of the difference, over the reference's peak\n"
    "shift: angle by which the curve is later than the reference\n"
)


def comparison_table(sources: Sequence[Curves], data: xr.Dataset, scene: Scene) -> Group:
    """Tabulate what `compare` found, up to two tables for each source beside the reference, and vibration."""
    tables: list[RenderableType] = []
    units = _units(sources, data, scene)
    known = {quantity.label: quantity for source in sources for quantity in source.known}
    for source in sources[1:]:
        found = data.sel(other=source.label)
        title = f"{source.label} against {data.attrs['reference']}"
        tables.append(_table(title, found, known, scene, units))
        if not np.isnan(found["largest_difference"]).all():
            tables.append(_anywhere_table(found, known, scene, units))
    tables.append(Text(MEANING))
    members = dict.fromkeys(member for source in sources for member in source.vibration)
    if members:
        title = "Vibration of the strain at mid-span, or at a gauge (Hz)"
        table = table_of(title, "member", *(source.label for source in sources))
        for member in members:
            rates = (source.vibration.get(member) for source in sources)
            table.add_row(escape(member), *("-" if rate is None else number(rate) for rate in rates))
        tables.append(table)
    return Group(*tables)


def differing_speeds(scenes: Mapping[str, Scene], told: Scene) -> str:
    """Say so where runs differ in speed, with the speed of each; nothing where they do not."""
    rates = np.array([scene.cycle_rate for scene in scenes.values()])
    if np.allclose(rates, rates[0], rtol=SAME_SPEED, atol=0):
        return ""
    said = "; ".join(f"{label}: {drive_of(scene, told.answer_units)}" for label, scene in scenes.items())
    return f"The runs differ in speed, and are compared at equal drive angles. {said}."


def _anywhere_table(found: xr.Dataset, known: dict[str, Quantity], scene: Scene, units: AnswerUnits) -> Table:
    """Tabulate the largest differences along the members, with their places and drive angles."""
    table = table_of("Largest difference anywhere along a member", "quantity", "difference", "where", "at")
    group = ""
    for i, label in enumerate(found["quantity"].to_numpy()):
        one = found.isel(quantity=i)
        if np.isnan(one["largest_difference"]):
            continue
        quantity, (size, unit) = known[str(label)], _scale(known[str(label)].kind, str(one["unit"].item()), units)
        if quantity.kind != group:
            group = quantity.kind
            table.add_row(escape(f"{group} ({unit})"))
        side = str(one["largest_fibre"].item())
        where = place_along(scene, quantity.part, float(one["largest_s"]), scene.answer_units).removeprefix("at ")
        angle = in_degrees(float(one["largest_theta"]))
        value = number(float(one["largest_difference"]) / size)
        table.add_row(f"  {escape(quantity.part)}", value, escape(f"{where}{_side(side)}"), angle)
    return table


def _side(fibre: str) -> str:
    return f", {fibre.replace('-', MINUS)}" if fibre else ""


def _place(quantity: Quantity, scene: Scene) -> str:
    """Say where a strain or a deflection is, "at O" or "135 mm from C"; nothing where it has no place."""
    if quantity.kind not in ("strain", "deflection"):
        return ""
    return place_along(scene, quantity.part, quantity.s, scene.answer_units)


def _units(sources: Sequence[Curves], data: xr.Dataset, scene: Scene) -> AnswerUnits:
    """Units of the comparison: those of the scene, with prefixes that fit the largest of all peaks."""
    known = {quantity.label: quantity for source in sources for quantity in source.known}
    largest = {"force": 0.0, "moment": 0.0}
    for label, unit in zip(data["quantity"].to_numpy(), data["unit"].to_numpy()):
        if (kind := _kind(known[str(label)].kind, str(unit))) in largest:
            peaks = [data[name].sel(quantity=label).to_numpy() for name in ("peak_reference", "peak")]
            largest[kind] = max(largest[kind], float(np.nanmax(np.abs(peaks), initial=0.0)))
    return fitted(without_rounding(largest, largest["force"]), scene.answer_units)


def _kind(kind: str, unit: str) -> str:
    """Kind of unit of a kind of quantity with a unit in SI."""
    if kind == "input_torque":
        return "force" if unit == "N" else "moment"
    return KINDS.get(kind, kind)


def _scale(kind: str, unit: str, units: AnswerUnits) -> tuple[float, str]:
    """Size of a unit in SI and its name, for a kind of quantity with a unit in SI."""
    of = _kind(kind, unit)
    return units.size(of), units.label(of)


def _table(title: str, data: xr.Dataset, known: dict[str, Quantity], scene: Scene, units: AnswerUnits) -> Table:
    """Tabulate each quantity that both have, below a line for its kind."""
    table, group = table_of(title, "quantity", "peak of\nreference", "peak", "largest\ndifference", "rms", "shift"), ""
    for i, label in enumerate(data["quantity"].to_numpy()):
        row, quantity = {name: float(data[name][i]) for name in COLUMNS}, known[str(label)]
        if np.isnan(row["peak"]):
            continue
        size, unit = _scale(quantity.kind, str(data["unit"].to_numpy()[i]), units)
        name = f"{quantity.kind.replace('_', ' ')} ({unit})"
        if quantity.part and quantity.kind != group:
            table.add_row(escape(name))
        group = quantity.kind
        side = _side(quantity.fibre) if group == "strain" else ""
        what = f"  {quantity.part} {_place(quantity, scene)}".rstrip() + side if quantity.part else name
        sizes = [number(row[name] / size) for name in ("peak_reference", "peak", "difference")]
        measure = float(max(abs(row["peak_reference"]), TINY))
        shift = f"{round(np.degrees(row['shift']), 2) + 0.0:.2f}{DEGREE}"  # no minus before zero
        table.add_row(escape(what), *sizes, percent(row["rms"] / measure), shift)
    return table


def write_comparison(data: xr.Dataset, path: Path) -> Path:
    """Write the comparison as a CSV, one quantity and source a line, in SI."""
    table = data.to_dataframe().dropna(subset=["peak"]).reset_index()
    write_frame(path, table)
    return path


def plot_comparison(sources: Sequence[Curves], data: xr.Dataset, folder: Path, scene: Scene) -> list[Path]:
    """Draw the curves of all sources, a figure for each kind of quantity and a panel for each part."""
    # Of many parts those are drawn that differ most.
    asked = dict.fromkeys(quantity for source in sources for quantity in source.known)
    order = {str(label): i for i, label in enumerate(data["quantity"].to_numpy())}
    rms = np.nan_to_num(data["rms"].to_numpy()).max(axis=0)
    drawn = [q for q in asked if q.label in order and any(other.has(q) for other in sources[1:])]
    if not drawn:
        raise ViewError("these sources have no quantity in common: there is nothing to draw")
    units, paths = _units(sources, data, scene), []
    for kind in dict.fromkeys(quantity.kind for quantity in drawn):
        of_kind = sorted((q for q in drawn if q.kind == kind), key=lambda q: -rms[order[q.label]])[:MOST_PANELS]
        of_kind.sort(key=lambda q: order[q.label])
        figure, panels = new_figure(rows=len(of_kind), height=1.0 + 2.6 * len(of_kind))
        for axes, quantity in zip(panels, of_kind):
            known = [(i, source) for i, source in enumerate(sources) if source.has(quantity)]
            size, unit = _scale(kind, known[0][1].unit(quantity), units)
            for i, source in known:
                theta, values = source.curve(quantity)
                if source.cycle is None:
                    axes.plot(np.degrees(theta) % 360, values / size, label=source.label, **POINTS)
                else:
                    look: dict[str, Any] = {"color": COLOURS[i % len(COLOURS)], "linestyle": "-"}
                    axes.plot(*curve(theta, values / size), label=source.label, **look)
            words = kind.replace("_", " ")
            title = sentence(words) + (f" of {quantity.part}" if quantity.part else "")
            title += f", {place}" if (place := _place(quantity, scene)) else ""
            title += f"{_side(quantity.fibre)} side" if kind == "strain" else ""
            finish(axes, title, f"{words} ({unit})", columns=3)
        paths.append(save(figure, folder / f"compare_{kind}.png"))
    return paths
