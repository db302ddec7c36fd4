"""What lowers an error of a result: never what its scene already states."""

from __future__ import annotations

import json
from typing import Any

from fenics_mech.effects import EFFECTS
from fenics_mech.effects.known import EXACT_STRAINS
from fenics_mech.errors import SceneError, percent
from fenics_mech.planning.answer_remarks import leaves_vibration
from fenics_mech.planning.tolerance_refusals import refuse_stated, refuse_unknown
from fenics_mech.recovery import Result

REMEDIES = {
    "mesh": "more elements",
    "time": "more sub_intervals",
    "positions": "more sub_intervals",
    "harmonics": "more harmonics",
    "modes": "more modes",
    "stations": "more stations",
}
SMALLER = "a smaller tolerance"


def _decided(result: Result) -> list[dict[str, Any]]:
    """What was decided about every effect."""
    found: list[dict[str, Any]] = json.loads(result.data.attrs["effects"])
    return found


def chose_effects(result: Result) -> bool:
    """Whether a result says how large an effect is that it leaves out."""
    return any(one["size"] is not None for one in _decided(result))


def advice(result: Result) -> str:
    """Say what takes along what linear theory leaves out."""
    if chose_effects(result):
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
        if _takes_tolerance(result):
            stated = result.scene.tolerances
            return f", which {SMALLER if stated else f'a tolerance below {percent(result.scene.neglected)}'} lowers"
        largest = max(left, key=lambda one: one["size"] or 0.0)["name"]
        return f", which effects = {_with(result, largest)} lowers"
    if source not in REMEDIES:
        return ""
    return f", which {_of_numbers(result, source)} lowers"


def _of_numbers(result: Result, source: str) -> str:
    """Name what lowers an error by steps, mesh, modes or stations."""
    analysis = result.scene.analysis
    if "chosen" in result.data.attrs:
        return SMALLER
    if source == "time" and analysis.method == "transient":
        return "a smaller analysis.time_tolerance"
    return REMEDIES[source]


def _with(result: Result, name: str) -> str:
    """List the effects of a result that a scene names, and one more, without that which it holds."""
    acting = [one["name"] for one in _decided(result) if one["acts"] and one["name"] in EFFECTS]
    named = [one for one in acting if not EFFECTS[one].stated_by and one != EFFECTS[name].replaces]
    return str([*named, name])


def _takes_tolerance(result: Result) -> bool:
    """Whether a tolerance can be stated for the scene of a result."""
    try:
        refuse_stated(result.scene)
        refuse_unknown(result.scene)
    except SceneError:
        return False
    return True
