"""Load cases of a result for people: a line for each, and the members with the case that governs each."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from rich.markup import escape
from rich.table import Table

from fenics_mech._constants import ROUNDING
from fenics_mech.recovery import Result
from fenics_mech.safety import judge
from fenics_mech.safety.critical_speeds import speeds_to_avoid
from fenics_mech.safety.load_cases import ENVELOPE, LEAST, envelope
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.scene.joints import effort_units
from fenics_mech.views.reading import ForceReading, Reading, reading_of
from fenics_mech.views.safety_words import sized, speeds_in_words
from fenics_mech.views.tables import plain_table
from fenics_mech.views.words import short

MOST_CASES = 4  # that a summary lists
NONE = "\N{EN DASH}"
Row = list[str | float]
WORDS = {  # what is told of load cases, and its kind of unit; that of an effort depends on its joint
    "case_safety": ("least factor of safety over the wanted one", ""),
    "case_stress": ("largest stress", "stress"),
    "case_strain": ("largest strain", "strain"),
    "case_deflection": ("largest deflection", "length"),
    "case_joint_force": ("largest joint force", "force"),
    "case_effort": ("largest effort", ""),
}


@dataclass(frozen=True)
class CaseLine:
    """What is told of a load case."""

    name: str  # its name
    # its least factor of safety with the wanted one, and the mode and the member; what is not known is a dash
    least: tuple[str, str]
    # largest stress, deflection, joint force and effort of the first drive, with what each is of; of those that there
    # are
    numbers: tuple[tuple[str, str], ...]


def case_lines(result: Result, units: AnswerUnits) -> tuple[tuple[str, ...], list[CaseLine]]:
    """Give a line for each load case, the least safe first, and the heads of its numbers with their units."""
    columns = _columns(result, units)
    lines = []
    for name in ranked_cases(result):
        numbers = []
        for variable, _, kind in columns:
            values = result.data[variable].sel(case=name)
            n = int(np.argmax(values.fillna(-np.inf).to_numpy()))
            owner, most = str(values[values.dims[0]].to_numpy()[n]), float(values.to_numpy()[n])
            beside = variable if variable != "case_effort" else "case_joint_force"  # with an arm of 1 m
            largest = max(float(result.data[name].max()) for name in (variable, beside) if name in result.data)
            seen = most > ROUNDING * largest  # what is less is rounding
            numbers.append((short(units.number(most, kind) if seen else 0.0), owner if seen else NONE))
        least = NONE, NONE
        if result.scene.members() and (governing := judge(result.cases[name]).governing) is not None:
            least = sized(governing[1]), f"{governing[1].mode}, {governing[0]}"
        lines.append(CaseLine(name, least, tuple(numbers)))
    return tuple(f"{head}\n{units.label(kind)}" for _, head, kind in columns), lines


def _columns(result: Result, units: AnswerUnits) -> list[tuple[str, str, str]]:
    """Variables of the cases that a result has, with the head and the kind of unit of each."""
    turns = effort_units(result.scene.moved_joints, result.scene.joints)[:1] == ["N m"]
    known = [
        ("case_stress", "stress", "stress"),
        ("case_deflection", "deflection", "length"),
        ("case_joint_force", "joint force", "force"),
        ("case_effort", "torque" if turns else "drive force", "moment" if turns else "force"),
    ]
    return [column for column in known if column[0] in result.data and result.data[column[0]].size]


def governed(result: Result) -> str:
    """Name a machine, how many load cases it has, and which governs."""
    count = len(result.cases)
    return f"{result.stated.name}: {f'{count} load cases; {result.case} governs' if count > 1 else 'one load case'}"


def ranked_cases(result: Result) -> list[str]:
    """Give the names of the load cases, the least safe first, or where none is judged the most stressed."""
    names = [str(name) for name in result.data["case"].to_numpy()]
    for variable, sign in (("case_safety", 1), ("case_stress", -1), ("case_joint_force", -1)):
        if variable in result.data and result.data[variable].size and result.data[variable].notnull().any():
            values = (sign * result.data[variable]).fillna(np.inf).transpose("case", ...).to_numpy()
            return [names[int(n)] for n in np.argsort(values.min(axis=1), kind="stable")]
    return names


def cases_table(result: Result, units: AnswerUnits) -> Table:
    """Tabulate the load cases, the least safe first, for 80 columns: deflections are told by members."""
    heads, lines = case_lines(result, units)
    shown = [n for n, head in enumerate(heads) if not head.startswith("deflection")]
    safe = any(line.least[0] != NONE for line in lines)
    sizes = (heads[n].replace("joint force\n", "joint\nforce, ") for n in shown)
    table = plain_table("load case", *(["least factor<", "by<"] if safe else []), *sizes)
    told = lines if len(lines) <= MOST_CASES else lines[: MOST_CASES - 1]
    for line in told:
        numbers = [line.numbers[n][0] for n in shown]
        table.add_row(escape(line.name), *(map(escape, line.least) if safe else ()), *numbers)
    if more := len(lines) - len(told):
        table.caption = f"and {more} safer ones: see the report"
    return table


@dataclass(frozen=True)
class MemberLine:
    """The largest of a member over all load cases."""

    name: str  # its label
    # stress, strain: largest stress, and the strain there
    stress: str
    strain: str
    where: tuple[str, str]  # place and side of it, and the drive angle
    case: str  # the case that it is in
    # deflection, bent_in: largest deflection, and the case that it is in
    deflection: str
    bent_in: str
    size: float  # size of the stress, by which members are ranked


def member_lines(result: Result, units: AnswerUnits) -> list[MemberLine]:
    """Give the largest stress and deflection of each member over all load cases, the most stressed member first."""
    found, most, lines = readings(result, units), envelope(result), []
    for member in map(str, most["member"].to_numpy()):
        one = most.sel(member=member)
        stressed, bent = (str(one[f"case_{name}_in"].item()) for name in ("stress", "deflection"))
        reading = found[stressed]
        i = reading.members.index(member)
        peak = reading.peaks[i]
        stress = float(reading.stress[peak])
        where = f"{reading.place(peak).removeprefix('at ')}, {reading.fibres[peak.f]}", reading.at(peak.k)
        strain = short(float(reading.strain[peak]))
        deflection = short(units.number(float(one["case_deflection"]), "length"))
        lines.append(MemberLine(member, short(stress), strain, where, stressed, deflection, bent, abs(stress)))
    return sorted(lines, key=lambda line: -line.size)


def readings(result: Result, units: AnswerUnits) -> dict[str, Reading]:
    """Read every load case in the same units."""
    found = {name: reading_of(one, units) for name, one in result.cases.items()}
    return {name: one for name, one in found.items() if isinstance(one, Reading)}


def speeds_of_cases(result: Result) -> str:
    """Name the speed to avoid that is nearest to that of any load case, with the case."""
    near = {
        name: min((abs(one.distance) for one in speeds_to_avoid(case, 1)), default=np.inf)
        for name, case in result.cases.items()
    }
    nearest = min(near, key=near.__getitem__)
    said = speeds_in_words(result.cases[nearest], 1)
    return f"{said}, nearest in case {nearest}" if np.isfinite(near[nearest]) else said


def case_sheets(reading: ForceReading) -> list[tuple[str, tuple[str, ...], list[Row]]]:
    """Give a table of the load cases, the least safe first, and one of the largest of all cases, by what it is of."""
    data, most = reading.result.data, envelope(reading.result)
    each: list[Row] = []
    largest: list[Row] = []
    for variable in (name for name in ENVELOPE if name in most):
        owner = ENVELOPE[variable]
        labels = [str(label) for label in most[owner].to_numpy()]
        for n, label in enumerate(labels):
            words, size, unit = case_words(reading, variable, n)
            in_case = str(most[f"{variable}_in"].to_numpy()[n])
            largest.append([words, label, float(most[variable].to_numpy()[n]) / size, unit, in_case])
        for case in ranked_cases(reading.result):
            values = data[variable].sel(case=case).to_numpy()
            known = [n for n, value in enumerate(values) if not math.isnan(value)]
            if known:
                n = (min if variable in LEAST else max)(known, key=lambda i: values[i])
                words, size, unit = case_words(reading, variable, n)
                each.append([case, words, float(values[n]) / size, unit, labels[n]])
    heads = ("load case", "of it", "number", "unit", "of"), ("of all load cases", "of", "number", "unit", "in case")
    return [("load cases", heads[0], each), ("envelope", heads[1], largest)]


def case_words(reading: ForceReading, variable: str, n: int) -> tuple[str, float, str]:
    """Give words for a number of a load case, the size of its unit in SI, and that unit."""
    words, kind = WORDS[variable]
    if variable == "case_effort":
        units = effort_units(reading.scene.moved_joints, reading.scene.joints)
        kind = "moment" if units[n] == "N m" else "force"
    return words, reading.units.size(kind) if kind else 1.0, reading.units.label(kind) if kind else ""
