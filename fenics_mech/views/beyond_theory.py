"""What the theory of a result does not know of, in words."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from fenics_mech.recovery.result import Result
from fenics_mech.safety import buckled_sideways
from fenics_mech.views.judgement import Judgement
from fenics_mech.views.prefixes import prefixed
from fenics_mech.views.words import short

MOST_NAMED = 3  # members that are named in a sentence
Reason = tuple[Literal["warn", "bad"], str, str]  # as of `Judgement`


def and_beyond(known: Judgement, result: Result) -> list[Judgement]:
    """Give reasons why numbers of a result are wrong that its theory does not know of, beside what it knows."""
    # Beside them nothing is called good by the theory alone.
    found = _sideways(result)
    beyond = [replace(known, level=level, title=title, text=text) for level, title, text in found]
    return beyond if beyond and known.level == "good" else [known, *beyond]


def _sideways(result: Result) -> list[Reason]:
    """Say which members buckle across the plane of motion, or may."""
    if not (found := buckled_sideways(result.scene, result.data)):
        return []
    units, said = prefixed(result, result.scene.answer_units), []
    for one in found[:MOST_NAMED]:
        force, pinned, clamped = (
            f"{short(units.number(load, 'force'))} {units.label('force')}"
            for load in (one.force, one.pinned, one.clamped)
        )
        ends = f"{pinned} with pinned ends and {clamped} with clamped ends"
        if one.free:
            ends = f"{clamped}, as one end is free"
        said.append(f"Member {one.member} is pressed by up to {force}: across the plane it buckles at {ends}.")
    if more := len(found) - MOST_NAMED:
        said += [f"So may {more} more."] if more > 0 else []
    text = (
        f"Nothing is computed across the plane of motion. {' '.join(said)} Take sections that are wider there, lower "
        "loads, or guides that hold the members in the plane."
    )
    surely = [one.member for one in found if one.buckles]
    if surely:
        return [("bad", f"sideways buckling of {', '.join(surely[:MOST_NAMED])}", text)]
    return [("warn", f"sideways buckling of {', '.join(one.member for one in found[:MOST_NAMED])} is possible", text)]
