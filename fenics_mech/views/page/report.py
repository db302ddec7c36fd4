"""The report of a result as one page: heading, verdict, key figures, frames that the script draws in, and tables."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from fenics_mech.recovery import Result
from fenics_mech.recovery.spatial_result import SpatialResult
from fenics_mech.views.judgements import headline, judgements, verdict
from fenics_mech.views.page import page_tables
from fenics_mech.views.page.curves import kinds_of, payload, sections_of
from fenics_mech.views.page.html import (
    EMPTY,
    Html,
    card,
    join,
    page_file,
    plot_frame,
    slider,
    tag,
    tile,
    top,
    whole_page,
    write_page,
)
from fenics_mech.views.page.page_tables import case_card, critical, frequencies, joints, safety
from fenics_mech.views.reading import ForceReading, Reading, reading_of, reading_of_a_file
from fenics_mech.views.safety_words import frequency_ranges, safety_sentences
from fenics_mech.views.space.page import spatial_page
from fenics_mech.views.words import sentence, short

STABILITY = (
    "Each point is what one cycle leaves of a small disturbance (a Floquet multiplier). Inside the circle it dies out."
)
LEGEND = (
    "Each side of a member shows the stress of that side: ",
    tag("b", "blue compression", class_="comp"),
    ", ",
    tag("b", "red tension", class_="tens"),
    ". The ring is the place of the peak. Dashed: the rigid linkage.",
)
SCALE = (tag("span", id="least"), tag("canvas", id="scale", width=512, height=1), tag("span", id="most"))
SCRIPTS = ("data.js", "axes.js", "canvas.js", "drawing.js", "plots.js", "forces.js", "controls.js")


def heading(reading: ForceReading) -> Html:
    """Name the machine and how it is driven, beside the buttons of the page."""
    governs = f"; of {len(reading.result.cases)} load cases this one governs" if reading.result.cases else ""
    return top(reading.scene.name, f"{reading.driven()}{governs}")


def verdict_of(reading: ForceReading) -> Html:
    """Tell whether the machine is safe, the peak, whether the numbers can be used, and why; then warnings."""
    judged, (value, rest) = judgements(reading.result), headline(reading)
    exact, usable = verdict(judged)
    reasons = [tag("li", tag("b", sentence(j.title)), tag("span", j.text), class_=j.level) for j in judged]
    warned = [tag("li", text) for text in reading.result.warnings]
    safe, level = EMPTY, exact
    if isinstance(reading, Reading):
        safe_level, (first, *others) = safety_sentences(reading.result, reading.units)
        safe = tag("p", tag("strong", first), " ", " ".join(others), class_=f"safe {safe_level}")
        level = "bad" if safe_level == "bad" else level
    return tag(
        "section",
        safe,
        tag("p", tag("strong", value), " ", rest, class_="headline"),
        tag("p", usable, class_=f"usable {exact}"),
        tag("ul", *reasons, class_="reasons"),
        tag("ul", *warned, class_="warned") if warned else EMPTY,
        class_=f"verdict {level}",
    )


def figures(reading: ForceReading) -> Html:
    """Show the numbers that a designer asks for first."""
    found = list[Html]()
    if isinstance(reading, Reading):
        peak = reading.peak(reading.bent, int(reading.bent.max(axis=(0, 2, 3)).argmax()))
        where = f"{reading.members[peak.i]}, {reading.place(peak)}, {reading.at(peak.k)}"
        found.append(tile("largest deflection", float(reading.bent.max()), reading.units.label("length"), where))
    if reading.joints:
        k, n = map(int, np.unravel_index(reading.force.argmax(), reading.force.shape))
        where = f"joint {reading.joints[n]}, {reading.at(k)}"
        found.append(tile("largest joint force", float(reading.force[k, n]), reading.units.label("force"), where))
    if reading.effort is not None:
        (name, unit), k = reading.effort_name, int(np.abs(reading.effort).argmax())
        where = reading.at(k)
        if len(reading.theta) > 1:
            where += f"; from {short(reading.effort.min())} to {short(reading.effort.max())}"
        found.append(tile(f"largest {name}", float(reading.effort[k]), unit, where))
    if reading.shaking is not None:
        force, moment = np.linalg.norm(reading.shaking[0], axis=-1), reading.shaking[1]
        k, m = int(force.argmax()), int(np.abs(moment).argmax())
        turning = f"{short(float(moment[m]))} {reading.units.label('moment')} at {reading.at(m)}"
        where = f"{reading.at(k)}; moment {turning}"
        found.append(tile("shaking force on the frame", float(force[k]), reading.units.label("force"), where))
    if ranges := frequency_ranges(reading.result):
        least = min((low for low, _ in ranges if low > 0), default=np.inf)
        where = f"{short(least * reading.scene.period)} times the drive's"
        found.append(tile("lowest natural frequency", least, "Hz", where))
    told = tag("p", f"In case {reading.result.case}, which governs:", class_="of") if reading.result.cases else EMPTY
    return join([told, tag("section", *found, class_="tiles")])


def moving(reading: ForceReading) -> Html:
    """Give the frames of the drawing and of the curves at the peak's place, or of joint forces where no link bends."""
    said = tag("p", "The pictures need JavaScript. All numbers are in the tables below.")
    if isinstance(reading, Reading):
        return join([tag("noscript", said), tag("div", _drawing(reading), _curves(reading), class_="stage live")])
    return join([tag("noscript", said), tag("div", _drawing(reading), joints(reading), class_="stage")])


def _drawing(reading: ForceReading) -> Html:
    """Make the frame of the drawing, and its controls."""
    what = "time" if reading.in_time else "drive angle"
    play = tag("button", "\N{BLACK RIGHT-POINTING TRIANGLE}", id="play", type="button", aria_label="play or stop")
    position = tag("label", f"{what} ", tag("output", id="told"), slider("position", "any"), class_="grow")
    to_peak = tag("button", "peak", id="to-peak", type="button")
    bends, arrows = isinstance(reading, Reading), tag("input", type="checkbox", id="arrows")
    magnify = tag("label", "deflection magnified ", tag("output", id="times"), slider("magnify", "1"), class_="grow")
    sizes = [magnify if bends else EMPTY, tag("label", arrows, " joint forces", class_="check")]
    if kinds := kinds_of(reading):
        box = tag("input", type="checkbox", id="acting")
        sizes.append(tag("label", box, f" {' and '.join(kinds)}", class_="check"))
    steps = tag("div", play, position, to_peak, class_="row") if len(reading.theta) > 1 else EMPTY
    label = "The mechanism at the chosen position" + (", its members coloured by stress" if bends else "")
    moves = (steps, tag("div", *sizes, class_="row"), tag("p", id="hint", class_="hint"))
    return tag(
        "section",
        tag("canvas", id="mechanism", role="img", aria_label=label),
        join([tag("div", *SCALE, class_="scale"), tag("p", *LEGEND, class_="hint")]) if bends else EMPTY,
        tag("div", *moves, class_="controls"),
        class_="card drawing live",
    )


def _curves(reading: Reading) -> Html:
    """Make the frames of the curves, and the choice of member and unit."""
    members = [tag("option", name, value=i) for i, name in enumerate(reading.members)]
    shown = {kind: [kind, reading.units.label(kind)] for kind in ("stress", "strain")} | sections_of(reading)
    units = [tag("option", f"{name}, {unit}", value=kind) for kind, (name, unit) in shown.items()]
    none = tag("option", "none", value=-1)
    choice = (
        tag("label", "member ", tag("select", *members, id="member")),
        tag("label", "beside ", tag("select", none, *members, id="other")) if len(members) > 1 else EMPTY,
        tag("label", "show ", tag("select", *units, id="unit")),
        tag("button", "CSV", id="csv", type="button") if len(reading.theta) > 1 else EMPTY,
    )
    moves = [*plot_frame("curve"), *plot_frame("map")] if len(reading.theta) > 1 else []
    return tag("section", tag("div", *choice, class_="pick"), *moves, *plot_frame("along"), class_="card")


def dynamics(reading: ForceReading) -> Html:
    """Give the frames of torque, freedoms, frequencies, spectrum and stability: of those that the result has."""
    data, cards = reading.result.data, []
    if isinstance(reading, Reading) and sections_of(reading):
        cards.append(card("Section forces", "sections-where", "sections"))
    if reading.effort is not None and len(reading.theta) > 1:
        cards.append(card(sentence(reading.effort_name[0]), "", "effort"))
    if "freedom_place" in data:
        cards.append(card("Freedoms", "", "freedoms"))
    if "strain_amplitude" in data:
        cards.append(card("Spectrum", "spectrum-where", "spectrum"))
    if "frequency" in data:
        cards.append(card("Natural frequencies", "", "frequency", frequencies(reading)))
    if "critical_speed" in data:
        cards.append(card("Critical speeds", "", "", critical(reading)))
    if "multiplier" in data:
        cards.append(card("Stability", "", "stability", tag("p", STABILITY, class_="hint")))
    return tag("div", *cards, class_="two") if cards else EMPTY


def report(result: Result | SpatialResult, path: str | Path) -> Path:
    """Write a report of a result as one HTML file, which needs no network and no other file.

    Of several load cases it is of the governing one, with the largest of all; beside it are pages of the others, such
    as ``report_idle.html``.

    It begins with the verdict and its reasons. Then come key figures, the mechanism in motion, curves, maps, joint
    forces, decisions, error estimates, and the scene. Tables are readable without a script. A linkage in space is
    turned with the mouse or a finger.

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
    if isinstance(result, SpatialResult):
        with reading_of_a_file():
            write_page(path, spatial_page(result))
        return path
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
    reading, tables = reading_of(result), EMPTY
    if isinstance(reading, Reading):  # where no link bends the joints stand beside the drawing
        members = tag("section", tag("h2", "Members"), page_tables.members(reading), class_="card")
        tables = join([safety(reading), members, joints(reading)])
    cases = result.data.attrs.get("cases")
    stated = json.loads(result.data.attrs["scene"] if cases is None else json.loads(cases)["scene"])
    pieces = {
        "heading": heading(reading),
        "verdict": verdict_of(reading),
        "figures": figures(reading),
        "moving": moving(reading),
        "cases": case_card(reading, pages or {}),
        "tables": tables,
        "dynamics": dynamics(reading),
        "computed": _computed(reading),
        "scene": tag("pre", json.dumps(stated, indent=1, ensure_ascii=False)),
    }
    title = f"{reading.scene.name}: report of fenics_mech"
    return whole_page("page.html", title, pieces, payload(reading), SCRIPTS)


def _computed(reading: ForceReading) -> Html:
    """Tell how the result was computed, and where links bend which effects were taken, and how exact it is."""
    method = page_tables.method(reading)
    if not isinstance(reading, Reading):
        return tag("section", tag("h2", "How it was computed"), method, class_="card")
    effects = (tag("h2", "What was taken into account"), page_tables.effects(reading.result))
    first = tag("section", *effects, tag("h2", "How it was computed", class_="next"), method, class_="card")
    second = tag("section", tag("h2", "How exact it is"), page_tables.errors(reading), class_="card")
    return tag("div", first, second, class_="two last")
