"""A summary of a result that fits a screen: safety, the peak, how accurate it is, tables, and what decided."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence

import numpy as np
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from fenics_mech._console import text_of
from fenics_mech.effects.known import VIBRATION
from fenics_mech.errors import percent, percent_of_error
from fenics_mech.estimate.quantities import ERROR_VARIABLES
from fenics_mech.planning.answer_remarks import WORDS, unmet
from fenics_mech.recovery import Result
from fenics_mech.recovery.spatial_result import SpatialResult
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.scene.bodies import POISSON
from fenics_mech.views.case_tables import cases_table, governed, member_lines, speeds_of_cases
from fenics_mech.views.details import (
    damping_of,
    freedoms_table,
    law_table,
    motion_rows,
    rigid_parts,
    running_lines,
    small_motions_table,
)
from fenics_mech.views.details import details as all_details
from fenics_mech.views.judgements import Judgement, Level, acting, headline, judgements, unstated_gravity, verdict
from fenics_mech.views.prefixes import prefixed
from fenics_mech.views.reading import Reading, change_by_vibration, reading_of
from fenics_mech.views.safety_words import (
    across_in_words,
    frequency_ranges,
    ranges_in_words,
    safety_row,
    safety_sentences,
    speeds_in_words,
)
from fenics_mech.views.space.summary import summary_parts
from fenics_mech.views.tables import plain_table, rows_table
from fenics_mech.views.words import AT_MOST, MINUS, share, short

STYLES: dict[Level, str] = {"bad": "bold red", "warn": "bold yellow", "good": "green", "note": "green"}
MOST_MEMBERS, MOST_WARNINGS, MOST_MODES, MOST_VIBRATIONS = 4, 3, 6, 2  # that are shown
JOINTS_WIDTH, LEAST_COLUMN = 68, 6  # characters: of a line of joints, and of a column


class Summary(Group):
    """A summary: text where it is printed, and with colours by `rich.print`."""

    def __str__(self) -> str:
        return text_of(self)


def summary(result: Result | SpatialResult, details: bool = False, units: AnswerUnits | None = None) -> Summary:
    """Summarise a result, to be printed; it needs 80 columns.

    First the machine, whether it is safe, the peak stress with its place and drive angle, and whether the computation
    is accurate. Then reasons against it with their size, and warnings. Then a table of the members, the most stressed
    first, the joint forces, and what the program decided.

    Parameters
    ----------
    result
        The result, in the plane or in space.
    details
        Whether all is told that is known: how it was computed, harmonics, each frequency, power.
    units
        Units of the numbers, instead of those of the scene.

    Returns
    -------
    Summary
        A text with tables; `rich.print` shows it with colours.

    Examples
    --------
    >>> print(fm.summary(fm.Result.load("out/result.nc")))  # doctest: +ELLIPSIS
    seed four-bar...
    """
    if isinstance(result, SpatialResult):
        return Summary(*summary_parts(result, details, units))
    units = prefixed(result, units or result.scene.answer_units)
    if not result.scene.members():
        return Summary(*rigid_parts(result, units))
    if details:
        return Summary(all_details(result, units))
    reading, judged = reading_of(result, units), judgements(result)
    assert isinstance(reading, Reading)
    level, usable = verdict(judged)
    safe_level, safe = safety_sentences(result, units)
    machine = governed(result) if result.cases else f"{reading.scene.name}: {reading.driven()}"
    assumed = ", ".join(notice.partition(" ")[0].removeprefix("materials.") for notice in result.notices)
    told = [_met(result), assumed and f"Poisson's ratio is assumed as {POISSON} in shear: {assumed}."]
    parts: list[RenderableType] = [
        Text(machine, style="bold"),
        Text(" ".join(safe), style=STYLES[safe_level]),
        Text(" ".join(headline(reading))),
        Text(usable, style=STYLES[level]),
        *map(Text, filter(None, told)),
        *(Text(one.text, STYLES[one.level].removeprefix("bold ")) for one in judged if one.level in ("bad", "warn")),
        *(Text(f"Warning: {text}", style="yellow") for text in result.warnings[:MOST_WARNINGS]),
    ]
    if (more := len(result.warnings) - MOST_WARNINGS) > 0:
        parts.append(Text(f"{more} more warnings: see --details", style="yellow"))
    if result.cases:
        parts += [Text(), cases_table(result, units), Text(), *_members_of_cases(reading), Text()]
    else:
        parts += [Text(), *_members(reading), Text()]
        parts += [_joints(reading), Text()] if reading.joints else []
    parts += [law_table(result, units), Text()] if "law_effort" in result.data else []
    if "freedom_place" in result.data:
        parts += [freedoms_table(result, units), *map(Text, running_lines(result)), Text()]
    if "rest_frequency" in result.data:
        parts += [small_motions_table(result), Text()]
    return Summary(*parts, _rest(reading, judged))


def _members_of_cases(reading: Reading) -> list[RenderableType]:
    """Tabulate the largest stress and deflection of the most stressed members, with the load case of each."""
    stress, strain, length = (reading.units.label(kind) for kind in ("stress", "strain", "length"))
    head = f"stress\n{stress}", f"strain\n{strain}", "where, side<", "at", "in case<", f"deflection\n{length}"
    table, lines = plain_table("member", *head), member_lines(reading.result, reading.units)
    for line in lines[:MOST_MEMBERS]:
        bent = line.deflection if line.bent_in == line.case else f"{line.deflection} in {line.bent_in}"
        table.add_row(*map(escape, (line.name, line.stress, line.strain, *line.where, line.case, bent)))
    if not (more := lines[MOST_MEMBERS:]):
        return [table]
    return [table, Text(f"and {len(more)} more, none above {more[0].stress.strip(MINUS)} {stress}: see the report")]


def _met(result: Result) -> str:
    """Say that the tolerance that was asked for is met; nothing where none was, or a warning says that it is not."""
    if not result.scene.tolerances or unmet(result):
        return ""
    said = []
    for what, most in result.scene.tolerances.items():
        name = f"{ERROR_VARIABLES[what][1]}error_estimate"
        if name in result.data.attrs:
            error = percent_of_error(result.data.attrs[name])
            said.append(f"{WORDS[what]} {percent(most)}, with an error of at most {error}")
    return f"The tolerance is met: {'; '.join(said)}." if said else ""


def _members(reading: Reading) -> list[RenderableType]:
    """Tabulate peak stress, strain and deflection of the most stressed members, and say how many are left out."""
    kinds = {"stress": "stress", "strain": "strain", "deflection": "length"}
    stress, strain, bend = (f"{name}\n{reading.units.label(kind)}" for name, kind in kinds.items())
    table = plain_table("member", stress, strain, "where, side<", "at", bend, "where<")
    for i in reading.ranked[:MOST_MEMBERS]:
        peak, bent = reading.peaks[i], reading.peak(reading.bent, i)
        table.add_row(
            escape(reading.members[i]),
            short(reading.stress[peak]),
            short(reading.strain[peak]),
            escape(f"{reading.place(peak).removeprefix('at ')}, {reading.fibres[peak.f]}"),
            reading.at(peak.k),
            short(reading.bent[bent]),
            escape(reading.place(bent).removeprefix("at ")),
        )
    if not (others := reading.ranked[MOST_MEMBERS:]):
        return [table]
    most = short(float(np.abs(reading.stress[:, others[0]]).max()))
    return [table, Text(f"and {len(others)} more, none above {most} {reading.units.label('stress')}: see the report")]


def _joints(reading: Reading) -> Table:
    """Tabulate the largest joint forces side by side: of as many joints as fit a line."""
    ranked = [int(n) for n in np.argsort(-reading.force.max(axis=0), kind="stable")]
    widths = np.cumsum([max(len(reading.joints[n]), LEAST_COLUMN) + 2 for n in ranked])
    shown = sorted(ranked[: max(int((widths <= JOINTS_WIDTH).sum()), 1)])
    table = plain_table("joint", *(escape(reading.joints[n]) for n in shown))
    table.add_row(f"force, {reading.units.label('force')}", *(short(float(reading.force[:, n].max())) for n in shown))
    table.add_row("at", *(reading.at(int(reading.force[:, n].argmax())) for n in shown))
    if len(shown) < len(ranked):
        table.caption = f"the largest of {len(ranked)} joints"
    return table


def _rest(reading: Reading, judged: Sequence[Judgement]) -> Table:
    """Tell what is left: drive, safety, vibration, frequencies, error, effects, damping."""
    result = reading.result
    rows: dict[str, str] = {}
    if reading.effort is not None and not result.cases:
        (name, unit), k = reading.effort_name, int(np.abs(reading.effort).argmax())
        rows[name] = f"{short(float(reading.effort[k]))} {unit} at {reading.at(k)}"
    if (said := _shakes(reading)) and not result.cases:
        name = next(iter(rows), "frame")
        rows[name] = f"{rows[name]}; {said}" if rows else said
    others = {"safety": safety_row(result)}
    if result.cases:  # what is common to them is in the details
        others["avoid"] = speeds_of_cases(result)
    else:
        others |= {"vibrates": _vibrates(result, reading.units), "frequencies": _frequencies(result)}
        others["across"] = across_in_words(result, MOST_MODES)
        others["avoid"] = speeds_in_words(result, 1)
    rows |= {name: text for name, text in others.items() if text}
    told = [one for one in judged if one.level == "note" or (one.level == "good" and one.about == "error")]
    rows |= {one.about: one.text for one in told}
    rows |= motion_rows(result, reading.units)
    rows |= {} if result.cases else {"effects": _effects(result)}
    rows |= {"assumed": "; ".join(result.notices)} if result.notices else {}
    rows |= {} if result.cases else {"damped by": damping_of(result.scene)}
    return rows_table(rows)


def _shakes(reading: Reading) -> str:
    """Tell the largest force and moment on the frame."""
    if reading.shaking is None:
        return ""
    force, moment = reading.shaking
    said = []
    for kind, curve in (("force", np.linalg.norm(force, axis=-1)), ("moment", moment)):
        k = int(np.abs(curve).argmax())
        said.append(f"{short(float(curve[k]))} {reading.units.label(kind)} at {reading.at(k)}")
    return f"shaking force {said[0]}, {said[1]}"


def _vibrates(result: Result, units: AnswerUnits) -> str:
    """Name the members that vibrate most, with frequency, mode and multiple of the drive."""
    data, said = result.data, []
    if "vibration_frequency" not in data:
        return ""
    for i in np.argsort(-data["vibration_amplitude"].to_numpy(), kind="stable")[:MOST_VIBRATIONS]:
        one = data.isel(member=int(i))
        rate, mode, order = (float(one[f"vibration_{name}"]) for name in ("frequency", "mode", "harmonic"))
        if not (math.isfinite(rate) and math.isfinite(mode) and math.isfinite(order)):
            continue
        size = short(units.number(float(one["vibration_amplitude"]), "strain"))
        size = f"\N{PLUS-MINUS SIGN}{size} {units.label('strain')}"
        said.append(f"{one['member'].item()} {short(rate)} Hz, mode {mode:.0f}, {order:.0f} times the drive, {size}")
    return "; ".join(said)


def _frequencies(result: Result) -> str:
    """Write the range over the cycle of each natural frequency, which knows no speed."""
    if not (ranges := frequency_ranges(result)):
        return ""
    more = f" and {len(ranges) - MOST_MODES} more" if len(ranges) > MOST_MODES else ""
    return f"{ranges_in_words(ranges[:MOST_MODES])} Hz{more}, held in place"


def _effects(result: Result) -> str:
    """Name the effects that act, with their share of the strains where it was estimated, and those left out."""
    listed = json.loads(result.data.attrs["effects"])
    held = {effect.replaces for effect in acting(result)}

    def said(effect: dict[str, object]) -> str:
        size, name = effect["size"], str(effect["name"])
        if unstated_gravity(result, name):
            return "gravity (none is stated)"
        solved = change_by_vibration(result) if name == VIBRATION and effect["acts"] else None
        of_peak = "" if solved is None else f" (as solved {share(solved)} of the peak stress)"
        return f"{name} {'' if size is None else _size(float(str(size)))}".rstrip() + of_peak

    on = [said(effect) for effect in listed if effect["acts"]]
    out = [said(e) for e in listed if not e["acts"] and e["size"] is not None and e["name"] not in held]
    text = f"{', '.join(on) or 'none'}{'; left out: ' if out else ''}{', '.join(out)}"
    estimated = any(effect["size"] for effect in listed)
    return f"{text} (upper bounds of their shares of the strains)" if estimated else text


def _size(size: float) -> str:
    """Write an upper bound; one of all the strains or more says nothing."""
    return "" if size >= 1 else "0" if size == 0 else f"{AT_MOST}{share(size).removeprefix('less than ')}"
