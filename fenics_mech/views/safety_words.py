"""The verdict on a machine in words: whether it is safe, what would help, what was assumed, and speeds to avoid."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from fenics_mech.recovery import Result
from fenics_mech.safety import KEYS, Check, Cure, Verdict, judge
from fenics_mech.safety.critical_speeds import (
    STRONG,
    CriticalSpeed,
    cause_of,
    critical_speeds,
    multiple_of,
    speeds_to_avoid,
    turns,
)
from fenics_mech.safety.shapes import shape_of
from fenics_mech.scene import RectangleSection
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.views.judgements import Level, judgements, verdict
from fenics_mech.views.words import DEGREE, share, short

FAILS = {
    "yield": "yields",
    "buckling in plane": "buckles in the plane of motion",
    "buckling across": "buckles across the plane of motion",
    "lateral torsion": "tips sideways by bending",
    "fatigue": "breaks by fatigue",
    "pin and eye": "fails at a pin",
    "deflection": "deflects",
    "resonance": "runs near a resonance",
}
SIZED = {"height": "deep", "width": "wide"}  # adjectives of dimensions
LARGEST = 100.0  # factor from which on its size tells nothing
GROWS = 1.0 + 1e-6  # a multiplier above it: rounding of steps is 1e-8
ENOUGH = 3.0  # times the wanted factor: beyond it a member is no news
MOST_MEMBERS = 2  # that are listed beside the first


def frequency_ranges(result: Result) -> list[tuple[float, float]]:
    """Give the lowest and highest frequency of each mode over the cycle (Hz), 0 of rigid bodies."""
    # They are those of the mechanism held at each position: of the response, or where it has no modes, of the few
    # positions at which critical speeds are sought.
    data = result.data
    if "frequency" in data:
        frequency = data["frequency"].transpose("theta", "mode").to_numpy()
        return [(float(low), float(high)) for low, high in zip(frequency.min(axis=0), frequency.max(axis=0))]
    if "mode_frequency" not in data:
        return []
    ends = np.nan_to_num(data["mode_frequency"].sel(limit=["lowest", "highest"]).transpose("mode", "limit").to_numpy())
    return [(float(low), float(high)) for low, high in ends]


def ranges_in_words(ranges: Sequence[tuple[float, float]]) -> str:
    """Write ranges of frequencies after one another, one that does not vary as a number."""
    texts = [a if (a := short(low)) == (b := short(high)) else f"{a}\N{EN DASH}{b}" for low, high in ranges]
    return ", ".join(texts)


def across_in_words(result: Result, most: int | None = None) -> str:
    """Tell natural frequencies and growth across the plane; nothing where they were not asked for."""
    data = result.data
    if "frequency_across" not in data:
        return ""
    modes = data["frequency_across"].transpose("mode_across", "position_angle").to_numpy()
    known = [mode for mode in modes if not np.isnan(mode).all()]
    said = f"{ranges_in_words([(np.nanmin(mode), np.nanmax(mode)) for mode in known[:most]])} Hz across the plane"
    growth = float(data["multiplier_across"].max()) if data.sizes.get("disturbance_across") else 0.0
    return f"{said}; a disturbance there grows by a factor of {short(growth)} in each cycle" if growth > GROWS else said


def speeds_in_words(result: Result, most: int = 2) -> str:
    """Name the nearest speeds to avoid below and above the present one; "" where critical speeds are not sought."""
    if why := result.data.attrs.get("critical_speeds_unknown"):
        return f"not known: {why}"
    if not critical_speeds(result):
        return ""
    near = sorted(speeds_to_avoid(result, 1), key=lambda one: abs(one.distance))[:most]
    causes = [  # one alone is told without its link
        cause_of(result, one) if most > 1 else f"{one.numbered} {multiple_of(result, one)}" for one in near
    ]
    said = [f"{band_of(result, one)} ({cause}: {rise_of(one)})" for one, cause in zip(near, causes)]
    orders = float(result.data["critical_order"].max())
    none = f"none: up to {orders:g} times the drive no harmonic makes a mode add {share(STRONG)} to the peak strain"
    return "; ".join(said) or none


def band_of(result: Result, one: CriticalSpeed) -> str:
    """Write the range of a speed to avoid, and whether the present speed is in it."""
    return turns(result, *(one.band or (one.speed, one.speed))) + (", where it runs" if runs_in(result, one) else "")


def runs_in(result: Result, one: CriticalSpeed) -> bool:
    """Say whether the present speed is in the range of a speed to avoid."""
    low, high = one.band or (one.speed, one.speed)
    return low <= abs(result.scene.cycle_rate) <= high


def rise_of(one: CriticalSpeed) -> str:
    """Write what the mode's vibration adds to the peak strain."""
    if not np.isfinite(one.rise):
        return "any strain, as nothing damps it"
    return f"about +{share(one.rise)} strain" if one.rise < 1 else f"about {short(1 + one.rise, 2)} times the strain"


def safety_sentences(result: Result, units: AnswerUnits) -> tuple[Level, list[str]]:
    """Say whether a machine is safe, what would help, and what is not decided."""
    found = judge(result)
    level: Level = "good"
    if found.governing is None:
        level, said = "warn", ["Whether it is safe is not known: the scene does not tell enough."]
    elif not found.safe:
        member, check = found.governing
        level, said = "bad", [f"Not safe: {_failing(member, check)}.", _cured(result, check, found.cure, units)]
        others = [one.mode for one in found.checks[member] if one.decides and one.share < 1 and one is not check]
        said += [f"It fails by {' and '.join(others)} too."] if others else []
    elif verdict(judgements(result))[0] == "bad":
        level, said = "warn", ["Whether it is safe is not known, as the numbers are not to be used."]
    else:
        member, check = found.governing
        open_modes = undecided(found)
        far = ", as far as the scene tells" if open_modes else ""
        count = len(result.cases)
        cases = f" in {'both' if count == 2 else f'all {count}'} load cases" if count > 1 else ""
        said = [f"Safe{cases}{far}: the least factor is that of member {member!r}, {_of(check)}."]
    if found.doubtful is not None:
        member, check = found.doubtful
        level = "warn" if level == "good" else level
        names = sorted({text.split()[0] for text in check.rests_on} & set(result.scene.materials))
        key = "ultimate" if check.mode == "fatigue" else "yield"
        state = " and ".join(f"materials.{name}.{key}" for name in names)
        said.append(f"By assumptions {_failing(member, check)}: state {state}.")
    elif level == "good" and (open_modes := undecided(found)):
        said.append(f"Not decided: {', '.join(open_modes)}.")
    return level, said


def _failing(member: str, check: Check) -> str:
    detail, case = f"{check.detail}: " * bool(check.detail), f", case {check.case}" * bool(check.case)
    at = f"at {short(check.share, 2)} of its wanted factor"
    return f"member {member!r} {FAILS[check.mode]} {at} ({detail}{sized(check)}{case})"


def _of(check: Check) -> str:
    """Write factors and mode: "1.2 of 1.5 by yield"."""
    detail = f" ({check.detail})" if check.detail else ""
    case = f" in case {check.case}" if check.case else ""
    return f"{sized(check)} by {check.mode}{detail}{case}"


def factor(check: Check) -> str:
    """Write a factor of safety; a large one tells nothing more."""
    return f"> {LARGEST:g}" if check.factor > LARGEST else short(check.factor)


def sized(check: Check) -> str:
    """Write a factor of safety and the wanted one; of a resonance the distance of the speed from it in percent."""
    if check.kind == "share":
        return f"{short(100 * check.factor)} % of {100 * check.wanted:g} %"
    return f"{factor(check)} of {check.wanted:g}"


def acting(check: Check, units: AnswerUnits) -> str:
    """Write what acts and what is borne, and at which drive angle."""
    if check.kind == "share":
        return check.detail
    if math.isinf(check.factor):
        return "nothing acts"
    acts, borne = (short(units.number(value, check.kind)) for value in (check.acting, check.borne))
    at = "" if check.theta is None else f" at {math.degrees(check.theta) % 360:.0f}{DEGREE}"
    detail = f", {check.detail}" if check.detail else ""
    case = f", case {check.case}" if check.case else ""
    return f"{acts} of {borne} {units.label(check.kind)}{at}{detail}{case}"


def _cured(result: Result, check: Check, cure: Cure | None, units: AnswerUnits) -> str:
    """Say which dimension would do."""
    if cure is None and check.mode == "deflection":
        return "Its ends move with the links that carry it: stiffen these."
    if cure is None:
        return "Lower the loads or the speed: no dimension of it alone would do."
    if not cure.key:
        return f"For these loads make its section {short(cure.needed)} times as large ({cure.place})."
    needed, now = (units.text(value, "length") for value in (cure.needed, cure.now))
    if cure.place.startswith("joints."):
        return f"For these loads make {cure.place} {needed}, now {now}."
    section = shape_of(result.scene.sections[cure.place.split(".")[1]])
    thin = cure.key == "width" and isinstance(section, RectangleSection) and section.width < section.height
    made = f"its diameter {needed}" if cure.key == "diameter" else f"it {needed} {'thick' if thin else SIZED[cure.key]}"
    return f"For these loads make {made}, now {now} ({cure.place})."


def undecided(found: Verdict) -> list[str]:
    """Name the modes by which no member is judged but by assumptions, in the order of `KEYS`."""
    decided = {check.mode for checks in found.checks.values() for check in checks if check.decides}
    return [mode for mode in KEYS if mode not in decided and mode not in ("deflection", "resonance")]


def safety_row(result: Result) -> str:
    """Give the least factors of the members after the first, which is told before, as far as they tell anything."""
    found = judge(result)
    named = [(member, check) for member in found.checks if (check := found.least(member)) is not None]
    told = [(member, check) for member, check in named[1:] if check.factor <= min(LARGEST, ENOUGH * check.wanted)]
    return ", ".join(f"{member} {_of(check)}" for member, check in told[: 1 if result.cases else MOST_MEMBERS])


def safety_table(result: Result, units: AnswerUnits) -> list[str]:
    """Give a line for each mode of each member that was judged, then what was assumed and what was not judged."""
    found = judge(result)
    said = [
        f"{member}, {check.mode}: {sized(check)} ({acting(check, units)})"
        + ("" if check.decides else ", by assumption")
        for member, checks in found.checks.items()
        for check in checks
        if check.known
    ]
    said += [f"Taken as: {'; '.join(found.assumed)}."] if found.assumed else []
    return [*said, f"Not judged: {'; '.join(found.missing)}."] if found.missing else said


def safety_figures(result: Result, units: AnswerUnits) -> dict[str, Any]:
    """Give the verdict as plain data."""
    found = judge(result)
    level, sentences = safety_sentences(result, units)
    figures: dict[str, Any] = {"level": level, "safe": found.safe, "sentences": sentences}
    if found.governing is not None:
        member, check = found.governing
        figures |= {"min": _finite(check.share), "member": member, "mode": check.mode}
        figures |= {"case": check.case} if check.case else {}
    if found.cure is not None:
        figures["cure"] = {"place": found.cure.place, "now": found.cure.now, "needed": found.cure.needed}
    figures["members"] = {
        member: {
            check.mode: {
                "factor": _finite(check.factor),
                "wanted": check.wanted,
                "acting": check.acting,
                "borne": check.borne,
                "decides": check.decides,
                **({"case": check.case} if check.case else {}),
                "assumed": [*check.rests_on, *check.assumed],
            }
            for check in checks
            if check.known
        }
        for member, checks in found.checks.items()
    }
    return figures | {"assumed": list(found.assumed), "not_judged": list(found.missing)}


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
