"""The page itself: its parts put into one file that loads nothing from anywhere."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from fenics_mech.recovery import Result
from fenics_mech.views.page import page_tables, parts
from fenics_mech.views.page.case_cards import case_card
from fenics_mech.views.page.curves import payload
from fenics_mech.views.page.html import EMPTY, Html, join, tag
from fenics_mech.views.page.safety_table import safety
from fenics_mech.views.page.shell import page_file, whole_page, write_page
from fenics_mech.views.reading import ForceReading, Reading, reading_of, reading_of_a_file

SCRIPTS = ("data.js", "axes.js", "drawing.js", "plots.js", "forces.js", "controls.js")


def report(result: Result, path: str | Path) -> Path:
    """Write a report of a result as one HTML file, which needs no network and no other file.

    Of several load cases it is of the governing one, with the largest of all; beside it are pages of the others, such
    as ``report_idle.html``.

    It begins with the verdict and its reasons. Then come key figures, the mechanism in motion, curves, maps, joint
    forces, decisions, error estimates, and the scene. Tables are readable without a script.

    Parameters
    ----------
    result
        The result.
    path
        File to write, ending in .html.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ViewError
        When the file's ending is not .html.
    ResultError
        When the result lacks what is shown, or the file cannot be written.

    Examples
    --------
    >>> result = fm.Result.load("out/result.nc")
    >>> fm.report(result, "out/report.html").name
    'report.html'
    """
    path = page_file(path)
    others = pages_of_cases(result, path)
    with reading_of_a_file():
        texts = {path: page(result, {name: other.name for name, other in others.items()})}
        texts |= {other: page(result.cases[name]) for name, other in others.items()}
    for file, text in texts.items():
        write_page(file, text)
    return path


def pages_of_cases(result: Result, path: Path) -> dict[str, Path]:
    """Give the files of the pages of all load cases but the governing one, by the names of the cases."""
    return {name: path.with_stem(f"{path.stem}_{name}") for name in result.cases if name != result.case}


def page(result: Result, pages: dict[str, str] | None = None) -> str:
    """Give the text of the page."""
    reading = reading_of(result)
    pieces = {
        "heading": parts.heading(reading),
        "verdict": parts.verdict_of(reading),
        "figures": parts.figures(reading),
        "moving": parts.moving(reading),
        "cases": case_card(reading, pages or {}),
        "tables": _tables(reading),
        "dynamics": parts.dynamics(reading),
        "computed": _computed(reading),
        "scene": tag("pre", json.dumps(_stated(result), indent=1, ensure_ascii=False)),
    }
    title = f"{reading.scene.name}: report of fenics_mech"
    return whole_page("page.html", title, pieces, payload(reading), SCRIPTS)


def _stated(result: Result) -> Any:
    """Give the scene as plain data, with its load cases where it has some."""
    cases = result.data.attrs.get("cases")
    return json.loads(result.data.attrs["scene"] if cases is None else json.loads(cases)["scene"])


def _tables(reading: ForceReading) -> Html:
    """Tabulate members and joints; where no link bends the joints stand beside the drawing."""
    if not isinstance(reading, Reading):
        return EMPTY
    members = tag("section", tag("h2", "Members"), page_tables.members(reading), class_="card")
    return join([safety(reading), members, page_tables.joints(reading)])


def _computed(reading: ForceReading) -> Html:
    """Tell how the result was computed, and where links bend which effects were taken, and how exact it is."""
    method = page_tables.method(reading)
    if not isinstance(reading, Reading):
        return tag("section", tag("h2", "How it was computed"), method, class_="card")
    effects = (tag("h2", "What was taken into account"), page_tables.effects(reading.result))
    first = tag("section", *effects, tag("h2", "How it was computed", class_="next"), method, class_="card")
    second = tag("section", tag("h2", "How exact it is"), page_tables.errors(reading), class_="card")
    return tag("div", first, second, class_="two last")
