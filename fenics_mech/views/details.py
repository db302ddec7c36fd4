"""All that is known of a result, for a person to read: more than fits a screen."""

from __future__ import annotations

import json

import numpy as np
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from fenics_mech._arrays import Array
from fenics_mech._constants import MILLI, ROUNDING
from fenics_mech.errors import percent, percent_of_error
from fenics_mech.estimate.missed_peaks import BETWEEN
from fenics_mech.estimate.quantities import ERROR_VARIABLES
from fenics_mech.planning.answer_remarks import made_finer
from fenics_mech.recovery import Result
from fenics_mech.recovery.balance import mean_in_time
from fenics_mech.recovery.peaks import between_positions
from fenics_mech.scene import Scene
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.scene.freedoms import no_torque_speed
from fenics_mech.views.case_tables import cases_table, governed
from fenics_mech.views.frequency_views import frequency_table
from fenics_mech.views.judgements import (
    SOURCES,
    acting,
    doubtful_peaks,
    judgements,
    quantities,
    stability,
    theory,
    too_uncertain,
    verdict,
)
from fenics_mech.views.motion_figures import law_efforts
from fenics_mech.views.prefixes import largest_force, least_moment, least_power, prefixed
from fenics_mech.views.reading import change_by_vibration
from fenics_mech.views.safety_words import across_in_words, safety_table
from fenics_mech.views.tables import drive_of, number, rows_table, table_of
from fenics_mech.views.words import MINUS, sentence, share

ON_FRAME = "shaking: total on the frame; the moment is about the ground's origin"
CLEAR = 5.0  # natural logarithm of a growth in half of a motion, from which on neighbours part exponentially
STEADY = 0.5  # of an exponent, by which it may change between the last two quarters
PLACE = "s: place along the member, from 0 to 1; sides: + is the one that the member's normal points to"
BETWEEN_STATIONS = 1e-3  # excess of a strain over that at the stations: four digits are printed
MOST_HARMONICS = 4  # of each member: more do not fit a line of 80 columns
WATTS = 1.0  # power from which watts are written, and milliwatts below (W)
ROUNDED = 1e-9  # of the largest harmonic or power, below which others are rounding; of errors too
WARNED = {"bad": "bold red", "warn": "bold yellow"}
SLIDES = ("slot", "prismatic")  # kinds of joints whose freedom is a length
NAMES = {"joint_force": "joint force", "drive_effort": "effort", "freedom_place": "angles and strokes"}  # of errors


def joints_table(result: Result, units: AnswerUnits, force: float = 0.0) -> Table:
    """Tabulate the peaks of the joint forces, the torque or force of the first drive, and the total on the frame."""
    # force: largest force in the links (N), beside which joints may have none but rounding
    data = result.data
    table = table_of("Peaks of the joint forces", "joint", "peak", at_head(result))
    forces = np.linalg.norm(values_of(result, "joint_force", "theta", "joint", "component"), axis=-1)
    peaks = [(escape(str(joint)), force, "force") for joint, force in zip(data["joint"].to_numpy(), forces.T)]
    if "input_torque" in data and (result.scene.drives or data["input_torque"].any()):
        name, kind = effort_of(result)
        peaks.append((name, data["input_torque"].to_numpy(), kind))
    if "shaking_force" in data:
        total = np.linalg.norm(values_of(result, "shaking_force", "theta", "component"), axis=-1)
        peaks += [("shaking force", total, "force"), ("shaking moment", data["shaking_moment"].to_numpy(), "moment")]
        table.caption = f"{ON_FRAME}\n"
    largest = max([force, *(float(np.abs(curve).max()) for _, curve, _ in peaks)])
    for name, curve, kind in peaks:
        (k,) = peak_of(curve)
        nothing = abs(curve[k]) < ROUNDING * largest
        table.add_row(name, shown(0.0 if nothing else curve[k], kind, units), "" if nothing else at(result, k))
    return table


def shown(value: float, kind: str, units: AnswerUnits) -> str:
    """Write a value in SI with its unit."""
    return f"{number(units.number(value, kind))} {units.label(kind)}"


def effort_of(result: Result) -> tuple[str, str]:
    """Name what the first drive gives, or the effort in the first freedom, and its kind of unit."""
    slides = str(result.data["input_torque"].attrs["units"]) == "N"
    if not result.scene.drives:
        return "effort", "force" if slides else "moment"
    return ("drive force", "force") if slides else ("input torque", "moment")


def drive_lines(result: Result, units: AnswerUnits) -> list[Text]:
    """Tell the root mean square of the first drive's effort, and the fluctuation of the energy that all drives give."""
    data = result.data
    if "drive_effort_rms" not in data or float(data["drive_effort_rms"].max()) <= least_moment(result):
        return []
    name, kind = effort_of(result)
    text = f"{sentence(name)}: {shown(float(data['drive_effort_rms'][0]), kind, units)} root mean square"
    text += f"; the energy given fluctuates by {number(data.attrs['energy_fluctuation'])} J over the cycle"
    if "speed_fluctuation" in data.attrs:
        text += f", and the speed of the crank by {percent(data.attrs['speed_fluctuation'])} of its mean"
    return [Text(f"{text}.")]


def values_of(result: Result, name: str, *dimensions: str) -> Array:
    """Give the values of a variable with its dimensions in an order."""
    return np.asarray(result.data[name].transpose(*dimensions).to_numpy())


def degrees_of(result: Result) -> Array:
    """Drive angles of a result, 0 to below 360 (deg), ``(angles,)``."""
    return np.degrees(result.data["theta"].to_numpy()) % 360


def at_head(result: Result) -> str:
    """Head of a column of drive angles, or of times of a motion in time."""
    return "at time" if result.scene.analysis.method == "transient" else "at angle"


def at(result: Result, k: int) -> str:
    """Write the drive angle of a position to a degree, or its time in a motion in time."""
    if result.scene.analysis.method == "transient":
        return f"{float(result.data['time'][k]):.4g} s"
    angles = degrees_of(result)
    return f"{angles[k] if len(angles) == 1 else round(angles[k]) % 360:.4g}\N{DEGREE SIGN}"


def peak_of(curves: Array) -> tuple[int, ...]:
    """Index of the value of largest magnitude."""
    return tuple(int(i) for i in np.unravel_index(np.abs(curves).argmax(), curves.shape))


def motion_rows(result: Result, units: AnswerUnits) -> dict[str, str]:
    """Give rows for the table of decisions: whether the motion repeats, how motions beside it part, what rings on."""
    rows, data = {}, result.data
    if "repeats_after" in data.attrs:
        kind = "a period of its own" if data.attrs["own_period"] else "the period of what acts"
        rows["repeats"] = (
            f"after {number(data.attrs['repeats_after'])} s, {kind}; it misses its start by "
            f"{percent(data.attrs['closing_error'])}"
        )
        rows["stability"] = _stability(result)
    if "lyapunov_exponent" in data:
        rows["disturbances"] = _exponents(result)
    if "residual_vibration" in data:
        sizes = data["residual_vibration"].transpose("dwell", "member").to_numpy()
        worst = [(str(data["member"][row.argmax()].item()), float(row.max())) for row in sizes]
        said = [
            f"{member} {shown(size, 'length', units)} {dwell}"
            for dwell, (member, size) in zip(data["dwell"].to_numpy(), worst)
        ]
        rows["swings on"] = ", ".join(said)
    if "section_time" in data:
        rows["section"] = f"{data.sizes['section_point']} points"
    return rows


def _stability(result: Result) -> str:
    """Tell what is left of a small disturbance after a cycle."""
    if "multiplier" not in result.data:
        return "not known, as bodies touch or rub"
    sizes = np.hypot(*result.data["multiplier"].transpose("part", "disturbance").to_numpy())
    values = result.data["multiplier"].transpose("disturbance", "part").to_numpy() @ [1.0, 1.0j]
    if result.data.attrs["own_period"]:  # one along the motion itself neither grows nor decays
        sizes = np.delete(sizes, int(np.abs(values - 1).argmin()))
    return f"{percent(float(sizes.max(initial=0.0)))} of a small disturbance is left after each cycle"


def _exponents(result: Result) -> str:
    """Tell the largest Lyapunov exponent, and whether the motion is chaotic."""
    largest, change = (float(result.data[name][0]) for name in ("lyapunov_exponent", "lyapunov_change"))
    half = float(np.ptp(result.data["time"].to_numpy())) / 2
    text = f"largest Lyapunov exponent {number(largest)} 1/s, which changes by {number(change)} 1/s between quarters"
    if largest * half > CLEAR and change < STEADY * largest:
        return f"{text}: the motion is CHAOTIC. After some {3 / largest:.2g} s only its statistics can be compared"
    if largest * half > CLEAR:
        return f"{text}: neighbours part, and a longer motion tells whether for ever"
    return f"{text}: no sign of chaos"


def details(result: Result, units: AnswerUnits | None = None) -> Group:
    """Tell all that is known of a result; it needs 80 columns."""
    # First how it was computed. Then the peaks with the drive angle (degrees) and the place (s, 0..1) where they occur:
    # strain, stress and deflection of each member, force of each joint, input torque. Then the range of each mode's
    # frequency, stability, the balance of power, the limits of the theory, and warnings.
    units = prefixed(result, units or result.scene.answer_units)
    machine = governed(result) if result.cases else result.scene.name
    parts: list[RenderableType] = [Text(machine, style="bold"), rows_table(decisions(result, units)), Text()]
    parts += [cases_table(result, units), Text()] if result.cases else []
    closer = between_positions(result)
    parts += [_members(closer, units), *map(Text, _of_members(result, units)), Text("Factors of safety:")]
    parts += [*map(Text, safety_table(result, units))]
    if result.data.sizes["joint"]:
        parts += [joints_table(closer, units, largest_force(result)), *drive_lines(result, units)]
    parts += [*map(Text, filter(None, [doubtful_peaks(result)])), *_signal(result, units)]
    if "frequency" in result.data:
        frequency, assurance = (values_of(result, name, "theta", "mode") for name in ("frequency", "assurance"))
        parts.append(frequency_table(frequency, assurance, values_of(result, "frequency_error", "mode")))
        if any(effect.nonlinear for effect in acting(result)):
            parts.append(Text("These frequencies leave out the axial forces in the links."))
    parts += [Text(f"Frequencies: {across}.")] if (across := across_in_words(result)) else []
    if "mean_power" in result.data:
        parts.append(Text(energy(result)))
    for judged in filter(None, (stability(result), theory(result))):
        parts.append(Text(f"{sentence(judged.title)}: {judged.text}", style=WARNED.get(judged.level, "")))
    return Group(*parts, *(Text(f"Warning: {text}", style="bold yellow") for text in result.warnings))


def energy(result: Result) -> str:
    """Tell the mean power of drives, loads and damping, and how far they are from a balance."""
    residual, error, bound = (result.data.attrs[f"power_{name}"] for name in ("residual", "balance_error", "error"))
    text, (factor, unit) = mean_powers(result)
    rest = f"{number(0.0 if balanced(result) else factor * residual)} {unit}"
    if not any(effect.couples for effect in acting(result)):
        return f"{text}. The rest, {rest}, is no error: the equation leaves out the coupling, and with it this power."
    if balanced(result):
        return f"{text}."
    text = f"{text}; imbalance {rest} ({error:.1g} of the largest)"
    if abs(residual) > bound and error > ROUNDED:
        text += f", MORE than the {number(factor * bound)} {unit} that the estimated errors of the drives explain"
    return f"{text}."


def mean_powers(result: Result) -> tuple[str, tuple[float, str]]:
    """Tell the mean power of every cause; then the factor from watts and the unit."""
    data = result.data
    power = {str(cause): float(value) for cause, value in zip(data["cause"].to_numpy(), data["mean_power"].to_numpy())}
    whole = "motion" if result.scene.analysis.method == "transient" else "cycle"
    largest = max(map(abs, power.values()), default=0.0)
    factor, unit = (1.0, "W") if largest >= WATTS else (MILLI, "mW")
    least = max(ROUNDED * largest, least_power(result))
    parts = [f"{cause} {number(factor * value)} {unit}" for cause, value in power.items() if abs(value) >= least > 0]
    return f"Mean power over the {whole}: {', '.join(parts) or 'none'}", (factor, unit)


def balanced(result: Result) -> bool:
    """Whether the powers of a result are in balance but for rounding."""
    attributes = result.data.attrs
    nothing = abs(attributes["power_residual"]) <= least_power(result)
    return nothing or attributes["power_balance_error"] <= ROUNDED


def decisions(result: Result, units: AnswerUnits | None = None) -> dict[str, str]:
    """Tell how the result was computed: method, solver, modes, errors, damping, effects, mesh."""
    scene, analysis = result.scene, result.scene.analysis
    rows = {"drive": drive_of(scene, units), "method": f"{analysis.method}, {result.data.sizes['theta']} positions"}
    if analysis.method == "periodic":
        solver = rows["solver"] = str(result.data.attrs["solver"])
        if solver == "harmonic-balance":
            rows["solver"] = f"{solver}, {analysis.harmonics} harmonics"
        elif solver != "sub-intervals":
            rows["solver"] = f"{solver}, {analysis.stages} Radau points per step"
    if result.data.attrs.get("solver") == "sub-intervals":
        rest = "the others follow the load statically" if analysis.static_correction else "the others are left out"
        rows["joining"] = f"{analysis.join} continuity between sub-intervals, {analysis.load} load in each"
        rows["modes"] = f"{result.data.sizes['mode']} kept, {rest}"
    known = "error_estimate" in result.data.attrs
    rows["error estimate"] = _errors(result) if known else "none, as analysis.error_estimates = false"
    if np.isfinite(result.data.attrs.get("cycle_change", np.inf)):
        rows["last cycle"] = f"differs from the one before by {percent(result.data.attrs['cycle_change'])}"
    rows |= motion_rows(result, units or scene.answer_units)
    rows["damped by"] = damping_of(scene)
    rows["effects"] = _effects(result)
    rows |= {"assumed": "; ".join(result.notices)} if result.notices else {}
    rows["mesh"] = f"{result.data.attrs['elements']} elements, {result.data.attrs['dofs']} degrees of freedom"
    if "refined" in result.data.attrs:
        rows["mesh and steps"] = f"{made_finer(result)} Else {result.data.attrs['refined_because']}"
    if "chosen" in result.data.attrs:
        rows["tolerance"] = str(result.data.attrs["chosen"])
    return rows


def _errors(result: Result) -> str:
    """Tell the largest relative error of each quantity, and that of the strains by source."""
    data, parts, wrong = result.data, [], too_uncertain(result)
    for what, name in quantities(result).items():
        prefix = ERROR_VARIABLES[what][1]
        error = float(data.attrs[f"{prefix}error_estimate"])
        text = f"{name} {percent_of_error(error)}" if error >= ROUNDED else f"{name} below 1e-7 %"
        parts.append(text + (" (TOO LARGE, do not use it)" if name in wrong else ""))
    by_source = zip(data["source"].to_numpy(), data["relative_error"].to_numpy())
    shares = [
        f"{SOURCES.get(source, source)} {percent_of_error(error)}"
        for source, error in by_source
        if not error < ROUNDED  # what is not known is told
    ]
    text = "; of the strain: ".join([", ".join(parts), *filter(None, [", ".join(shares)])])
    if "not_estimated" in data.attrs:
        text += f"; NOT included: {data.attrs['not_estimated']}"
    return text + (": TOO LARGE, do not use these numbers" if data.attrs["too_coarse"] else "")


def _effects(result: Result) -> str:
    """Name the effects that act, with their influence on the strains where it was estimated."""
    effects = json.loads(result.data.attrs["effects"])
    chosen = [e["name"] + ("" if e["size"] is None else f" ({percent(e['size'])})") for e in effects if e["acts"]]
    limit = "; the share is what linear strains would leave out"
    estimated = any(e["size"] is not None for e in effects)
    solved = change_by_vibration(result)
    limit += "" if solved is None else f". Vibration changes the peak stress by {share(solved)}, as solved"
    return (", ".join(chosen) or "none") + (limit if estimated else "")


def _members(result: Result, units: AnswerUnits) -> Table:
    """Tabulate the peak stress, with its strain, and the peak deflection of each member."""
    strain_head, stress_head, bent_head = (
        f"{name}\n({units.label(kind)})"
        for name, kind in (("strain", "strain"), ("stress", "stress"), ("deflection", "length"))
    )
    columns = "member", strain_head, stress_head, f"{at_head(result)},\ns, side", bent_head, f"{at_head(result)},\ns"
    table = table_of("Peaks of the members", *columns, caption=f"{PLACE}\n")
    s = result.data["s"].to_numpy()
    fibres = [str(fibre).replace("-", MINUS) for fibre in result.data["fibre"].to_numpy()]
    strain, stress = (values_of(result, name, "theta", "member", "s", "fibre") for name in ("strain", "stress"))
    deflection = np.linalg.norm(values_of(result, "deflection", "theta", "member", "s", "component"), axis=-1)
    for i, member in enumerate(result.data["member"].to_numpy()):
        k, place, fibre = peak_of(stress[:, i])
        bent, station = peak_of(deflection[:, i])
        table.add_row(
            escape(str(member)),
            number(units.number(strain[k, i, place, fibre], "strain")),
            number(units.number(stress[k, i, place, fibre], "stress")),
            f"{at(result, k)}, {s[place]:.3g}, {fibres[fibre]}",
            number(units.number(deflection[bent, i, station], "length")),
            f"{at(result, bent)}, {s[station]:.3g}",
        )
    return table


def _of_members(result: Result, units: AnswerUnits) -> list[str]:
    """Tell strains between stations, used strength, shear and von Mises stress, and how far points leave places."""
    lines = []
    largest = result.data["largest_strain"]
    larger = largest[largest > (1 + BETWEEN_STATIONS) * abs(result.data["strain"]).max(("theta", "s", "fibre"))]
    pairs = zip(larger["member"].to_numpy(), larger.to_numpy())
    peaks = ", ".join(f"{member} {number(units.number(value, 'strain'))}" for member, value in pairs)
    if peaks:
        lines.append(f"Larger strains between the stations ({units.label('strain')}): {peaks}")
    if "utilisation" in result.data:
        used = result.data["utilisation"].dropna("member")
        most_first = sorted(zip(used["member"].to_numpy(), used.to_numpy()), key=lambda pair: -pair[1])
        shares = ", ".join(f"{member} {percent(float(value), 3)}" for member, value in most_first)
        lines.append(f"Largest stress over the strength of the material: {shares}.")
    said, unit = [], units.label("stress")
    for name, words in (("von_mises", "von Mises stress"), ("shear_stress", "shear stress")):
        largest = abs(result.derived(name)).max(("theta", "s"))
        if largest.notnull().any() and float(largest.max()) > ROUNDED * float(abs(result.data["stress"]).max()):
            i = int(np.nanargmax(largest.to_numpy()))
            value = number(units.number(float(largest[i]), "stress"))
            said.append(f"{words} {value} {unit} in {largest['member'].to_numpy()[i]}")
    if said:
        lines.append(f"Largest {'; '.join(said)}.")
    if (traced := list(result.scene.points)) and "point_position_bent" in result.data:
        away = result.derived("positioning_error").sel(point=traced).max("theta").to_numpy()
        told = ", ".join(f"{point} {number(units.number(float(a), 'length'))}" for point, a in zip(traced, away))
        lines.append(f"Points leave their places in the rigid linkage by at most ({units.label('length')}): {told}.")
    return lines


def _signal(result: Result, units: AnswerUnits) -> list[RenderableType]:
    """Tabulate the largest harmonics of each member's strain at mid-span, and how it vibrates."""
    data = result.data
    if "strain_amplitude" not in data:
        if result.scene.analysis.method != "transient":
            return []
        change = data.attrs["cycle_change"]
        differs = f"the last cycle differs from the one before by {percent(change)} of the largest displacement"
        why = differs if np.isfinite(change) else "it has fewer than two cycles"
        return [Text(f"No harmonics are given because the motion is not periodic: {why}.")]
    vibrates, unit = "vibration_frequency" in data, units.label("strain")
    head = [f"vibration\n({unit})", "frequency\n(Hz)", "mode"] if vibrates else []
    table = table_of("Strain at mid-span, + side", "member", f"largest harmonics\nof the drive: {unit}", *head)
    amplitude = values_of(result, "strain_amplitude", "member", "gauge", "harmonic")[:, 0, 1:]
    for i, member in enumerate(data["member"].to_numpy()):
        heard = np.flatnonzero(amplitude[i] > ROUNDED * amplitude[i].max())
        largest = heard[np.argsort(-amplitude[i, heard])][:MOST_HARMONICS]
        cells = [", ".join(f"{n + 1}: {units.number(amplitude[i, n], 'strain'):.3g}" for n in largest)]
        if vibrates:
            size, rate, mode = (float(data[f"vibration_{name}"][i]) for name in ("amplitude", "frequency", "mode"))
            cells += [
                number(units.number(size, "strain")),
                *("-" if np.isnan(value) else number(value) for value in (rate, mode)),
            ]
        table.add_row(escape(str(member)), *cells)
    return [table]


def damping_of(scene: Scene) -> str:
    """Tell how a scene is damped."""
    damping = scene.damping
    ratios = damping.ratio if isinstance(damping.ratio, tuple) else (damping.ratio,)
    modal = ", ".join(f"{100 * value:.4g} %" for value in ratios)
    parts = (
        [f"{modal} of critical in {'each mode' if len(ratios) == 1 else 'the modes in turn'}"] if any(ratios) else []
    )
    parts += [f"material with a retardation time of {damping.material:.4g} s"] if damping.material else []
    parts += [f"drag {damping.external:.4g} 1/s on the absolute velocity"] if damping.external else []
    parts += [f"drag {damping.relative:.4g} 1/s on the velocity relative to the links"] if damping.relative else []
    if (air := damping.air) is not None:
        parts += [f"air of {air.density:.4g} kg/m^3 with a drag coefficient of {air.coefficient:.4g}"]
    return ", ".join(parts) or "none"


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
