"""A summary of the motion of rigid links that a person can read after a run."""

from __future__ import annotations

import numpy as np
from rich.console import RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from fenics_mech.accuracy.missed_peaks import BETWEEN
from fenics_mech.errors import percent
from fenics_mech.recovery import Result
from fenics_mech.recovery.balance import mean_in_time
from fenics_mech.recovery.peaks import between_positions
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.scene.freedoms import no_torque_speed
from fenics_mech.views.case_tables import cases_table, governed
from fenics_mech.views.details import balanced, damping_of, mean_powers, motion_rows
from fenics_mech.views.force_summary import joints_table, shown
from fenics_mech.views.judgements import judgements, verdict
from fenics_mech.views.law_figures import law_efforts
from fenics_mech.views.tables import drive_of, number, rows_table, table_of
from fenics_mech.views.words import share

SLIDES = ("slot", "prismatic")  # kinds of joints whose freedom is a length
NAMES = {"joint_force": "joint force", "drive_effort": "effort", "freedom_place": "angles and strokes"}  # of errors


def rigid_parts(result: Result, units: AnswerUnits) -> list[RenderableType]:
    """Give the parts of a summary."""
    machine, judged = governed(result) if result.cases else result.scene.name, judgements(result)
    doubts = [f"{verdict(judged)[1]} {one.text}" for one in judged if one.level in ("bad", "warn")]
    parts: list[RenderableType] = [Text(machine, style="bold"), *(Text(text, style="bold yellow") for text in doubts)]
    parts += [Text(f"Warning: {text}", style="yellow") for text in result.warnings]
    parts += [rows_table(rigid_decisions(result, units)), Text()]
    parts += [cases_table(result, units), Text()] if result.cases else []
    if result.data.sizes["joint"]:
        parts.append(joints_table(between_positions(result), units))
        if result.data.attrs.get("contacts_closed"):
            text = "Joint forces are those at the positions. Contacts between these are shorter: see the joint laws.\n"
            parts.append(Text(text, style="yellow"))
    if "law" in result.data.sizes:
        parts.append(law_table(result, units))
    if "freedom" in result.data.sizes:
        parts += [freedoms_table(result, units), *map(Text, running_lines(result))]
    if "friction_used" in result.data:
        parts += map(Text, friction_lines(result, units))
    if "rest_frequency" in result.data:
        parts.append(small_motions_table(result))
    if "mean_power" in result.data:
        parts.append(Text(rigid_energy(result)))
    return parts


def rigid_energy(result: Result) -> str:
    """Tell the mean power of all causes, and how far they are from a balance."""
    (text, (factor, unit)), attributes = mean_powers(result), result.data.attrs
    if balanced(result):
        return f"{text}."
    rest = f"imbalance {number(factor * attributes['power_residual'])} {unit}"
    return f"{text}; {rest} ({attributes['power_balance_error']:.1g} of the largest)."


def rigid_decisions(result: Result, units: AnswerUnits) -> dict[str, str]:
    """Tell how the result was computed."""
    scene, data = result.scene, result.data
    count = data.sizes["theta"]
    rows = {"drive": drive_of(scene, units), "method": f"{scene.analysis.method}, {count} position{'s' * (count > 1)}"}
    rows["links"] = "rigid: no link has a member that bends"
    if data.attrs["time_steps"]:
        rows["steps"] = f"{data.attrs['time_steps']} time steps, tolerance {scene.analysis.time_tolerance:g}"
    known = {what: data.attrs.get(f"{what}_error_estimate") for what in NAMES}
    if (name := "point_acceleration_relative_error") in data:
        known["acceleration"] = float(data[name].sel(source=BETWEEN))
    said = [f"{NAMES.get(what, what)} {share(error)}" for what, error in known.items() if error is not None]
    if said:
        source = "the time steps" if data.attrs["time_steps"] else "peaks between positions"
        rows["error estimate"] = f"by {source}, of the largest: {', '.join(said)}"
    if "not_estimated" in data.attrs:
        rows["error estimate"] = f"NOT known: {data.attrs['not_estimated']}"
    if "contacts_closed" in data.attrs and scene.analysis.method == "transient":
        rows["contacts"] = f"closed {data.attrs['contacts_closed']} times"
    return rows | motion_rows(result, units) | {"damped by": damping_of(scene)}


def law_table(result: Result, units: AnswerUnits) -> Table:
    """Tabulate the largest effort of each joint law."""
    table = table_of("Joint laws", "law", "joint", "kind", "largest\nin the motion")
    for one in law_efforts(result, units):
        table.add_row(escape(one.law), escape(one.joint), one.kind, f"{number(one.largest)} {one.unit}")
    return table


def freedoms_table(result: Result, units: AnswerUnits) -> Table:
    """Tabulate how far each freedom goes, and its fastest rate; of an equilibrium, where it is."""
    places, moves = result.data["freedom_place"].to_numpy(), "freedom_rate" in result.data
    moves = moves and result.scene.analysis.method == "transient"
    heads = ("least", "largest", "at the end", "fastest rate") if moves else ("at rest",)
    table = table_of("Freedoms", "joint", *heads)
    for i, name in enumerate(result.scene.freedoms):
        place = places[:, i]
        cells = [
            _place(result, name, value, units) for value in (place.min(), place.max(), place[-1])[2 * (not moves) :]
        ]
        if moves:
            rates = result.data["freedom_rate"].to_numpy()[:, i]
            unit = "m/s" if result.scene.joints[name].kind in SLIDES else "rad/s"
            cells.append(f"{number(float(rates[np.abs(rates).argmax()]))} {unit}")
        table.add_row(escape(name), *cells)
    return table


def _place(result: Result, name: str, value: float, units: AnswerUnits) -> str:
    """Write the place of a freedom (m, rad) with its unit."""
    if result.scene.joints[name].kind in SLIDES:
        return shown(float(value), "length", units)
    return f"{number(float(np.degrees(value)))} \N{DEGREE SIGN}"


def running_lines(result: Result) -> list[str]:
    """Tell how freedoms run over their last turn, and what their motors take."""
    data, lines = result.data, []
    for name in map(str, data["freedom"].to_numpy()):
        if "last_turn_rate" in data and np.isfinite(rate := float(data["last_turn_rate"].sel(freedom=name))):
            varies = float(data["last_turn_fluctuation"].sel(freedom=name))
            turns = number(rate * 30 / np.pi)
            lines.append(f"Freedom {name}: {turns} rpm over its last turn, where the speed varies by {percent(varies)}")
        if "motor_at" in data.sizes and name in data["motor_at"]:
            taken, time = data["electrical_power"].sel(motor_at=name).to_numpy(), data["time"].to_numpy()
            speed = no_torque_speed(result.scene.freedoms[name].effort)
            given = taken * data["freedom_rate"].sel(freedom=name).to_numpy() / speed
            means = mean_in_time(time, {"taken": taken, "given": given, "heat": taken - given})
            takes, gives, heats = map(number, means.values())
            lines.append(f"Motor at {name}: takes {takes} W, of which {gives} W drive it and {heats} W heat the rotor")
    return lines


def friction_lines(result: Result, units: AnswerUnits) -> list[str]:
    """Tell the range in which friction holds the freedom, and how much of it is used."""
    data, name = result.data, next(iter(result.scene.freedoms))
    ends = [float(data[f"rest_{end}"].sel(freedom=name)) for end in ("lowest", "highest")]
    first, last = ("without limit" if np.isinf(end) else _place(result, name, end, units) for end in ends)
    held = "at all places" if np.isinf(ends).all() else f"from {first} to {last}"
    used = data["friction_used"].dropna("law")
    takes = [(str(law), percent(float(used.sel(law=law)))) for law in used["law"].to_numpy()]
    return [
        f"Friction holds the freedom at joint {name} {held}.",
        *(f"The friction {law} takes {taken} of the most that it can." for law, taken in takes),
    ]


def small_motions_table(result: Result) -> Table:
    """Tabulate the small motions about an equilibrium."""
    table = table_of("Small motions about the equilibrium", "motion", "frequency", "decays by")
    columns = (result.data[what].to_numpy() for what in ("small_motion", "rest_frequency", "rest_decay"))
    for name, frequency, decay in zip(*columns):
        table.add_row(str(name), f"{number(float(frequency))} Hz", f"{number(float(decay))} 1/s")
    return table
