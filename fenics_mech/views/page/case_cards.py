"""The card of load cases: a line for each, and every member, joint and drive with the case that governs it."""

from __future__ import annotations

from fenics_mech.safety.load_cases import ENVELOPE, envelope
from fenics_mech.views.case_tables import case_lines, case_words, member_lines
from fenics_mech.views.page.html import EMPTY, Html, join, table, tag
from fenics_mech.views.reading import ForceReading, Reading
from fenics_mech.views.words import short

LEAD = (
    "The largest of each load case, the least safe case first. The safety below is of all cases. Drawing, curves and "
    "the other numbers below are of case {}, which governs; each other case has a page of its own."
)


def case_card(reading: ForceReading, pages: dict[str, str]) -> Html:
    """Tabulate the load cases, and what governs each member."""
    result = reading.result
    if not result.cases:
        return EMPTY
    heads, lines = case_lines(result, reading.units)
    names = {name: tag("a", name, href=pages[name]) if name in pages else tag("b", name) for name in result.cases}
    rows = [[names[line.name], *line.least, *(f"{value} ({owner})" for value, owner in line.numbers)] for line in lines]
    head = ["load case", "least factor<", "by<", *(one.replace("\n", ", ") for one in heads)]
    parts = [tag("p", LEAD.format(result.case), class_="lead"), table(head, rows)]
    return tag("section", tag("h2", "Load cases"), *parts, *_envelopes(reading), class_="card")


def _envelopes(reading: ForceReading) -> list[Html]:
    """Tabulate members and joints with their largest numbers over all cases."""
    result, found = reading.result, list[Html]()
    if isinstance(reading, Reading):
        unit = {kind: reading.units.label(kind) for kind in ("stress", "strain", "length")}
        head = ["member", f"stress, {unit['stress']}", f"strain, {unit['strain']}", "where<", "at", "in case<"]
        head += [f"deflection, {unit['length']}", "in case<"]
        rows = [
            [one.name, one.stress, one.strain, *one.where, one.case, one.deflection, one.bent_in]
            for one in member_lines(result, reading.units)
        ]
        found.append(join([tag("h3", "Members, the largest of all cases"), table(head, rows)]))
    most = envelope(result)
    rows = []
    for variable in ("case_joint_force", "case_effort"):
        labels = most[ENVELOPE[variable]].to_numpy() if variable in most else ()
        for n, label in enumerate(labels):
            words, size, of = case_words(reading, variable, n)
            value = short(float(most[variable].to_numpy()[n]) / size)
            rows.append([str(label), words, f"{value} {of}", str(most[f"{variable}_in"].to_numpy()[n])])
    if rows:
        head = ["joint or drive", "<", "of all cases", "in case<"]
        found.append(join([tag("h3", "Joints and drives, the largest of all cases"), table(head, rows)]))
    return found
