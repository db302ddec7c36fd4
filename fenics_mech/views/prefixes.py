"""Units whose prefixes fit the numbers of a result, so that no number needs an exponent."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from fenics_mech.recovery.result import Result, kept
from fenics_mech.scene.answer_units import USUAL, AnswerUnits
from fenics_mech.scene.joints import effort_units
from fenics_mech.views.nothing import largest_force

PREFIXED = {  # by the usual unit: those beside it, with their size in SI
    "N": (("mN", 1e-3), ("N", 1.0), ("kN", 1e3), ("MN", 1e6)),
    "N m": (("mN m", 1e-3), ("N m", 1.0), ("kN m", 1e3), ("MN m", 1e6)),
    "MPa": (("Pa", 1.0), ("kPa", 1e3), ("MPa", 1e6), ("GPa", 1e9)),
}
LEAST, MOST = 0.1, 1e4  # in the usual unit, between which it stays
NOTHING = 1e-9  # of the largest force with an arm of 1 m: smaller moments and forces are rounding


def prefixed(result: Result, units: AnswerUnits) -> AnswerUnits:
    """Give units whose prefixes fit the largest numbers of a result: 38 kN, not 38200 N. Units that are stated stay."""
    return fitted(_largest(result), units)


def fitted(of_kinds: Mapping[str, float], units: AnswerUnits) -> AnswerUnits:
    """Give units whose prefixes fit numbers; those that are stated stay."""
    known = dict(units.known)
    for kind, largest in of_kinds.items():
        if kind not in USUAL or USUAL[kind][0] not in PREFIXED:
            continue
        name, size = USUAL[kind]
        if kind in units.stated or largest == 0 or LEAST <= largest / size < MOST:
            continue
        fitting = [one for one in PREFIXED[name] if largest / one[1] < MOST]
        known[kind] = next(iter(fitting), PREFIXED[name][-1])
    return AnswerUnits(known, units.stated)


@kept
def _largest(result: Result) -> dict[str, float]:
    """Largest force, moment and stress of a result, of all its load cases, in SI."""
    if result.cases:
        each = [_largest(one) for one in result.cases.values()]
        return {kind: max(one[kind] for one in each) for kind in each[0]}
    data = result.data
    moved = effort_units(result.scene.moved_joints, result.scene.joints)
    turns = moved == ["N m"]
    names = {"force": ["joint_force", "shaking_force"], "moment": ["shaking_moment"], "stress": ["stress"]}
    names["moment" if turns else "force"] += ["input_torque"] if len(moved) == 1 else []
    found = {
        kind: max((float(np.abs(data[name]).max()) for name in of if name in data and data[name].size), default=0.0)
        for kind, of in names.items()
    }
    return without_rounding(found, largest_force(result))


def without_rounding(of_kinds: Mapping[str, float], force: float) -> dict[str, float]:
    """Give the largest of each kind of unit, with 0 for forces and moments that are rounding or not finite."""
    # force: largest force beside which they are rounding (N)
    return {
        kind: largest if np.isfinite(largest) and (kind == "stress" or largest >= NOTHING * force) else 0.0
        for kind, largest in of_kinds.items()
    }
