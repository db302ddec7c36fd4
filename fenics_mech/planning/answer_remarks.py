"""What is said beside an answer: warnings, among them of a tolerance that is not met, and what was assumed."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from fenics_mech.effects import EFFECTS
from fenics_mech.effects.known import SHEAR, VIBRATION
from fenics_mech.effects.shear import assumed
from fenics_mech.errors import percent, percent_of_error
from fenics_mech.estimate.quantities import ERROR_VARIABLES
from fenics_mech.estimate.remarks import UNKNOWN
from fenics_mech.recovery import Result
from fenics_mech.recovery.faces import exceeded
from fenics_mech.scene import Scene
from fenics_mech.scene.plausibility import implausible

WORDS = {
    "strain": "strains",
    "deflection": "deflections",
    "joint_force": "joint forces",
    "torque": "efforts of the drives",
}
CAUSES = {  # sources of errors that the mesh and the steps of a tolerance do not lower
    "theory": "linear theory",
    "effects": "effects left out",
    "joints": "rigid arms and guides",
    "positions": "peaks between positions",
}
NUMBERS_IN_WORDS = {"elements": "elements a member"}
CURES = {
    "joints": "Take a stiff member that bends in place of `rigid`, or lower loads or speed",
    "positions": "Take more sub_intervals",
}


def answer_remarks(scene: Scene, result: Result, of_starts: Iterable[str] = ()) -> dict[str, str]:
    """Give what is said beside an answer, as attributes of the result: lists of sentences as JSON."""
    too_weak = exceeded(scene.members(), scene.sections, scene.materials, result.data)
    taken = assumed(result.scene) if SHEAR in result.scene.named_effects else ()
    coarse = [f"too coarse: {text}"] if (text := result.data.attrs.get("coarse_because")) else []
    warned = [*unmet(result), *coarse, *implausible(scene), *of_starts, *too_weak]
    told = {"warnings": warned, "notices": [*taken, *_added(scene, result.scene)]}
    return {name: json.dumps(sentences) for name, sentences in told.items()}


def _added(stated: Scene, taken: Scene) -> list[str]:
    """Say which effects act that a list of effects leaves out, and which of it they replace."""
    if stated.effects == "auto":
        return []
    more = [name for name in taken.named_effects if name not in stated.named_effects]
    left = [repr(name) for name in stated.named_effects if name not in taken.named_effects]
    instead = f" in place of {' and '.join(left)}" if left else ""
    return [f"{' and '.join(map(repr, more))} act{instead}: the equation that answers always holds it"] if more else []


def unmet(result: Result) -> list[str]:
    """Say which tolerances a result does not meet by its estimates, why, and what to do about it."""
    # Steps and mesh are within the tolerance, or there is no result. What is beyond it has one of the other causes.
    data, found = result.data, list[str]()
    unknown = UNKNOWN in data.attrs.get("not_estimated", "")
    for what, most in result.scene.tolerances.items():
        prefix = ERROR_VARIABLES[what][1]
        if (name := f"{prefix}relative_error") not in data:
            continue
        errors = dict(zip(map(str, data["source"].to_numpy()), data[name].to_numpy().tolist()))
        total = float(data.attrs[f"{prefix}error_estimate"])
        if total <= most and not unknown:
            continue
        worst = max((source for source in errors if source in CAUSES), key=errors.__getitem__, default="")
        size = f"at most {percent_of_error(total)}"
        if total <= most or not worst:
            size += f" without {UNKNOWN}, which is not estimated"
        else:
            size += f", and {percent_of_error(errors[worst])} is by {CAUSES[worst]}"
        found.append(f"{percent(most)} of the {WORDS[what]} is not met: the error is {size}. {_cure(result, worst)}")
    return [f"tolerance: {text}" for text in found]


def made_finer(result: Result) -> str:
    """Say which mesh and steps the program took in place of its usual ones; empty where these suffice."""
    said = in_words(str(result.data.attrs.get("refined", "")))
    return f"Chosen for it: {said}." if said else ""


def in_words(numbers: str) -> str:
    """Say which mesh and steps were taken in place of the usual ones."""
    said = [f"{value:g} {NUMBERS_IN_WORDS.get(name, name)}" for name, value in json.loads(numbers or "{}").items()]
    return " and ".join(said)


def leaves_vibration(decided: Sequence[Mapping[str, Any]]) -> bool:
    """Whether vibration is the largest effect that is left out, as of a quasi-static method: no tolerance takes it."""
    held = {EFFECTS[one["name"]].replaces for one in decided if one["acts"] and one["name"] in EFFECTS}
    sizes = {one["name"]: one["size"] or 0.0 for one in decided if not one["acts"] and one["name"] not in held}
    return 0 < sizes.get(VIBRATION, 0.0) == max(sizes.values(), default=0.0)


def _cure(result: Result, source: str) -> str:
    """Say what brings an error within its tolerance, by its largest source."""
    if source in CURES:
        return CURES[source]
    decided = json.loads(result.data.attrs["effects"])
    if source == "effects" and leaves_vibration(decided):
        return "Vibration is the largest of these: write analysis.method = 'periodic'"
    lacking = [one for one in decided if one["lacking"]]
    if source == "effects" and lacking:
        return "; ".join(f"The effect {one['name']!r} lacks data: {one['lacking']}" for one in lacking)
    if result.scene.effects != "auto":
        return "Write effects = 'auto', or give a larger tolerance"
    return "Give a larger tolerance"
