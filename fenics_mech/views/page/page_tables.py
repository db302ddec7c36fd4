"""Tables of the page: members, joints, frequencies, effects, errors, safety, critical speeds, load cases."""

from __future__ import annotations

import json
import math

import numpy as np

from fenics_mech._constants import ROUNDING, TINY
from fenics_mech.effects import EFFECTS
from fenics_mech.errors import percent
from fenics_mech.recovery import Result
from fenics_mech.safety import KEYS, Check, judge
from fenics_mech.safety.critical_speeds import (
    CriticalSpeed,
    cause_of,
    critical_speeds,
    multiplier_distances,
    speeds_to_avoid,
)
from fenics_mech.safety.critical_speeds import turns as speed_of
from fenics_mech.safety.load_cases import ENVELOPE, envelope
from fenics_mech.views.case_tables import case_lines, case_words, member_lines
from fenics_mech.views.details import decisions, energy, friction_lines, rigid_decisions, rigid_energy, running_lines
from fenics_mech.views.judgements import SOURCES, unstated_gravity
from fenics_mech.views.motion_figures import law_efforts
from fenics_mech.views.page.html import EMPTY, Html, join, line, table, tag
from fenics_mech.views.reading import ForceReading, Reading, change_by_vibration
from fenics_mech.views.safety_words import acting, band_of, factor, rise_of, runs_in, speeds_in_words
from fenics_mech.views.words import MINUS, share, short

DECADES = 4  # of the bars of effects, up to 100 %
LEAST_TOP = 0.05  # of the bars of errors
ON_FRAME = "on the frame"
SHOWN = ("drive", "effects")  # elsewhere on the page
MEANING = (
    "Speeds ({}) at which 1, 2, 3 and more times the drive's rate meets a mode; in bold where vibration then adds much "
    "strain. Running: the mean frequency about the motion. Spin and axial forces are taken to grow with the square of "
    "the speed, and deflections to stay small."
)
LEAD = (
    "The largest of each load case, the least safe case first. The safety below is of all cases. Drawing, curves and "
    "the other numbers below are of case {}, which governs; each other case has a page of its own."
)


def members(reading: Reading) -> Html:
    """Tabulate peak stress, strain and deflection of each member, the most stressed first."""
    stress, strain, length = (reading.units.label(kind) for kind in ("stress", "strain", "length"))
    data, more = reading.result.data, dict[str, list[str]]()
    if "stress_range" in data:
        largest = data["stress_range"].max(("s", "fibre")).to_numpy() / reading.units.size("stress")
        more[f"stress range, {stress}"] = [short(float(value)) for value in largest]
    if "utilisation" in data:
        used = data["utilisation"].to_numpy()
        more["of strength"] = [share(float(value)) if np.isfinite(value) else "\N{EN DASH}" for value in used]
    wrong = ["\N{EN DASH}"] * len(reading.members)
    if "strain_error" in data:
        total = data["strain_error"].sum("source").to_numpy() / np.maximum(data["largest_strain"].to_numpy(), TINY)
        wrong = [share(float(value)) for value in total]
    head = ["member", f"peak stress, {stress}", f"strain, {strain}", "where<", "at", *more]
    head += [f"deflection, {length}", "where<", "error of strain"]
    left = [not i or text.endswith("<") for i, text in enumerate(head)]
    top, rows = max(float(np.abs(reading.stress).max()), TINY), []
    for i in reading.ranked:
        peak, bent = reading.peaks[i], reading.peak(reading.bent, i)
        value = reading.stress[peak]
        width = f"width:{100 * abs(value) / top:.1f}%"
        cells = [
            reading.members[i],
            join([short(value), tag("span", tag("i", style=width), class_="bar", aria_hidden="true")]),
            short(reading.strain[peak]),
            f"{reading.place(peak)}, {reading.side(peak)}",
            reading.at(peak.k),
            *(cells[i] for cells in more.values()),
            short(reading.bent[bent]),
            reading.place(bent),
            wrong[i],
        ]
        rows.append(line(cells, left, head, data_member=i))
    return table(head, rows, id="members")


def joints(reading: ForceReading) -> Html:
    """Tabulate the joints' largest forces and that on the frame, beside the frame of their paths."""
    if not reading.joints:
        return EMPTY
    unit = reading.units.label("force")
    head = ["joint", f"largest force, {unit}", "at", f"in x, {unit}", f"in y, {unit}"]
    force = reading.of("joint_force", "joint", "component") / reading.units.size("force")
    ranked = np.argsort(-reading.force.max(axis=0), kind="stable")
    curves = [(reading.joints[n], force[:, n]) for n in ranked]
    curves += [(ON_FRAME, reading.shaking[0])] if reading.shaking is not None else []
    rows = []
    for name, curve in curves:
        size = np.linalg.norm(curve, axis=-1)
        k = int(size.argmax())
        parts = np.where(np.abs(curve[k]) > ROUNDING * size[k], curve[k], 0.0)  # what is rounding is 0
        rows.append([name, short(float(size[k])), reading.at(k), *(short(float(part)) for part in parts)])
    lead = (
        "The force of each joint's first body on its second, and of the mechanism on the frame, as the path of its "
        "arrow's tip: fixed frame, x to the right, y up. Each has its own scale, and the ring is its largest."
    )
    live = (tag("p", lead, class_="lead"), tag("div", id="forces", class_="polar"))
    shown = tag("div", *live, class_="live") if len(reading.theta) > 1 else EMPTY
    efforts = law_efforts(reading.result, reading.units)
    of_laws = [[one.law, one.joint, one.kind, f"{short(one.largest)} {one.unit}"] for one in efforts]
    heads = ["joint law", "joint<", "kind<", "largest, between the positions too"]
    laws = table(heads, of_laws) if efforts else EMPTY
    return tag("section", tag("h2", "Joint forces"), shown, table(head, rows), laws, class_="card")


def frequencies(reading: ForceReading) -> Html:
    """Tabulate the range of each natural frequency."""
    data = reading.result.data
    frequency, wrong = data["frequency"].transpose("theta", "mode").to_numpy(), data["frequency_error"].to_numpy()
    rows = [
        [str(mode), short(low), short(high), share(float(error))]
        for mode, low, high, error in zip(data["mode"].to_numpy(), frequency.min(axis=0), frequency.max(axis=0), wrong)
    ]
    return table(["mode", "lowest, Hz", "highest, Hz", "error by the mesh"], rows)


def effects(result: Result) -> Html:
    """Tabulate the effects that act or were estimated: their size on a logarithmic scale, and what was done."""
    listed = json.loads(result.data.attrs["effects"])
    least = result.scene.neglected / 2
    estimated = any(e["size"] is not None for e in listed)
    held = {EFFECTS[e["name"]].replaces for e in listed if e["acts"] and e["name"] in EFFECTS}
    rows = []
    for e in sorted(listed, key=lambda e: (not e["acts"], -(e["size"] or 0))):
        if not e["acts"] and e["size"] is None:
            continue
        done = "on" if e["acts"] else "contained in another" if e["name"] in held else "left out"
        meaning = EFFECTS[e["name"]].meaning if e["name"] in EFFECTS else ""
        lacking = f"; lacks {e['lacking']}" if e["lacking"] else ""
        name = join([e["name"], tag("small", f"{meaning}{lacking}")])
        done = "not stated in the scene" if unstated_gravity(result, e["name"]) else done
        rows.append([name, *_size(e["size"], least, estimated), done])
    said = "The scene lists its effects, so none was estimated. With effects = 'auto' the program estimates them."
    if estimated:
        said = (
            "The program estimated from above by how much each effect changes the strains anywhere, and took those "
            f"above {percent(least)} (the line). The scale is logarithmic, from 0.01 % to 100 %."
        )
        if (solved := change_by_vibration(result)) is not None:
            said += f" As solved, vibration changes the peak stress by {share(solved)}."
    head = ["effect", "changes the strains by at most<", "", "done<"] if estimated else ["effect", "done<"]
    return join([tag("p", said, class_="lead"), table(head, rows, class_="effects")])


def _size(size: float | None, least: float, estimated: bool) -> list[str]:
    """Cells of the size of an effect: a bar, and words."""
    if not estimated:
        return []
    if size is None:
        return ["", "\N{EN DASH}"]
    on_scale = (min(max((math.log10(max(value, TINY)) + DECADES) / DECADES, 0.0), 1.0) for value in (size, least))
    filled, mark = on_scale
    bars = (tag("i", style=f"width:{100 * filled:.1f}%"), tag("u", style=f"left:{100 * mark:.1f}%"))
    words = "nothing" if size == 0 else "not bounded" if size >= 1 else share(size)
    return [tag("span", *bars, class_="size", aria_hidden="true"), words]


def errors(reading: Reading) -> Html:
    """Show the estimated errors of the members' strains by source, as bars and numbers."""
    data = reading.result.data
    if "strain_error" not in data:
        return tag("p", "No error was estimated.", class_="lead")
    sources = [SOURCES.get(str(source), str(source)) for source in data["source"].to_numpy()]
    wrong = data["strain_error"].transpose("member", "source").to_numpy()
    shares = np.nan_to_num(wrong / np.maximum(data["largest_strain"].to_numpy(), TINY)[:, None], posinf=1.0)
    top = max(LEAST_TOP, float(shares.sum(axis=1).max()))
    rows = []
    for name, parts in zip(reading.members, shares):
        bars = [
            tag("i", class_=f"c{n % 6}", style=f"width:{100 * part / top:.2f}%", title=f"{source}: {share(part)}")
            for n, (source, part) in enumerate(zip(sources, parts))
        ]
        rows.append([name, tag("span", *bars, class_="stack"), share(float(parts.sum()))])
    key = [tag("li", source, class_=f"c{n % 6}") for n, source in enumerate(sources)]
    lead = "Estimated error of the strains by its sources, as a share of each member's largest strain."
    return join([tag("p", lead, class_="lead"), tag("ul", *key, class_="key"), table(["member", "<", "in all"], rows)])


def method(reading: ForceReading) -> Html:
    """Tabulate how the result was computed, and its balance of power."""
    result, bends = reading.result, isinstance(reading, Reading)
    decided = decisions(result, reading.units) if bends else rigid_decisions(result, reading.units)
    known = {key: text for key, text in decided.items() if key not in SHOWN}
    rows = {**known, "version": f"fenics_mech {result.data.attrs['fenics_mech']}"}
    if "mean_power" in result.data:
        rows["power"] = energy(result) if bends else rigid_energy(result)
    if "freedom_rate" in result.data and (lines := running_lines(result)):
        rows["freedoms"] = "; ".join(lines)
    if "friction_used" in result.data:
        rows["friction at rest"] = " ".join(friction_lines(result, reading.units))
    if "frequency" in result.data and "assurance" in result.data:
        rows["modes followed"] = f"lowest MAC between positions {short(float(result.data['assurance'].min()))}"
    return table(["", ""], list(rows.items()), class_="plain")


def safety(reading: Reading) -> Html:
    """Tabulate factors of safety by member and mode, the least safe member first."""
    found = judge(reading.result)
    known = {check.mode for checks in found.checks.values() for check in checks if check.known}
    modes, rows = [mode for mode in KEYS if mode in known], []
    for member, checks in found.checks.items():
        by_mode = {check.mode: check for check in checks}
        rows.append(tag("tr", tag("th", member, class_="t"), *(_safety_cell(by_mode[mode], reading) for mode in modes)))
    lead = (
        "Factors of safety over the cycle, and below them what acts of what is borne. Red: less than is wanted. "
        "Hatched: it rests on an assumed grade, pin or limit, and does not decide."
    )
    lead += " Of several load cases it is that of the worst, which is named." if reading.result.cases else ""
    lists = [_list("Taken as, where the scene does not say", found.assumed), _list("Not judged", found.missing)]
    body = table(["member", *(f"{mode}<" for mode in modes)], rows, class_="safety")
    return tag("section", tag("h2", "Safety"), tag("p", lead, class_="lead"), body, *lists, class_="card")


def _safety_cell(check: Check, reading: Reading) -> Html:
    """Write a factor of safety, and what acts of what is borne."""
    if not check.known:
        return tag("td", "\N{EN DASH}", class_="t none", title=check.missing, data_mode=check.mode)
    kind = "bad" if check.share < 1 else "good"
    assumed = "" if check.decides else " assumed"
    return tag(
        "td",
        tag("b", factor(check)),
        tag("span", acting(check, reading.units)),
        tag("small", f"wanted {check.wanted:g}"),
        class_=f"t {kind}{assumed}",
        data_mode=check.mode,
    )


def _list(title: str, texts: tuple[str, ...]) -> Html:
    if not texts:
        return EMPTY
    return tag("p", tag("b", f"{title}: "), "; ".join(texts), ".", class_="hint")


def critical(reading: ForceReading) -> Html:
    """List the nearest speeds to avoid, and tabulate the critical speeds of each mode."""
    result = reading.result
    near = []
    for one in speeds_to_avoid(result):
        level = "warn" if runs_in(result, one) else "note"
        near.append(tag("li", tag("b", band_of(result, one)), _about(reading, one), class_=level))
    nearest = tag("ul", *near, class_="reasons") if near else tag("p", f"To be avoided: {speeds_in_words(result)}.")
    unit = speed_of(result, 1.0).split()[1]
    return join([nearest, tag("p", MEANING.format(unit), class_="hint"), _by_mode(reading)])


def _about(reading: ForceReading, one: CriticalSpeed) -> Html:
    """Say of a critical speed where it is, which mode it is of, and how strong it is."""
    side = "above" if one.distance >= 0 else "below"
    where = f"{speed_of(reading.result, one.speed)}, {percent(abs(one.distance))} {side} the present speed"
    return tag("span", f"Critical at {where}: {cause_of(reading.result, one)}; {rise_of(one)}.")


def _by_mode(reading: ForceReading) -> Html:
    """Tabulate link, frequencies, damping, distance from resonance and critical speeds of each mode."""
    data = reading.result.data
    by_mode: dict[int, dict[float, CriticalSpeed]] = {}
    for one in critical_speeds(reading.result):
        by_mode.setdefault(one.mode, {})[one.order] = one
    modes = sorted(by_mode)
    of_modes = [next(iter(by_mode[mode].values())) for mode in modes]
    near, frequency = multiplier_distances(reading.result), data["mode_frequency"].sel(mode=modes)
    rows = [
        ["link", *(one.link for one in of_modes)],
        ["veers with", *(" ".join(str(other) for other in one.modes if other != one.mode) for one in of_modes)],
        ["held, Hz", *(short(float(value)) for value in frequency.sel(limit="mean"))],
        ["running, Hz", *(short(float(value)) for value in frequency.sel(limit="running"))],
        ["damping ratio", *(percent(one.damping) for one in of_modes)],
        [f"|1 {MINUS} \N{GREEK SMALL LETTER MU}|", *(short(near.get(mode, np.nan)) for mode in modes)],
    ]
    rows = [row for row in rows if any(text.strip("\N{EN DASH}") for text in row[1:])]
    for order in sorted({order for found in by_mode.values() for order in found}):
        found = [by_mode[mode].get(order) for mode in modes]
        cells = [
            EMPTY if one is None else tag("b" if one.band else "span", short(one.speed * 30 / np.pi)) for one in found
        ]
        rows.append([f"{order:g}\N{MULTIPLICATION SIGN}", *cells])
    return table(["", *(f"mode {mode}" for mode in modes)], rows)


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
