"""The report of a result in space: one page with verdict, figures, the linkage to be turned, curves and tables."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import MILLI, TURN
from fenics_mech.errors import percent
from fenics_mech.recovery.spatial_result import SpatialResult
from fenics_mech.scene.answer_units import KINDS
from fenics_mech.views.judgements import SOURCES, verdict
from fenics_mech.views.page.curves import DRAWN, STEPS, packed
from fenics_mech.views.page.html import (
    EMPTY,
    Html,
    card,
    join,
    line,
    plot_frame,
    slider,
    table,
    tag,
    tile,
    top,
    whole_page,
)
from fenics_mech.views.space.reading import ERRORS, SpatialReading
from fenics_mech.views.space.skeleton import seen
from fenics_mech.views.space.summary import effort_words, joint_table, member_rows, members_head, remaining
from fenics_mech.views.words import sentence, short

SCRIPTS = "data.js", "axes.js", "canvas.js", "plots.js", "forces.js", "space/space.js", "controls.js"
WIDE = 200  # of the still views, in units of their pictures
MOMENTS = "torsion", "bending about the first axis", "bending about the second axis"
EYES = {"isometric": "isometric", "x": "along X", "y": "along Y", "z": "along Z"}


def spatial_page(result: SpatialResult) -> str:
    """Give the text of the page of a result in space."""
    reading = SpatialReading(result)
    pieces = {
        "heading": top(reading.scene.name, reading.driven),
        "verdict": _verdict(reading),
        "figures": _figures(reading),
        "moving": _moving(reading),
        "stills": _stills(reading),
        "tables": _tables(reading),
        "dynamics": _dynamics(reading),
        "computed": _computed(reading),
        "scene": tag("pre", json.dumps(json.loads(result.data.attrs["scene"]), indent=1, ensure_ascii=False)),
    }
    title = f"{reading.scene.name}: report of fenics_mech"
    return whole_page("space/space.html", title, pieces, _payload(reading), SCRIPTS)


def _verdict(reading: SpatialReading) -> Html:
    """Tell whether the stresses are safe, the largest, whether the numbers can be used, and why."""
    exact, usable = verdict(reading.judged)
    (value, rest), (safe_level, safe) = reading.headline, reading.safety
    reasons = [tag("li", tag("b", sentence(j.title)), tag("span", j.text), class_=j.level) for j in reading.judged]
    reasons += [
        tag("li", tag("b", "Notice"), tag("span", sentence(text)), class_="note") for text in reading.result.notices
    ]
    return tag(
        "section",
        tag("p", tag("strong", safe), class_=f"safe {safe_level}"),
        tag("p", tag("strong", value), " ", rest, class_="headline"),
        tag("p", usable, class_=f"usable {exact}"),
        tag("ul", *reasons, class_="reasons"),
        class_=f"verdict {'bad' if safe_level == 'bad' else exact}",
    )


def _figures(reading: SpatialReading) -> Html:
    """Show the numbers that a designer asks for first."""
    found, units = [], reading.units
    if reading.limit is not None:
        name = reading.members[reading.limit.member]
        found.append(tile("factor of safety", reading.limit.factor, "", f"{name}, against the {reading.limit.what}"))
    if reading.members:
        peak = reading.peak(reading.bent)
        found.append(tile("largest deflection", float(reading.bent[peak]), units.label("length"), reading.words(peak)))
        k, i, j, n = map(int, np.unravel_index(np.abs(reading.moments).argmax(), reading.moments.shape))
        where = f"{MOMENTS[n]}, {reading.words((k, i, j))}"
        found.append(tile("largest section moment", float(reading.moments[k, i, j, n]), units.label("moment"), where))
    if reading.force.size:
        k, n = map(int, np.unravel_index(reading.force.argmax(), reading.force.shape))
        where = f"joint {reading.joints[n]}, {reading.when(k)}"
        found.append(tile("largest joint force", float(reading.force[k, n]), units.label("force"), where))
    for n in range(len(reading.drives)):
        name, value, unit, where = effort_words(reading, n)
        found.append(tile(f"largest {name}", value, unit, where))
    if ranges := reading.frequency_ranges:
        least = ranges[0][0]
        where = f"{short(least * reading.scene.period)} times the drive's" if reading.moves else "about the equilibrium"
        found.append(tile("lowest natural frequency", least, "Hz", where))
    return tag("section", *found, class_="tiles")


def _moving(reading: SpatialReading) -> Html:
    """Give the frames of the drawing and its controls, and those of the curves of a member."""
    said = tag("p", "The turning picture needs JavaScript. All numbers are in the tables below.")
    eyes = [tag("button", text, id=f"eye-{name}", type="button") for name, text in EYES.items()]
    play = tag("button", "\N{BLACK RIGHT-POINTING TRIANGLE}", id="play", type="button", aria_label="play or stop")
    what = "time " if reading.in_time else "drive angle "
    position = tag("label", what, tag("output", id="told"), slider("position", "any"), class_="grow")
    magnify = tag("label", "deflection magnified ", tag("output", id="times"), slider("magnify", "1"), class_="grow")
    arrows = tag("label", tag("input", type="checkbox", id="arrows"), " joint forces", class_="check")
    to_peak = tag("button", "peak", id="to-peak", type="button") if reading.moves else EMPTY
    scale = (tag("span", id="least"), tag("canvas", id="scale", width=512, height=1), tag("span", id="most"))
    legend = "The colour is the von Mises stress. The ring is the place of the peak. Dashed: the rigid linkage. "
    rows = [
        tag("div", *eyes, class_="eyes"),
        tag("div", play, position, to_peak, class_="row") if reading.moves else EMPTY,
        tag("div", magnify if reading.members else EMPTY, arrows, class_="row"),
        tag("p", "Drag to turn it, roll the wheel or pinch to zoom. ", tag("span", id="hint"), class_="hint"),
    ]
    label = f"Linkage {reading.scene.name} in space"
    drawing = tag(
        "section",
        tag("canvas", id="mechanism", class_="turned", role="img", aria_label=label),
        join([tag("div", *scale, class_="scale"), tag("p", legend, class_="hint")]) if reading.members else EMPTY,
        tag("div", *rows, class_="controls"),
        class_="card drawing live",
    )
    return join([tag("noscript", said), tag("div", drawing, _curves(reading), class_="stage live")])


def _curves(reading: SpatialReading) -> Html:
    """Make the frames of the curves, and the choice of member and quantity; of rigid links the table of joints."""
    if not reading.members:
        return _joints(reading)
    members = [tag("option", name, value=i) for i, name in enumerate(reading.members)]
    shown = {"stress": ["von Mises stress", reading.units.label("stress")]} | _sections(reading)
    units = [tag("option", f"{name}, {unit}", value=kind) for kind, (name, unit) in shown.items()]
    choice = (
        tag("label", "member ", tag("select", *members, id="member")),
        tag("label", "beside ", tag("select", tag("option", "none", value=-1), *members, id="other")),
        tag("label", "show ", tag("select", *units, id="unit")),
        tag("button", "CSV", id="csv", type="button") if reading.moves else EMPTY,
    )
    moves = [*plot_frame("curve"), *plot_frame("map")] if reading.moves else []
    return tag("section", tag("div", *choice, class_="pick"), *moves, *plot_frame("along"), class_="card")


def _sections(reading: SpatialReading) -> dict[str, list[str]]:
    """Name and unit of each section force that the curves can show."""
    moment, force = reading.units.label("moment"), reading.units.label("force")
    return {f"moment_{n}": [name, moment] for n, name in enumerate(MOMENTS)} | {"axial": ["axial force", force]}


def _stills(reading: SpatialReading) -> Html:
    """Draw the linkage at its peak along Z, Y and X, for paper and where no script runs."""
    k, times = reading.peak_position, reading.magnify
    said = f"Where it is stressed most, {reading.when(k)}" if reading.members else reading.when(k)
    said += f"; deflection \N{MULTIPLICATION SIGN} {times:g}" if reading.members else ""
    paths, rigid, pins = reading.paths(times)[k], reading.paths(0.0)[k], reading.joint_points(times)[k]
    drawings = []
    every = np.concatenate([part.reshape(-1, 3) for part in (paths, rigid, pins)])
    scale = WIDE / max(float(np.ptp(MILLI * every, axis=0).max()), 1e-9)
    for view in ("XY", "XZ", "YZ"):
        bent, straight, joints = (seen(view, part) * [1, -1] for part in (paths, rigid[:, [0, -1]], pins))
        flat = np.concatenate([part.reshape(-1, 2) for part in (bent, straight, joints)])
        low, (width, height) = flat.min(axis=0), np.ptp(flat, axis=0) * scale
        lines = [_line((path - low) * scale, "still") for path in straight]
        lines += [_line((joints.reshape(-1, 2)[bar] - low) * scale, "axis") for bar in reading.bars if bar]
        lines += [_line((path - low) * scale, f"curve s{i % 6}") for i, path in enumerate(bent)]
        for name, (x, y) in zip(reading.joints, (joints[:, 1] - low) * scale):
            lines += [tag("circle", cx=f"{x:.1f}", cy=f"{y:.1f}", r=4, class_="point")]
            lines += [tag("text", name, x=f"{x + 6:.1f}", y=f"{y - 6:.1f}", class_="value")]
        box = f"{(width - WIDE) / 2 - 24:.0f} -24 {WIDE + 48} {height + 40:.0f}"
        picture = tag("svg", *lines, viewBox=box, role="img")
        drawings.append(tag("figure", picture, tag("figcaption", f"{view[0]} to the right, {view[1]} up")))
    return tag("section", tag("h2", "Views ", tag("small", said)), tag("div", *drawings), class_="card stills")


def _line(points: Array, look: str) -> Html:
    return tag("polyline", points=" ".join(f"{x:.1f},{y:.1f}" for x, y in points), class_=look)


def _tables(reading: SpatialReading) -> Html:
    """Tabulate members and joints."""
    if not reading.members:
        return EMPTY
    head = [*members_head(reading), "length", "section<", "material<"]
    stated = reading.scene.members()
    left = [not n or text.endswith("<") for n, text in enumerate(head)]
    rows = []
    for cells in member_rows(reading):
        i = reading.members.index(cells[0])
        member = stated[cells[0]][1]
        more = [reading.units.text(reading.lengths[i], "length"), member.section, member.material]
        rows.append(line([*cells, *more], left, head, data_member=i))
    return join([tag("section", tag("h2", "Members"), table(head, rows), class_="card"), _joints(reading)])


def _joints(reading: SpatialReading) -> Html:
    head, rows, _ = joint_table(reading)
    return tag("section", tag("h2", "Joints"), table(head, rows), class_="card") if rows else EMPTY


def _dynamics(reading: SpatialReading) -> Html:
    """Give the cards of joint forces, drives, frequencies and stability."""
    data, cards = reading.data, []
    if reading.moves and reading.joints:
        cards.append(card("Joint forces", "", "joint-forces"))
    for n in range(len(reading.drives) if reading.moves else 0):
        cards.append(card(sentence(effort_words(reading, n)[0]), "", f"effort-{n}"))
    if ranges := reading.frequency_ranges:
        rows = [[str(mode), short(low), short(high)] for mode, (low, high) in enumerate(ranges, 1)]
        plot = "frequency" if reading.moves else ""
        cards.append(card("Natural frequencies", "", plot, table(["mode", "lowest, Hz", "highest, Hz"], rows)))
    if "multiplier" in data:
        said = "Each point is what one cycle leaves of a small disturbance. Inside the circle it dies out."
        names = "multiplier", "multiplier_frequency", "growth_rate"
        rows = [[str(n), *map(short, map(float, row))] for n, row in enumerate(zip(*(data[name] for name in names)), 1)]
        more = table(["disturbance", "multiplier", "frequency, Hz", "growth, 1/s"], rows)
        cards.append(card("Stability", "", "stability", join([tag("p", said, class_="hint"), more])))
    return tag("div", *cards, class_="two") if cards else EMPTY


def _computed(reading: SpatialReading) -> Html:
    """Tell how it was computed, and how exact it is by quantity and source."""
    rows = [(sentence(name), text) for name, text in remaining(reading) if not name.startswith("error")]
    first = tag("section", tag("h2", "How it was computed"), table(["", ""], rows, class_="plain"), class_="card")
    data = reading.data
    sources = [str(source) for source in data["source"].to_numpy()] if "source" in data else []
    wrong = []
    for name, words in ERRORS.items():
        if (variable := f"{name}_relative_error") in data:
            parts = [float(part) for part in data[variable]]
            wrong.append([sentence(words), *map(percent, parts), percent(sum(parts))])
    lead = "Estimated errors over the largest of each quantity, by an answer of finer elements and one of finer steps."
    head = ["", *(SOURCES.get(source, source) for source in sources), "in all"]
    errors = (
        join([tag("p", lead, class_="lead"), table(head, wrong)])
        if wrong
        else tag("p", "No error was estimated.", class_="lead")
    )
    return tag("div", first, tag("section", tag("h2", "How exact it is"), errors, class_="card"), class_="two last")


def _payload(reading: SpatialReading) -> dict[str, Any]:
    """Give what the script draws."""
    angle = np.mod(np.round(reading.theta, 12), TURN)
    order = np.arange(len(angle)) if reading.in_time else np.argsort(angle, kind="stable")
    kind = "time" if reading.in_time else "turn" if reading.moves else "still"
    seconds = float(np.ptp(reading.time)) if reading.in_time else reading.scene.period if reading.scene.drives else None
    peaks = [reading.peak(reading.stress, i) for i in range(len(reading.members))]
    rigid, pins = reading.paths(0.0), reading.joint_points(0.0)
    force = reading.values("section_force", "member", "s", "section_axis") / reading.units.size("force")
    arrays = {
        "stress": reading.stress,
        "ends": rigid[:, :, [0, -1]],
        "bent": reading.paths(1.0) - rigid,
        "pins": pins,
        "pins_bent": reading.joint_points(1.0) - pins,
        "force": reading.values("joint_force", "joint", "component") / reading.units.size("force"),
        "size": reading.force,
        "frequency": reading.values("frequency", "mode"),
        "axial": force[..., 0],
        **{f"moment_{n}": reading.moments[..., n] for n in range(3 if reading.members else 0)},
        **{f"effort_{n}": reading.efforts[:, n] for n in range(len(reading.drives))},
    }
    rates = reading.data["multiplier"].to_numpy() if "multiplier" in reading.data else np.zeros(0)
    phase = TURN * reading.scene.period * reading.data["multiplier_frequency"].to_numpy() if len(rates) else rates
    multipliers = np.concatenate([rates * np.exp(sign * 1j * phase) for sign in (1, -1)])
    return {
        "title": reading.scene.name,
        "units": {kind: reading.units.label(kind) for kind in KINDS},
        "upwards": True,
        "kind": kind,
        "axis": reading.time.round(9).tolist() if reading.in_time else np.degrees(angle[order]).round(4).tolist(),
        "seconds": seconds,
        "direction": -1 if reading.scene.cycle_rate < 0 and not reading.in_time else 1,
        "joints": reading.joints,
        "kinds": [reading.scene.joints[name].kind for name in reading.joints],
        "members": reading.members,
        "fibres": [""] if reading.members else [],
        "ends": [list(ends) for ends in reading.ends],
        "s": reading.s.tolist(),
        "lengths": [reading.units.number(length, "length") for length in reading.lengths],
        "peaks": [[int(np.flatnonzero(order == k)[0]), j, 0] for k, _, j in peaks],
        "magnify": reading.magnify,
        "sections": _sections(reading) if reading.members else {},
        "efforts": [[reading.drives[n], effort_words(reading, n)[2]] for n in range(len(reading.drives))],
        "freedoms": [],
        "bars": reading.bars,
        "ground": [list(place) for place in reading.scene.ground.points.values()],
        "multipliers": np.stack([multipliers.real, multipliers.imag], axis=1).round(6).tolist(),
        "arrays": {
            name: packed(values[order], DRAWN if name.startswith("b") else STEPS)
            for name, values in arrays.items()
            if values[0].size
        },
    }
