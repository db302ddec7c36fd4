"""A summary of a result in space that fits a screen, and its key figures as plain data."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from rich.console import RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from fenics_mech.errors import percent
from fenics_mech.recovery.spatial_result import SpatialResult
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.views.judgements import SOURCES, verdict
from fenics_mech.views.safety_words import ranges_in_words
from fenics_mech.views.space.reading import ERRORS, SpatialReading
from fenics_mech.views.tables import plain_table
from fenics_mech.views.words import sentence, short

STYLES = {"bad": "bold red", "warn": "bold yellow", "good": "green", "note": "green"}
MOST_MEMBERS, MOST_MODES, MOST_NOTES = 4, 6, 3  # that are shown without details
SMALL = 1e-6  # of the largest force: an effort below it is rounding
LEFT_OUT = "warping of held ends, shear deformation and what a shear centre beside the axis twists are left out"


def summary_parts(result: SpatialResult, details: bool, units: AnswerUnits | None) -> list[RenderableType]:
    """Give the lines and tables of a summary; with `details` all members, modes, notices and sizes."""
    reading = SpatialReading(result, units)
    level, usable = verdict(reading.judged)
    safe_level, safe = reading.safety
    most = None if details else MOST_NOTES
    parts: list[RenderableType] = [
        Text(f"{reading.scene.name}: {reading.driven}", style="bold"),
        Text(safe, style=STYLES[safe_level]),
        *map(Text, filter(None, [" ".join(reading.headline), reading.most_bent])),
        Text(usable, style=STYLES[level]),
        *(Text(f"Warning: {text}", style="yellow") for text in result.warnings[:most]),
        *_more(len(result.warnings), most, "warnings"),
        Text(),
    ]
    for head, rows, shown in ((members_head(reading), member_rows(reading), MOST_MEMBERS), joint_table(reading)):
        if rows:
            parts += [_table(head, rows if details else rows[:shown])]
            parts += [*_more(len(rows), None if details else shown, head[0] + "s"), Text()]
    return [*parts, _table(("", "<"), remaining(reading, details))]


def _more(count: int, shown: int | None, what: str) -> list[Text]:
    return [Text(f"and {count - shown} more {what}: see --details")] if shown is not None and count > shown else []


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    """Make a table without lines; columns whose head ends in "<" stand to the left."""
    table = plain_table(*head)
    table.show_header = any(head[:1])
    for row in rows:
        table.add_row(*map(escape, row))
    return table


def members_head(reading: SpatialReading) -> tuple[str, ...]:
    """Heads of the columns of members."""
    stress, length = reading.units.label("stress"), reading.units.label("length")
    return "member", f"stress\n{stress}", "where<", "at", f"deflection\n{length}", "where<"


def member_rows(reading: SpatialReading) -> list[list[str]]:
    """Largest stress and deflection of each member with place and angle, the most stressed first."""
    ranked = np.argsort(-reading.stress.max(axis=(0, 2), initial=0.0), kind="stable")
    rows = []
    for i in map(int, ranked):
        peak, bent = reading.peak(reading.stress, i), reading.peak(reading.bent, i)
        rows.append(
            [
                reading.members[i],
                short(reading.stress[peak]),
                reading.place(i, peak[2]).removeprefix("at "),
                reading.at(peak[0]),
                short(reading.bent[bent]),
                reading.place(i, bent[2]).removeprefix("at "),
            ]
        )
    return rows


def joint_table(reading: SpatialReading) -> tuple[tuple[str, ...], list[list[str]], int]:
    """Largest force and moment of each joint with the drive angle: heads, rows, and how many a short table shows."""
    units, rows = reading.units, []
    moment = np.linalg.norm(reading.values("joint_moment", "joint", "component"), axis=-1) / units.size("moment")
    least = SMALL * float(moment.max(initial=0.0))
    for n, name in enumerate(reading.joints):
        k, m = int(reading.force[:, n].argmax()), int(moment[:, n].argmax())
        turning = float(moment[m, n])
        said = short(turning) if turning > least else "0"
        rows.append([name, reading.scene.joints[name].kind, short(reading.force[k, n]), reading.at(k), said])
    head = "joint", "kind<", f"force\n{units.label('force')}", "at", f"moment\n{units.label('moment')}"
    return head, rows, 8


def effort_words(reading: SpatialReading, n: int) -> tuple[str, float, str, str]:
    """Name of what a drive exerts, its largest value, the unit, and when and in which range."""
    kind, values = reading.effort_kinds[n], reading.efforts[:, n]
    name = "drive force" if kind == "force" else "drive torque"
    name += f" at {reading.drives[n]}" if len(reading.drives) > 1 else ""
    k = int(np.abs(values).argmax())
    span = f"; from {short(values.min())} to {short(values.max())}" if reading.moves else ""
    return name, float(values[k]), reading.units.label(kind), f"{reading.when(k)}{span}"


def frequency_words(reading: SpatialReading, count: int | None = None) -> str:
    """Ranges of the natural frequencies over the cycle in words."""
    ranges = reading.frequency_ranges[:count]
    return f"{ranges_in_words(ranges)} Hz, held in place" if ranges else ""


def frequency_table(result: SpatialResult) -> Table:
    """Tabulate the lowest and the highest of each natural frequency, and where they are."""
    reading, rows = SpatialReading(result), []
    for n, values in enumerate(reading.values("frequency", "mode").T, 1):
        low, high = int(values.argmin()), int(values.argmax())
        rows.append([str(n), short(values[low]), reading.at(low), short(values[high]), reading.at(high)])
    return _table(("mode", "lowest\nHz", "at", "highest\nHz", "at"), rows)


def error_words(reading: SpatialReading) -> str:
    """Estimated errors by quantity in words."""
    return ", ".join(f"{what} {percent(error)}" for what, error in reading.errors.items())


def remaining(reading: SpatialReading, details: bool = True) -> list[tuple[str, str]]:
    """Rows of all that is no table: drive, frequencies, stability, errors, notices, and with `details` sizes."""
    data, rows = reading.data, []
    for n in range(len(reading.drives)):
        name, value, unit, where = effort_words(reading, n)
        rows.append((name, f"{short(value)} {unit} {where}"))
    rows.append(("frequencies", frequency_words(reading, None if details else MOST_MODES)))
    if "multiplier" in data:
        largest = float(data["multiplier"].max())
        rows.append(("stability", f"largest multiplier {short(largest)}: a disturbance {_fate(largest)}"))
    rows.append(("errors", f"{error_words(reading)}, by estimate" if reading.errors else "not estimated"))
    rows += [("notice", sentence(text)) for text in reading.result.notices]
    rows.append(("left out", LEFT_OUT if reading.members else ""))
    if details:
        attributes = reading.data.attrs
        sources = map(str, data["source"].to_numpy()) if "source" in data else ()
        for n, source in enumerate(sources):
            parts = [
                f"{words} {percent(float(data[name][n]))}"
                for key, words in ERRORS.items()
                if (name := f"{key}_relative_error") in data
            ]
            rows.append((f"error by {SOURCES.get(source, source)}", ", ".join(parts)))
        sizes = f"{attributes['elements']} elements, {attributes['dofs']} coordinates, {len(reading.theta)} positions"
        rows.append(("computed by", f"a {reading.scene.analysis.method} answer: {sizes}"))
        rows.append(("mobility", f"{attributes['mobility']}, without drives, where no link bends"))
        rows.append(("version", f"fenics_mech {attributes['fenics_mech']}"))
    return [row for row in rows if row[1]]


def _fate(multiplier: float) -> str:
    return "dies out" if multiplier < 1 else "grows"


def spatial_key_figures(result: SpatialResult) -> dict[str, Any]:
    """Give the numbers of a summary by name, in SI, with angles in degrees: what `json.dumps` writes."""
    reading = SpatialReading(result)
    size = reading.units.size
    level, said = verdict(reading.judged)
    degrees = np.degrees(np.mod(reading.theta, 2 * np.pi)).round(6)
    when = [{"time": float(t)} for t in reading.time] if reading.in_time else [{"angle": float(d)} for d in degrees]
    found: dict[str, Any] = {
        "scene": reading.scene.name,
        "method": reading.scene.analysis.method,
        "positions": len(reading.theta),
        "mobility": int(result.data.attrs["mobility"]),
        "verdict": {"level": level, "sentence": said},
        "safety": None if reading.limit is None else {"factor": reading.limit.factor, "what": reading.limit.what},
        "members": {},
        "joints": {},
        "drives": {},
        "frequencies": [{"lowest": low, "highest": high} for low, high in reading.frequency_ranges],
        "largest_multiplier": float(result.data["multiplier"].max()) if "multiplier" in result.data else None,
        "errors": {f"{name}_error_estimate": error for name, error in zip(ERRORS, reading.errors.values())},
        "notices": list(result.notices),
        "warnings": list(result.warnings),
    }
    for i, name in enumerate(reading.members):
        k, _, j = reading.peak(reading.stress, i)
        found["members"][name] = {
            "von_mises": float(reading.stress[k, i, j]) * size("stress"),
            "s": float(reading.s[j]),
            **when[k],
            "deflection": float(reading.bent[:, i].max()) * size("length"),
        }
    for n, name in enumerate(reading.joints):
        k = int(reading.force[:, n].argmax())
        found["joints"][name] = {"force": float(reading.force[k, n]) * size("force"), **when[k]}
    for n, name in enumerate(reading.drives):
        values, kind = reading.efforts[:, n] * size(reading.effort_kinds[n]), reading.effort_kinds[n]
        found["drives"][name] = {
            "unit": "N" if kind == "force" else "N m",
            "least": float(values.min()),
            "most": float(values.max()),
        }
    return found
