"""Tables of the page: members, joints, frequencies, effects, errors, and how the result was computed."""

from __future__ import annotations

import json
import math

import numpy as np

from fenics_mech._constants import ROUNDING, TINY
from fenics_mech.effects import EFFECTS
from fenics_mech.errors import percent
from fenics_mech.recovery import Result
from fenics_mech.views.details import decisions, energy
from fenics_mech.views.judgements import SOURCES, unstated_gravity
from fenics_mech.views.law_figures import law_efforts
from fenics_mech.views.page.html import EMPTY, Html, join, line, table, tag
from fenics_mech.views.reading import ForceReading, Reading, change_by_vibration
from fenics_mech.views.rigid_report import friction_lines, rigid_decisions, rigid_energy, running_lines
from fenics_mech.views.words import share, short

DECADES = 4  # of the bars of effects, up to 100 %
LEAST_TOP = 0.05  # of the bars of errors
ON_FRAME = "on the frame"
SHOWN = ("drive", "effects")  # elsewhere on the page


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
