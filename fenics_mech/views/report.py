"""A summary of a result that a person can read after a run."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from fenics_mech._console import text_of
from fenics_mech._constants import MEGA, MICRO, MILLI
from fenics_mech.accuracy.estimate import ACCEPTED, NUMERICAL
from fenics_mech.accuracy.quantities import ERROR_VARIABLES
from fenics_mech.accuracy.validity import VALIDITY
from fenics_mech.effects import EFFECTS, Effect, active, loads_at_nodes
from fenics_mech.errors import percent
from fenics_mech.forces.joint_forces import effort_units
from fenics_mech.planning.effect_choice import CHOICE
from fenics_mech.recovery import Result
from fenics_mech.recovery.peaks import PEAK, PEAKS, between_positions, doubt
from fenics_mech.response.stability.floquet import STABILITY
from fenics_mech.scene.base import SCENE
from fenics_mech.scene.meshing import member_nodes
from fenics_mech.views.frequency_table import frequency_table
from fenics_mech.views.peak_tables import damping_of, degrees_of, joint_table, peak_of, values_of
from fenics_mech.views.rigid_report import rigid_parts
from fenics_mech.views.tables import drive_of, number, table_of

SOURCES = {  # of errors, in words
    "time": "time steps",
    "harmonics": "harmonics left out",
    "modes": "modes left out",
    "stations": "between stations",
    "theory": "linear theory",
    "effects": "effects left out",
}
PLACE = "s: place along the member, from 0 to 1; sides: + is the one that the member's normal points to"
MINUS = "\N{MINUS SIGN}"
ADVICE = "Write effects = 'auto', which takes the effects that are needed."


@dataclass(frozen=True)
class ReportLimits:
    """What the summary leaves out."""

    between_stations: float = 1e-3  # excess of a strain over that at the stations: four digits are printed
    harmonics: int = 4  # of each member: more do not fit a line of 80 columns
    watts: float = 1.0  # power from which watts are written, and milliwatts below (W)
    rounding: float = 1e-9  # of the largest harmonic or power, below which others are rounding


REPORT = ReportLimits()


class Summary(Group):
    """A summary: text where it is printed, and with colours by `rich.print`."""

    def __str__(self) -> str:
        return text_of(self)


def summary(result: Result) -> Summary:
    """Summarise a result, to be printed; it needs 80 columns.

    First how it was computed. Then the peaks with the drive angle (degrees) and the place (s, 0..1) where they occur:
    strain, stress and deflection of each member, force of each joint, input torque. Then the range of each mode's
    frequency, stability, the balance of power, the limits of the theory, and warnings.

    Parameters
    ----------
    result
        The result.

    Returns
    -------
    Summary
        A text with tables; `rich.print` shows it with colours.

    Examples
    --------
    >>> print(fm.summary(fm.Result.load("out/result.nc")))  # doctest: +ELLIPSIS
    seed four-bar...
    """
    if not result.scene.members():
        return Summary(*rigid_parts(result))
    parts: list[RenderableType] = [Text(result.scene.name, style="bold"), _decisions(result), Text()]
    closer = between_positions(result)
    parts += [_members(closer), *_between_stations(result)]
    if result.data.sizes["joint"]:
        parts.append(joint_table(closer))
    parts += [*_doubtful_peaks(result, closer), *_signal(result)]
    if "frequency" in result.data:
        frequency, assurance = (values_of(result, name, "theta", "mode") for name in ("frequency", "assurance"))
        parts.append(frequency_table(frequency, assurance, values_of(result, "frequency_error", "mode")))
        if any(effect.nonlinear for effect in _acting(result)):
            parts.append(Text("These frequencies leave out the axial forces in the links."))
    if "stability_limit" in result.data.attrs:
        parts.append(_stability(result))
    if "mean_power" in result.data:
        parts.append(_energy(result))
    parts += [_validity(result), *(Text(f"Warning: {text}", style="bold yellow") for text in result.warnings)]
    return Summary(*parts)


def _acting(result: Result) -> list[Effect]:
    """Effects that act in a result, as far as the program knows them."""
    decided = json.loads(result.data.attrs["effects"])
    return [EFFECTS[e["name"]] for e in decided if e["acts"] and e["name"] in EFFECTS]


def _validity(result: Result) -> Text:
    """Tell whether deflections and axial forces are small enough for the theory that was used."""
    members = [str(member) for member in result.data["member"].to_numpy()]
    euler, bow, turn = (result.data[name].to_numpy() for name in ("euler_ratio", "bow", "rotation"))
    worst = f"the axial force in {members[euler.argmax()]} reaches {percent(euler.max(), 3)} of its buckling load"
    bent = f"{members[bow.argmax()]} bows by up to {percent(bow.max(), 3)} of its length"
    turned = f"the axis of {members[turn.argmax()]} turns by up to {turn.max():.3g} rad"
    acting = _acting(result)
    if any(effect.nonlinear for effect in acting):
        if turn.max() <= VALIDITY.rotation:
            return Text(f"Inside the theory of large rotations: {turned}; {worst}.")
        text = f"OUTSIDE THE THEORY OF LARGE ROTATIONS, strains are wrong: {turned} (limit {VALIDITY.rotation} rad)."
        return Text(text, style="bold red")
    if "theory" in result.data["source"]:
        of_strain, of_deflection = (
            float(result.data[f"{prefix}relative_error"].sel(source="theory")) for prefix in ("", "deflection_")
        )
        share = f"{percent(of_strain)} of the strain and {percent(of_deflection)} of the deflection"
        if of_strain <= SCENE.neglected and of_deflection <= CHOICE.deflection:
            return Text(f"Inside the linear theory, which leaves out {share}: {worst}; {bent}.")
        text = f"OUTSIDE THE LINEAR THEORY, which leaves out {share} by estimate: {worst}; {bent}. {ADVICE}"
        return Text(text, style="bold red")
    carried = any(effect.stress_stiffening for effect in acting)
    if (carried or euler.max() <= VALIDITY.euler_ratio) and bow.max() <= VALIDITY.bow:
        return Text(f"Inside the linear theory: {worst}; {bent}.")
    beyond = [f"{bent} (limit {percent(VALIDITY.bow)})"] if bow.max() > VALIDITY.bow else []
    if not carried and euler.max() > VALIDITY.euler_ratio:
        beyond.insert(0, f"{worst} (limit {percent(VALIDITY.euler_ratio)})")
    return Text(f"OUTSIDE THE LINEAR THEORY, strains are wrong: {'; '.join(beyond)}. {ADVICE}", style="bold red")


def _energy(result: Result) -> Text:
    """Tell the mean power of drives, loads and damping, and how far they are from a balance."""
    data = result.data
    power = {str(cause): float(value) for cause, value in zip(data["cause"].to_numpy(), data["mean_power"].to_numpy())}
    whole = "motion" if result.scene.analysis.method == "transient" else "cycle"
    factor, unit = (1.0, "W") if max(map(abs, power.values()), default=0.0) >= REPORT.watts else (MILLI, "mW")
    parts = [f"{cause} {number(factor * value)} {unit}" for cause, value in power.items()]
    residual, error, bound = (data.attrs[f"power_{name}"] for name in ("residual", "balance_error", "error"))
    text = f"Mean power over the {whole}: {', '.join(parts)}; imbalance {number(factor * residual)} {unit}"
    if not any(effect.couples for effect in _acting(result)):
        return Text(f"{text}, as the equation leaves out the coupling, without which energy does not balance.")
    text = f"{text} ({error:.1g} of the largest)"
    if abs(residual) > bound and error > REPORT.rounding:
        text += f", MORE than the {number(factor * bound)} {unit} that the estimated errors of the drives explain"
    return Text(f"{text}.")


def _stability(result: Result) -> Text:
    """Tell whether small disturbances of the periodic motion die out."""
    limit = f"{result.data.attrs['stability_limit']:.3g} Hz"
    if "multiplier" not in result.data:
        return Text(f"Stability is not judged: every disturbance is faster than {limit}, too fast for the steps.")
    size = np.hypot(*result.data["multiplier"][0].to_numpy())
    rate, frequency, mode = (
        float(result.data[name][0]) for name in ("growth_rate", "multiplier_frequency", "multiplier_mode")
    )
    link = result.data["multiplier_link"][0].item()
    where = f"({frequency:.4g} Hz in the axes of link {link}, mode {mode:.0f}; rate {rate:.3g} 1/s)"
    per_cycle = f"to {100 * size:.3g} % per cycle {where}"
    rest = f"Disturbances faster than {limit} are not judged."
    if size < 1 - STABILITY.tolerance:
        return Text(f"Stable: the least-damped disturbance decays {per_cycle}. {rest}")
    if size < 1 + STABILITY.tolerance:
        return Text(f"At the limit of stability, without damping: the worst disturbance comes {per_cycle}. {rest}")
    return Text(f"UNSTABLE: a small disturbance grows {per_cycle}.", style="bold red")


def _decisions(result: Result) -> Table:
    """Tell how the result was computed: method, solver, modes, errors, damping, effects, mesh."""
    scene, analysis = result.scene, result.scene.analysis
    rows = {"drive": drive_of(scene), "method": f"{analysis.method}, {result.data.sizes['theta']} positions"}
    if analysis.method == "periodic":
        rows["solver"] = _solver(result)
    if result.data.attrs.get("solver") == "sub-intervals":
        rest = "the others follow the load statically" if analysis.static_correction else "the others are left out"
        rows["joining"] = f"{analysis.join} continuity between sub-intervals, {analysis.load} load in each"
        rows["modes"] = f"{result.data.sizes['mode']} kept, {rest}"
    if "error_estimate" in result.data.attrs:
        rows["error estimate"] = _errors(result)
    if np.isfinite(result.data.attrs.get("cycle_change", np.inf)):
        rows["last cycle"] = f"differs from the one before by {percent(result.data.attrs['cycle_change'])}"
    rows["damped by"] = damping_of(scene)
    rows["effects"] = _effects(result)
    rows["mesh"] = f"{result.data.attrs['elements']} elements, {result.data.attrs['dofs']} degrees of freedom"
    if analysis.reduction != "none":
        at_nodes = loads_at_nodes(active(scene))
        nodes = [len(member_nodes(scene, label, at_nodes)) for label in scene.members()]
        elements = sum(nodes) - len(nodes)  # it is recovered on fewer
        rows["mesh"] = f"{rows['mesh']} after Craig-Bampton reduction of {elements} elements"
    if "chosen" in result.data.attrs:
        rows["tolerance"] = str(result.data.attrs["chosen"])
    table = Table.grid(padding=(0, 2))
    for name, value in rows.items():
        table.add_row(name, escape(value))
    return table


def _errors(result: Result) -> str:
    """Tell the largest relative error of each quantity, and that of the strains by source."""
    data, parts = result.data, []
    numerical = [str(source) for source in data["source"].to_numpy() if source in NUMERICAL]
    for what, name in _quantities(result).items():
        prefix = ERROR_VARIABLES[what][1]
        text = f"{name} {percent(data.attrs[f'{prefix}error_estimate'])}"
        wrong = float(data[f"{prefix}relative_error"].sel(source=numerical).sum()) > ACCEPTED.of_strain
        parts.append(text + (" (TOO LARGE, do not use it)" if wrong and what != "strain" else ""))
    by_source = zip(data["source"].to_numpy(), data["relative_error"].to_numpy())
    shares = ", ".join(f"{SOURCES.get(source, source)} {percent(error)}" for source, error in by_source)
    text = f"{', '.join(parts)}; of the strain: {shares}"
    if "not_estimated" in data.attrs:
        text += f"; NOT included: {data.attrs['not_estimated']}"
    return text + (": TOO LARGE, do not use these numbers" if data.attrs["too_coarse"] else "")


def _quantities(result: Result) -> dict[str, str]:
    """Give the quantities of a result that have an error, and their names."""
    data = result.data
    names = {"strain": "strain", "deflection": "deflection"}
    if data.sizes["joint"]:
        names["joint_force"] = "joint force"
    if moved := result.scene.moved_joints:
        alone = effort_units(moved, result.scene.joints) == ["N m"]
        names["torque"] = "input torque" if alone else "drive effort"
    return {what: name for what, name in names.items() if f"{ERROR_VARIABLES[what][1]}error_estimate" in data.attrs}


def _solver(result: Result) -> str:
    """Name the solver of a periodic response, and its order."""
    analysis, solver = result.scene.analysis, str(result.data.attrs["solver"])
    if solver == "harmonic-balance":
        return f"{solver}, {analysis.harmonics} harmonics"
    return (
        solver
        if solver == "sub-intervals"
        else f"{solver}, {analysis.stages} {analysis.scheme.capitalize()} points per step"
    )


def _effects(result: Result) -> str:
    """Name the effects that act, with their influence on the strains where it was estimated."""
    effects = json.loads(result.data.attrs["effects"])
    inside = {effect.replaces for effect in _acting(result)}
    least = result.scene.neglected / 2
    acting = []
    for e in (e for e in effects if e["acts"]):
        below = e["size"] is not None and e["size"] <= least and EFFECTS[e["name"]].nonlinear
        why = ", for the deflection or a tolerance" if below else ""  # see `planning.effect_choice.suffices`
        acting.append(e["name"] + ("" if e["size"] is None else f" ({percent(e['size'])}{why})"))
    left = [
        f"{e['name']} ({percent(e['size'])}{', MISSING DATA: ' + e['lacking'] if e['lacking'] else ''})"
        for e in effects
        if not e["acts"] and e["size"] is not None and e["name"] not in inside
    ]
    chosen = f"; selected: influence above {percent(least)}; left out: {', '.join(left) or 'none'}"
    estimated = any(e["size"] is not None for e in effects)
    return (", ".join(acting) or "none") + (chosen if estimated else "")


def _doubtful_peaks(result: Result, closer: Result) -> list[Text]:
    """Say by how much peaks are uncertain where they lie between few positions."""
    by_strain, by_force = (doubt(result, closer, name) for name in PEAKS)
    if max(by_strain, by_force) < PEAK.doubtful:
        return []
    text = (
        f"Peaks between the {result.data.sizes['theta']} positions are uncertain by {by_strain:.1%} of the largest "
        f"strain and {by_force:.1%} of the largest joint force: without every second position they differ by that. "
        f"Take {'a smaller tolerance' if 'chosen' in result.data.attrs else 'more sub_intervals'}"
    )
    return [Text(text)]


def _members(result: Result) -> Table:
    """Tabulate the peak strain, with its stress, and the peak deflection of each member."""
    strain_head, bent_head = "strain\n(\N{MICRO SIGN}m/m)", "deflection\n(mm)"
    columns = "member", strain_head, "stress\n(MPa)", "at angle,\ns, side", bent_head, "at angle,\ns"
    table = table_of("Peaks of the members", *columns)
    table.caption, table.caption_justify = f"{PLACE}\n", "left"
    theta, s = degrees_of(result), result.data["s"].to_numpy()
    fibres = [str(fibre).replace("-", MINUS) for fibre in result.data["fibre"].to_numpy()]
    strain, stress = (values_of(result, name, "theta", "member", "s", "fibre") for name in ("strain", "stress"))
    deflection = np.linalg.norm(values_of(result, "deflection", "theta", "member", "s", "component"), axis=-1)
    for i, member in enumerate(result.data["member"].to_numpy()):
        k, place, fibre = peak_of(strain[:, i])
        bent, station = peak_of(deflection[:, i])
        table.add_row(
            escape(str(member)),
            number(MICRO * strain[k, i, place, fibre]),
            number(MEGA * stress[k, i, place, fibre]),
            f"{theta[k]:.4g}\N{DEGREE SIGN}, {s[place]:.3g}, {fibres[fibre]}",
            number(MILLI * deflection[bent, i, station]),
            f"{theta[bent]:.4g}\N{DEGREE SIGN}, {s[station]:.3g}",
        )
    return table


def _between_stations(result: Result) -> list[Text]:
    """Say where the strain between stations is larger than at all of them."""
    largest = result.data["largest_strain"]
    larger = largest[largest > (1 + REPORT.between_stations) * abs(result.data["strain"]).max(("theta", "s", "fibre"))]
    pairs = zip(larger["member"].to_numpy(), larger.to_numpy())
    peaks = ", ".join(f"{member} {number(MICRO * value)}" for member, value in pairs)
    return [Text(f"Larger strains between the stations (\N{MICRO SIGN}m/m): {peaks}")] if peaks else []


def _signal(result: Result) -> list[RenderableType]:
    """Tabulate the largest harmonics of each member's strain at mid-span, and how it vibrates."""
    data = result.data
    if "strain_amplitude" not in data:
        if result.scene.analysis.method != "transient":
            return []
        change = data.attrs["cycle_change"]
        differs = f"the last cycle differs from the one before by {percent(change)} of the largest displacement"
        why = differs if np.isfinite(change) else "it has fewer than two cycles"
        return [Text(f"No harmonics are given because the motion is not periodic: {why}.")]
    vibrates = "vibration_frequency" in data
    head = ["vibration\n(\N{MICRO SIGN}m/m)", "frequency\n(Hz)", "mode"] if vibrates else []
    table = table_of(
        "Strain at mid-span, + side", "member", "largest harmonics\nof the drive: \N{MICRO SIGN}m/m", *head
    )
    amplitude = MICRO * values_of(result, "strain_amplitude", "member", "gauge", "harmonic")[:, 0, 1:]
    for i, member in enumerate(data["member"].to_numpy()):
        heard = np.flatnonzero(amplitude[i] > REPORT.rounding * amplitude[i].max())
        largest = heard[np.argsort(-amplitude[i, heard])][: REPORT.harmonics]
        cells = [", ".join(f"{n + 1}: {amplitude[i, n]:.3g}" for n in largest)]
        if vibrates:
            size, rate, mode = (float(data[f"vibration_{name}"][i]) for name in ("amplitude", "frequency", "mode"))
            cells += [number(MICRO * size), *("-" if np.isnan(value) else number(value) for value in (rate, mode))]
        table.add_row(escape(str(member)), *cells)
    return [table]
