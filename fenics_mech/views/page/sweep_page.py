"""A sweep over one number as one page for a browser: what was found, and the curves of each point beside a slider."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.text import Text

from fenics_mech._arrays import Array
from fenics_mech.errors import ViewError
from fenics_mech.scene.answer_units import KINDS
from fenics_mech.views.page.curves import packed
from fenics_mech.views.page.html import EMPTY, Html, join, page_file, table, tag, whole_page, write_page
from fenics_mech.views.sweep_data import named, range_of, units_of, unstable_points, written
from fenics_mech.views.sweep_plots import UNSTABLE
from fenics_mech.views.sweep_summary import sweep_summary
from fenics_mech.views.words import sentence, short

if TYPE_CHECKING:
    from fenics_mech.studies.sweep import Sweep

NO_ANSWER, COARSE = "no answer", "too coarse"  # states of points, with `UNSTABLE`
MESSAGES = {NO_ANSWER: "message", UNSTABLE: "unstable", COARSE: "too_coarse"}  # texts of the sweep that say why
SCRIPTS = ("data.js", "axes.js", "sweep.js")
MOST_ROWS = 200  # of the table of points
SHOWN = {"stress": "stress", "strain": "strain"}  # quantities of members, and the kinds of their units


def can_show(sweep: Sweep) -> bool:
    """Whether a sweep keeps the curves that its page shows."""
    return len(sweep.paths) == 1 and "curve_stress_highest" in sweep.data


def sweep_report(sweep: Sweep, path: str | Path) -> Path:
    """Write a sweep over one number as one HTML file, which needs no network and no other file."""
    path = page_file(path)
    if (sweep.data["error"] != "").all():
        raise ViewError("every point of this sweep failed: `message` of its file says why")
    if not can_show(sweep):
        raise ViewError("this sweep keeps no curves: sweep one number, at up to 2000 points")
    write_page(path, _page(sweep))
    return path


def _page(sweep: Sweep) -> str:
    title = str(sweep.data.attrs["title"])
    x = written(sweep.data, sweep.paths[0])
    over = f"{named(sweep.data, sweep.paths[0])}, {len(x)} points from {short(float(x[0]))} to {short(float(x[-1]))}"
    buttons = tag("button", "\N{CIRCLE WITH RIGHT HALF BLACK}", id="theme", type="button", aria_label="dark or light")
    heading = tag("div", tag("h1", sentence(title)), tag("p", over))
    pieces = {
        "heading": tag("header", heading, tag("div", buttons, class_="tools live"), class_="top"),
        "verdict": _said(sweep),
        "stage": _stage(sweep),
        "points": tag("section", tag("h2", "Points"), _points(sweep), class_="card"),
    }
    return whole_page("sweep.html", f"{title}: sweep of fenics_mech", pieces, _payload(sweep), SCRIPTS)


def _said(sweep: Sweep) -> Html:
    """Say what the summary says."""
    said = [part for part in sweep_summary(sweep).renderables if isinstance(part, Text)][1:]
    levels = {"bold red": "bad", "bold yellow": "warn", "yellow": "warn", "bold green": "good"}
    found = [levels.get(str(part.style), "note") for part in said]
    texts = [part.plain for part in said if not part.plain.startswith("  ")]
    failed = " ".join(part.plain.strip() for part in said if part.plain.startswith("  "))
    texts = [f"{text} {failed}" if text.endswith(" points failed:") else text for text in texts]
    lines = [tag("li", text, class_="bad" if failed in text and failed else level) for text, level in zip(texts, found)]
    worst = next((level for level in ("bad", "warn") if level in found), "good")
    return tag("section", tag("ul", *lines, class_="reasons"), class_=f"verdict {worst}") if lines else EMPTY


def _stage(sweep: Sweep) -> Html:
    """Give the frames of the curves over the swept number, of the slider, and of the curves at its point."""
    members, joints = (
        [tag("option", str(name), value=i) for i, name in enumerate(sweep.data[of].to_numpy())]
        for of in ("member", "joint")
    )
    kinds = [tag("option", name, value=name) for name in SHOWN]
    slider = tag("input", type="range", id="point", min="0", max=str(len(sweep.data[sweep.paths[0]]) - 1), step="1")
    where = tag("label", f"{sweep.paths[0]} ", tag("output", id="value"), slider, class_="grow")
    pick = [tag("label", "member ", tag("select", *members, id="member"))]
    pick += [tag("label", "show ", tag("select", *kinds, id="unit"))]
    over = [_plot("over"), tag("div", where, class_="row"), tag("p", id="state", class_="hint")]
    more = [tag("div", tag("label", "joint ", tag("select", *joints, id="joint")), class_="pick"), _plot("force")]
    more = (more if joints else []) + [_plot("torque")] if "peak_input_torque" in sweep.data else []
    said = tag("noscript", tag("p", "The pictures need JavaScript. The numbers are in the table below."))
    first = tag("section", tag("div", *pick, class_="pick"), *over, _plot("curve"), class_="card live")
    return join([said, first, tag("section", *more, class_="card live")])


def _plot(name: str) -> Html:
    heads = (tag("b", id=f"{name}-title"), " ", tag("span", id=f"{name}-where"))
    return join([tag("h3", *heads), tag("div", id=name, class_="plot")])


def _states(sweep: Sweep) -> list[str]:
    """Say of each point whether it has no answer, or is unstable or too coarse; nothing where all is well."""
    data = sweep.data
    failed, coarse = (data[name].to_numpy().astype(str) != "" for name in ("error", "too_coarse"))
    told = np.where(coarse, COARSE, "")
    return [str(one) for one in np.where(failed, NO_ANSWER, np.where(unstable_points(data), UNSTABLE, told))]


def _points(sweep: Sweep) -> Html:
    """Tabulate the points: peaks, safety, and what is to be said of them."""
    data, path, units = sweep.data, sweep.paths[0], units_of(sweep.data)
    states, rows = _states(sweep), []
    stress = data["peak_stress"].max("member").to_numpy()
    force = data["peak_joint_force"].max("joint").to_numpy() if "peak_joint_force" in data else np.zeros(len(states))
    safety = data["safety_min"].to_numpy() if "safety_min" in data else np.full(len(states), np.nan)
    for k in range(min(len(states), MOST_ROWS)):
        by = " ".join(str(data[f"safety_{name}"].to_numpy()[k]) for name in ("member", "mode"))
        numbers = stress[k] / units.size("stress"), force[k] / units.size("force"), safety[k]
        known = [short(float(value)) for value in numbers]  # a dash where there is none
        rows.append([range_of(data, path, k), *known, by.strip(), states[k] or "stable"])
    head = [path, f"stress ({units.label('stress')})", f"joint force ({units.label('force')})", "safety over wanted"]
    found = table([*head, "by<", "motion<"], rows)
    if len(states) <= MOST_ROWS:
        return found
    return join([found, tag("p", f"The first {MOST_ROWS} of {len(states)} points: sweep.nc has all.", class_="hint")])


def _payload(sweep: Sweep) -> dict[str, Any]:
    """Give what the script of the page draws."""
    data, path, units = sweep.data, sweep.paths[0], units_of(sweep.data)
    slides = "peak_input_torque" in data and data["peak_input_torque"].attrs["units"] == "N"
    effort = ("force", "drive force") if slides else ("moment", "input torque")
    kinds = {"joint_force": "force", "input_torque": effort[0], **SHOWN}
    arrays: dict[str, Array] = {}
    for name, part in data.data_vars.items():
        if str(name).startswith("curve_"):
            kind = next(kind for what, kind in kinds.items() if what in str(name))
            over = part.transpose("curve_theta", path, ...).to_numpy() / units.size(kind)
            arrays[str(name).removeprefix("curve_")] = over.reshape(len(over), -1)
    peaks = {}
    for name, kind in kinds.items():
        if f"peak_{name}" in data:
            over = data[f"peak_{name}"].transpose(path, ...).to_numpy() / units.size(kind)
            peaks[name] = _rounded(over.reshape(len(over), -1))
    states = _states(sweep)
    messages = [str(data[MESSAGES[one]].to_numpy()[k]) if one else "" for k, one in enumerate(states)]
    empty: dict[str, Any] = {name: [] for name in ("members", "fibres", "ends", "lengths", "peaks")}
    return {
        **empty,
        "title": str(data.attrs["title"]),
        "units": {kind: units.label(kind) for kind in KINDS},
        "kind": "turn",
        "axis": np.degrees(data["curve_theta"].to_numpy()).round(4).tolist(),
        "seconds": None,
        "direction": 1,
        "s": [0],
        "sections": {},
        "magnify": 1.0,
        "arrays": {name: packed(values) for name, values in arrays.items()},
        "sweep": {
            "name": named(data, path),
            "values": [float(f"{value:.8g}") for value in written(data, path)],
            "told": [range_of(data, path, k) for k in range(data.sizes[path])],
            "state": states,
            "message": messages,
            "members": [str(name) for name in data["member"].to_numpy()],
            "joints": [str(name) for name in data["joint"].to_numpy()],
            "effort": [effort[1], units.label(effort[0])],
            "peaks": peaks,
        },
    }


def _rounded(values: Array) -> list[list[float | None]]:
    return [[float(f"{value:.4g}") if np.isfinite(value) else None for value in line] for line in values]
