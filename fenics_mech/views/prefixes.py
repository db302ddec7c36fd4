"""Units whose prefixes fit the numbers of a result, and what is nothing but rounding beside its forces."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from fenics_mech._constants import ROUNDING
from fenics_mech.recovery.result import Result, kept
from fenics_mech.scene.answer_units import USUAL, AnswerUnits
from fenics_mech.scene.joints import effort_units

ROUNDED_POWER = 1e-13  # the same of powers, whose means are small parts of what passes: 3e-5 of one was 1e-9 of it
FORCES = "joint_force", "axial_force", "shear_force"
PREFIXED = {  # by the usual unit: those beside it, with their size in SI
    "N": (("mN", 1e-3), ("N", 1.0), ("kN", 1e3), ("MN", 1e6)),
    "N m": (("mN m", 1e-3), ("N m", 1.0), ("kN m", 1e3), ("MN m", 1e6)),
    "MPa": (("Pa", 1.0), ("kPa", 1e3), ("MPa", 1e6), ("GPa", 1e9)),
}
LEAST, MOST = 0.1, 1e4  # in the usual unit, between which it stays
NOTHING = 1e-9  # of the largest force with an arm of 1 m: smaller moments and forces are rounding


@kept
def largest_force(result: Result) -> float:
    """Give the largest force in joints and members (N): a balanced rotor has none in its joint."""
    data = result.data
    return max((float(np.abs(data[name]).max()) for name in FORCES if name in data and data[name].size), default=0.0)


def least_moment(result: Result) -> float:
    """Give the torque (N m), or the force along a slide (N), below which one is rounding: by that force and a link."""
    return ROUNDING * largest_force(result) * _size(result)


def least_power(result: Result) -> float:
    """Give the power (W) below which one is rounding: that of the largest force at the fastest link."""
    rates = result.data["link_omega"].to_numpy() if "link_omega" in result.data else np.zeros(1)
    return ROUNDED_POWER / ROUNDING * least_moment(result) * float(np.abs(rates).max(initial=0.0))


def _size(result: Result) -> float:
    """Size of the largest link at a joint (m)."""
    return max((result.scene.size_at(joint) for joint in result.scene.joints), default=0.0)


def prefixed(result: Result, units: AnswerUnits) -> AnswerUnits:
    """Give units whose prefixes fit the largest numbers of a result: 38 kN, not 38200 N. Units that are stated stay."""
    return fitted(_largest(result), units)


def labelled(units: AnswerUnits, kind: str, name: str = "") -> str:
    """Name what an axis or a column shows, with its unit."""
    return f"{name or kind} ({units.label(kind)})"


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
