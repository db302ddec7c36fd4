"""Tables of load cases for spreadsheets."""

from __future__ import annotations

import math

from fenics_mech.safety.load_cases import ENVELOPE, LEAST, envelope
from fenics_mech.scene.joints import effort_units
from fenics_mech.views.case_tables import ranked_cases
from fenics_mech.views.reading import ForceReading

Row = list[str | float]
WORDS = {  # what is told of load cases, and its kind of unit; that of an effort depends on its joint
    "case_safety": ("least factor of safety over the wanted one", ""),
    "case_stress": ("largest stress", "stress"),
    "case_strain": ("largest strain", "strain"),
    "case_deflection": ("largest deflection", "length"),
    "case_joint_force": ("largest joint force", "force"),
    "case_effort": ("largest effort", ""),
}


def case_sheets(reading: ForceReading) -> list[tuple[str, tuple[str, ...], list[Row]]]:
    """Give a table of the load cases, the least safe first, and one of the largest of all cases, by what it is of."""
    data, most = reading.result.data, envelope(reading.result)
    each: list[Row] = []
    largest: list[Row] = []
    for variable in (name for name in ENVELOPE if name in most):
        owner = ENVELOPE[variable]
        labels = [str(label) for label in most[owner].to_numpy()]
        for n, label in enumerate(labels):
            words, size, unit = told_of_case(reading, variable, n)
            in_case = str(most[f"{variable}_in"].to_numpy()[n])
            largest.append([words, label, float(most[variable].to_numpy()[n]) / size, unit, in_case])
        for case in ranked_cases(reading.result):
            values = data[variable].sel(case=case).to_numpy()
            known = [n for n, value in enumerate(values) if not math.isnan(value)]
            if known:
                n = (min if variable in LEAST else max)(known, key=lambda i: values[i])
                words, size, unit = told_of_case(reading, variable, n)
                each.append([case, words, float(values[n]) / size, unit, labels[n]])
    heads = ("load case", "of it", "number", "unit", "of"), ("of all load cases", "of", "number", "unit", "in case")
    return [("load cases", heads[0], each), ("envelope", heads[1], largest)]


def told_of_case(reading: ForceReading, variable: str, n: int) -> tuple[str, float, str]:
    """Give words for a number of a load case, the size of its unit in SI, and that unit."""
    words, kind = WORDS[variable]
    if variable == "case_effort":
        units = effort_units(reading.scene.moved_joints, reading.scene.joints)
        kind = "moment" if units[n] == "N m" else "force"
    return words, reading.units.size(kind) if kind else 1.0, reading.units.label(kind) if kind else ""
