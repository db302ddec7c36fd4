"""Whether the numbers of a result may be used, and why: the same sentences in terminal, report and documents."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from fenics_mech.effects import EFFECTS, Effect
from fenics_mech.effects.known import EXACT_STRAINS, GRAVITY
from fenics_mech.errors import SceneError, percent
from fenics_mech.estimate.accepted_errors import ACCEPTED, VALIDITY
from fenics_mech.estimate.error_sources import NUMERICAL
from fenics_mech.estimate.missed_peaks import BETWEEN
from fenics_mech.estimate.quantities import ERROR_VARIABLES
from fenics_mech.planning.answer_remarks import leaves_vibration, made_finer, unmet
from fenics_mech.planning.discretisation import refuse_stated, refuse_unknown
from fenics_mech.recovery.peaks import CYCLIC, PEAK, doubts
from fenics_mech.recovery.result import Result, kept
from fenics_mech.safety import buckled_sideways
from fenics_mech.safety.load_cases import most_stressed
from fenics_mech.scene.base import SCENE
from fenics_mech.scene.joints import effort_units
from fenics_mech.solve.stability_limits import STABILITY
from fenics_mech.views.motion_figures import law_efforts
from fenics_mech.views.prefixes import prefixed
from fenics_mech.views.reading import ForceReading, Reading, reading_of
from fenics_mech.views.words import UNSEEN, error_share, sentence, share, short

Level = Literal["bad", "warn", "good", "note"]
MOST_NAMED = 3  # members that are named in a sentence
LEVELS: tuple[Level, ...] = ("bad", "warn", "good", "note")
ROUGH = "Estimates that large are rough: 0.3 to 3.4 of the truth."
BENT = 0.05  # share of the deflection that linear strains may leave out: they leave out all shortening
SERIOUS = 0.25  # of a strain, or of the Euler load: beyond it a result without the effect is of no use
SOURCES = {  # of errors, in words
    "time": "time steps",
    "harmonics": "harmonics left out",
    "modes": "modes left out",
    "stations": "between stations",
    "positions": "peaks between positions",
    "theory": "linear theory",
    "effects": "effects left out",
    "joints": "rigid arms and guides",
}
WORDS = {
    "good": "The computation is accurate",
    "note": "The computation is accurate",
    "warn": "Use the numbers with care",
    "bad": "Do not use these numbers",
}
REMEDIES = {
    "mesh": "more elements",
    "time": "more sub_intervals",
    "positions": "more sub_intervals",
    "harmonics": "more harmonics",
    "modes": "more modes",
    "stations": "more stations",
}
SMALLER = "a smaller tolerance"


@dataclass(frozen=True)
class Judgement:
    """One reason why numbers may be used, or not."""

    level: Level  # "good", "note" (not examined), "warn" (use with care) or "bad" (do not use)
    title: str  # the reason in a few words, without a capital letter
    text: str  # sentences with numbers, and with what to change
    about: str = "theory"  # what is judged: "theory", "stability" or "error"


def worst_of_cases(each: Mapping[str, Sequence[Judgement]], governing: str) -> list[Judgement]:
    """Give of all that is judged what the worst load case has; of equal ones the governing case."""
    each, found = {governing: each[governing], **each}, list["Judgement"]()
    for about in dict.fromkeys(judged.about for every in each.values() for judged in every):
        of_case = {name: [one for one in judged if one.about == about] for name, judged in each.items()}
        rank = {name: min(LEVELS.index(one.level) for one in judged) for name, judged in of_case.items() if judged}
        worst = min(rank, key=rank.__getitem__)
        alike = len({tuple(judged) for judged in of_case.values()}) == 1
        told = "" if alike else f"In case {worst}: "
        found += [replace(one, text=f"{told}{one.text}") for one in of_case[worst]]
    return sorted(found, key=lambda judged: LEVELS.index(judged.level))


def and_beyond(known: Judgement, result: Result) -> list[Judgement]:
    """Give reasons why numbers of a result are wrong that its theory does not know of, beside what it knows."""
    # Where members buckle across the plane of motion, nothing is called good by the theory alone.
    # An answer across the plane, as `analysis.out_of_plane` asks for, is refused where they do.
    if "frequency_across" in result.data or not (found := buckled_sideways(result.scene, result.data)):
        return [known]
    units, said = prefixed(result, result.scene.answer_units), []
    for one in found[:MOST_NAMED]:
        loads = one.force, one.pinned, one.clamped
        force, pinned, clamped = (f"{short(units.number(load, 'force'))} {units.label('force')}" for load in loads)
        free, held = f"{clamped}, as one end is free", f"{pinned} with pinned ends and {clamped} with clamped ends"
        ends = free if one.free else held
        said.append(f"Member {one.member} is pressed by up to {force}: across the plane it buckles at {ends}.")
    said += [f"So may {len(found) - MOST_NAMED} more."] if len(found) > MOST_NAMED else []
    text = (
        f"Nothing is computed across the plane of motion. {' '.join(said)} Take sections that are wider there, lower "
        "loads, or guides that hold the members in the plane."
    )
    surely = [one.member for one in found if one.buckles]
    names = ", ".join((surely or [one.member for one in found])[:MOST_NAMED])
    title = f"sideways buckling of {names}{'' if surely else ' is possible'}"
    beyond = replace(known, level="bad" if surely else "warn", title=title, text=text)
    return [beyond] if known.level == "good" else [known, beyond]


def beside_tolerance(result: Result) -> list[str]:
    """Say of the quantities that a tolerance does not name how large their errors are, where these are larger."""
    stated, data = result.scene.tolerances, result.data
    errors = {
        name: float(data.attrs[f"{ERROR_VARIABLES[what][1]}error_estimate"])
        for what, name in quantities(result).items()
        if what not in stated
    }
    most = max(stated.values(), default=1.0)
    beyond = [f"{name} {error_share(value)}" for name, value in errors.items() if value > most]
    return [f"The tolerance does not name what has larger errors: {', '.join(beyond)}."] if beyond else []


def quantities(result: Result) -> dict[str, str]:
    """Give the quantities of a result that have an error, and their names."""
    data = result.data
    names = {"strain": "strain", "deflection": "deflection"}
    if data.sizes["joint"]:
        names["joint_force"] = "joint force"
    if moved := result.scene.moved_joints:
        alone = effort_units(moved, result.scene.joints) == ["N m"]
        names["torque"] = "effort" if not result.scene.drives else "input torque" if alone else "drive effort"
    return {what: name for what, name in names.items() if f"{ERROR_VARIABLES[what][1]}error_estimate" in data.attrs}


def too_uncertain(result: Result) -> dict[str, float]:
    """Give the quantities beside the strain whose numerical error is too large, and that error."""
    data, found = result.data, {}
    numerical = [str(source) for source in data["source"].to_numpy() if source in (*NUMERICAL, BETWEEN)]
    for what, name in quantities(result).items():
        wrong = float(data[f"{ERROR_VARIABLES[what][1]}relative_error"].sel(source=numerical).sum())
        if what != "strain" and wrong > ACCEPTED.of_strain:
            found[name] = wrong
    return found


@kept
def judgements(result: Result) -> tuple[Judgement, ...]:
    """Judge a result by theory, stability and error, the worst first."""
    if result.cases:
        return tuple(worst_of_cases({name: judgements(one) for name, one in result.cases.items()}, result.case))
    if not result.scene.members():
        return (_rigid(result),)
    found = filter(None, [*and_beyond(theory(result), result), stability(result), error(result)])
    return tuple(sorted(found, key=lambda j: LEVELS.index(j.level)))


def warnings_of(result: Result) -> list[str]:
    """Give everything that a result warns of, in sentences: numbers of the scene, strengths, theory, errors."""
    bad = [judged for judged in judgements(result) if judged.level in ("warn", "bad")]
    return [*result.warnings, *(f"{judged.title}: {judged.text}" for judged in bad)]


def unstated_gravity(result: Result, effect: str) -> bool:
    """Whether an effect is gravity, and the scene of a result states none: its size of 0 is then no finding."""
    return effect == GRAVITY and not any(result.scene.gravity)


def verdict(judged: Sequence[Judgement]) -> tuple[Level, str]:
    """Give the worst level of some judgements, and the sentence whether the numbers can be used."""
    level = judged[0].level if judged else "note"
    return level, f"{WORDS[level]}: {', '.join(j.title for j in judged if j.level in (level, 'good', 'note'))}."


def headline(reading: ForceReading) -> tuple[str, str]:
    """Give the peak stress, and where and when it occurs, with the peak without vibration where that is known."""
    # Of links that do not bend it is the largest joint force.
    if reading.result.cases:
        case = most_stressed(reading.result)
        value, rest = headline(reading_of(reading.result.cases[case], reading.units))
        return value, f"in case {case}, {rest}"
    if not isinstance(reading, Reading):
        if not reading.joints:
            return "Nothing is joined", "so that no joint has a force."
        k, n = (int(i) for i in np.unravel_index(reading.force.argmax(), reading.force.shape))
        value = f"Largest joint force {short(float(reading.force[k, n]))} {reading.units.label('force')}"
        return value, f"in {reading.joints[n]}, at {reading.at(k)}.{_between_positions(reading)}"
    peak = reading.peaks[reading.ranked[0]]
    unit = reading.units.label("stress")
    value = f"Peak stress {short(abs(reading.stress[peak]))} {unit}"
    where = f"in {reading.members[peak.i]}, {reading.place(peak)}"
    when = f", at {reading.at(peak.k)}" if len(reading.theta) > 1 else ""
    rest = "" if reading.still is None else f" ({short(reading.still)} {unit} without vibration)"
    return value, f"{where}{when}{rest}.{_between_positions(reading)}"


def _between_positions(reading: ForceReading) -> str:
    """Tell the largest force and moment of joint laws where they are between the positions: no joint force has them."""
    efforts = [one for one in law_efforts(reading.result, reading.units) if one.between]
    if not efforts:
        return ""
    most = {one.unit: one for one in sorted(efforts, key=lambda one: one.largest)}  # of forces, and of moments
    told = [f"{one.law} at joint {one.joint} exerts up to {short(one.largest)} {one.unit}" for one in most.values()]
    return f" Between the positions {' and '.join(reversed(told))}."


def _rigid(result: Result) -> Judgement:
    """Say what a result of rigid links holds, and by how much its joint forces may be off."""
    attributes = result.data.attrs
    text = "No link bends: there are no stresses, and vibration adds nothing to the forces."
    names = {"joint_force": "joint forces", "drive_effort": "efforts"}
    known = {
        said: float(attributes[at]) for name, said in names.items() if (at := f"{name}_error_estimate") in attributes
    }
    in_time = attributes["time_steps"]
    if known:
        source = "By the time steps" if in_time else "By peaks between positions"
        off = " and ".join(f"{name} are off by at most {share(error)}" for name, error in known.items())
        text += f" {source} {off} of the largest."
    if "contacts_closed" in attributes:
        text += " Forces are those at the positions, and contacts between these are shorter."
    if "not_estimated" in attributes:
        text += f" Not known: {attributes['not_estimated']}."
        return Judgement("warn", "links are rigid, error not known", text)
    if not known and (in_time or result.scene.analysis.method in CYCLIC):
        cause = "analysis.error_estimates = false" if not result.scene.analysis.error_estimates else "positions are few"
        text += f" Nothing tells by how much the forces are off, as {cause}."
        return Judgement("warn", "links are rigid, error not estimated", text)
    if not in_time and max(known.values(), default=0.0) > PEAK.doubtful:
        level: Level = "bad" if attributes["too_coarse"] else "warn"
        return Judgement(level, "links are rigid, positions too few", f"{text} Take more sub_intervals.")
    return Judgement("note", "links are rigid", text)


def acting(result: Result) -> list[Effect]:
    """Effects that act in a result, as far as the program knows them."""
    decided = json.loads(result.data.attrs["effects"])
    return [EFFECTS[e["name"]] for e in decided if e["acts"] and e["name"] in EFFECTS]


def level_of_theory(
    sizes: tuple[float, float, float], effects: Sequence[Effect], left_out: Sequence[float] | None
) -> Level:
    """Judge whether the theory of some effects holds: "good", "warn" (use with care) or "bad"."""
    # sizes: largest axial force over the buckling load, bow over the length, and rotation of an axis (rad), of any
    # member; left_out: shares of the strain and of the deflection that linear theory leaves out, None if unknown
    euler, bow, turn = sizes
    if any(effect.nonlinear for effect in effects):  # strains are exact
        return "good" if turn <= VALIDITY.rotation else "bad"
    if left_out is not None:
        strain, bent = left_out
        if strain <= SCENE.neglected and bent <= BENT:
            return "good"
        return "warn" if max(strain, bent) <= SERIOUS and np.isfinite(strain) else "bad"
    pressed = 0.0 if any(effect.stress_stiffening for effect in effects) else euler
    if bow > VALIDITY.bow or pressed > SERIOUS:
        return "bad"
    return "warn" if pressed > VALIDITY.euler_ratio else "good"


def theory(result: Result) -> Judgement:
    """Judge whether deflections and axial forces are small enough for the theory that was used."""
    members = [str(member) for member in result.data["member"].to_numpy()]
    euler, bow, turn = (result.data[name].to_numpy() for name in ("euler_ratio", "bow", "rotation"))
    effects, left = acting(result), None
    if "source" in result.data and "theory" in result.data["source"]:
        names = "relative_error", "deflection_relative_error"
        left = tuple(float(result.data[name].sel(source="theory")) for name in names)
    level = level_of_theory((euler.max(), bow.max(), turn.max()), effects, left)
    worst = f"the axial force in {members[euler.argmax()]} reaches {percent(euler.max(), 3)} of its buckling load"
    bent = f"{members[bow.argmax()]} bows by up to {percent(bow.max(), 3)} of its length"
    if any(effect.nonlinear for effect in effects):
        turned = f"the axis of {members[turn.argmax()]} turns by up to {turn.max():.3g} rad"
        limit = f"the theory of large rotations holds to {VALIDITY.rotation} rad"
        if level == "good":
            return Judgement(level, "inside the theory", f"{sentence(turned)}; {limit}. {sentence(worst)}.")
        return Judgement(level, "outside the theory", f"{sentence(turned)}, and {limit}: the strains are wrong.")
    if left is not None:
        why = f"{sentence(worst)}; {bent}." + ("" if level == "good" else f" {advice(result)}")
        if not np.isfinite(left[0]):
            return Judgement(level, "outside the linear theory", f"Exact strains find no stable answer near it. {why}")
        strain, deflection = map(error_share, left)
        said = f"Linear theory leaves out {strain} of the strain and {deflection} of the deflection."
        titles = {"good": "inside the theory", "warn": f"linear theory leaves out {share(max(left))}"}
        rough = f" {ROUGH}" if level == "bad" else ""
        return Judgement(level, titles.get(level, "outside the linear theory"), f"{said}{rough} {why}")
    limits = f"{percent(VALIDITY.euler_ratio)} of a buckling load and {percent(VALIDITY.bow)} of a length"
    if level == "good":
        return Judgement(level, "inside the theory", f"{sentence(worst)}; {bent}. Linear theory holds to {limits}.")
    if level == "bad":
        text = f"{sentence(worst)}; {bent}. Linear theory holds to {limits}: the strains are wrong. {advice(result)}"
        return Judgement(level, "outside the linear theory", text)
    off = f"Strains may be off by about {percent(euler.max())}, as the effects leave the axial forces out."
    return Judgement(level, "at the edge of the linear theory", f"{off} {sentence(worst)}. {advice(result)}")


def stability(result: Result) -> Judgement | None:
    """Judge whether small disturbances of a periodic motion die out; None for other results."""
    data = result.data
    if result.scene.analysis.method != "periodic":
        return None
    if "stability_limit" not in data.attrs:
        text = "It was not examined; analysis.stability = true examines it."
        return Judgement("note", "stability not examined", text, "stability")
    limit = f"{data.attrs['stability_limit']:.3g} Hz"
    if "multiplier_link" not in data:
        text = f"Every disturbance is faster than {limit}, too fast for the steps."
        return Judgement("note", "stability not judged", text, "stability")
    size = float(np.hypot(*data["multiplier"][0].to_numpy()))
    rate, frequency, mode = (
        float(data[name][0]) for name in ("growth_rate", "multiplier_frequency", "multiplier_mode")
    )
    where = f"{frequency:.4g} Hz in the axes of link {data['multiplier_link'][0].item()}, mode {mode:.0f}"
    if math.isnan(frequency):
        where = "no more than rounding: its frequency is not known"
    text = (
        f"Of a small disturbance {percent(size, 3)} is left after one cycle ({where}; rate {short(rate)} 1/s). "
        f"Disturbances faster than {limit} are not judged."
    )
    if size < 1 - STABILITY.tolerance:
        return Judgement("good", "stable", text, "stability")
    if size < 1 + STABILITY.tolerance:
        return Judgement("warn", "at the limit of stability", f"Nothing damps the motion. {text}", "stability")
    return Judgement("bad", "unstable", f"A small disturbance grows. {text}", "stability")


def error(result: Result) -> Judgement:
    """Judge the estimated error of the strains."""
    data = result.data
    if "error_estimate" not in data.attrs:
        text = "Nothing tells whether mesh, steps and theory suffice, as analysis.error_estimates = false."
        return Judgement("warn", "error not estimated", text, "error")
    total = float(data.attrs["error_estimate"])
    sources = [str(source) for source in data["source"].to_numpy()]
    by = dict(zip(sources, data["relative_error"].to_numpy()))
    largest = max(by, key=by.__getitem__)
    most = f"at most {share(total)}" if UNSEEN <= total < 1 else error_share(total)
    title, text = f"error {most}", f"{sentence(most)} of a member's largest strain, by estimate"
    missed = unmet(result)  # of which the warnings tell cause and cure
    if total > SCENE.neglected:
        text += f"; {error_share(by[largest])} by {SOURCES.get(largest, f'the {largest}')}"
        text += "" if missed else remedy(result, largest)
    level: Level = "good" if total <= ACCEPTED.of_strain and not missed else "warn"
    title += ", tolerance not met" * bool(missed)
    parts = [f"{text}.", *filter(None, [made_finer(result)]), *beside_tolerance(result)]
    if wrong := too_uncertain(result):
        said = ", ".join(f"{name} {share(value)}" for name, value in wrong.items())
        level, parts = "warn", [*parts, f"Too uncertain to be used: {said}."]
    if (uncertain := doubtful_peaks(result)) is not None:
        level, parts = "warn", [*parts, uncertain]
    if "not_estimated" in data.attrs:
        level, parts = "warn", [*parts, f"Not in this estimate: {data.attrs['not_estimated']}."]
    if data.attrs["too_coarse"]:
        return Judgement("bad", title, f"Too large: do not use these numbers. {' '.join(parts)}", "error")
    return Judgement(level, title, " ".join(parts), "error")


def doubtful_peaks(result: Result) -> str | None:
    """Say by how much peaks are uncertain where they lie between few positions; None where they are not."""
    by_strain, by_force = doubts(result).values()
    if max(by_strain, by_force) < PEAK.doubtful:
        return None
    by_tolerance = "chosen" in result.data.attrs and result.scene.analysis.method == "periodic"
    return (
        f"Peaks between the {result.data.sizes['theta']} positions are uncertain by an estimated {by_strain:.1%} of "
        f"the member's largest strain and {by_force:.1%} of the largest joint force. "
        f"Take {'a smaller tolerance' if by_tolerance else 'more sub_intervals'}."
    )


def _decided(result: Result) -> list[dict[str, Any]]:
    """What was decided about every effect."""
    found: list[dict[str, Any]] = json.loads(result.data.attrs["effects"])
    return found


def advice(result: Result) -> str:
    """Say what takes along what linear theory leaves out."""
    if any(one["size"] is not None for one in _decided(result)):  # the program chose effects
        return f"Write effects = {_with(result, EXACT_STRAINS)} to take it along."
    return "Write effects = 'auto' to take what is needed."


def remedy(result: Result, source: str) -> str:
    """Say what lowers an error by its largest source; of the theory `advice` says it."""
    if source == "effects":
        if leaves_vibration(_decided(result)):
            return ", which analysis.method = 'periodic' lowers"
        left = [one for one in _decided(result) if not one["acts"]]
        if lacking := max((e for e in left if e["lacking"]), key=lambda e: e["size"] or 0.0, default=None):
            return f", as {lacking['name']} lacks data. {lacking['lacking']}"
        try:  # whether a tolerance can be stated for the scene
            refuse_stated(result.scene)
            refuse_unknown(result.scene)
        except SceneError:
            largest = max(left, key=lambda one: one["size"] or 0.0)["name"]
            return f", which effects = {_with(result, largest)} lowers"
        stated = result.scene.tolerances
        return f", which {SMALLER if stated else f'a tolerance below {percent(result.scene.neglected)}'} lowers"
    if source not in REMEDIES:
        return ""
    cure = REMEDIES[source]
    if "chosen" in result.data.attrs:
        cure = SMALLER
    elif source == "time" and result.scene.analysis.method == "transient":
        cure = "a smaller analysis.time_tolerance"
    return f", which {cure} lowers"


def _with(result: Result, name: str) -> str:
    """List the effects of a result that a scene names, and one more, without that which it holds."""
    acting = [one["name"] for one in _decided(result) if one["acts"] and one["name"] in EFFECTS]
    named = [one for one in acting if not EFFECTS[one].stated_by and one != EFFECTS[name].replaces]
    return str([*named, name])
