"""What the theory of a result does not know of, in words."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

from fenics_mech.accuracy.joint_map_errors import JOINTS, remedy
from fenics_mech.recovery.result import Result
from fenics_mech.views.words import sentence, share

if TYPE_CHECKING:
    from fenics_mech.views.judgements import Judgement

Reason = tuple[Literal["warn", "bad"], str, str]  # as of `Judgement`


def and_beyond(known: Judgement, result: Result) -> list[Judgement]:
    """Give reasons why numbers of a result are wrong that its theory does not know of, beside what it knows.

    Beside them nothing is called good by the theory alone.

    Parameters
    ----------
    known
        What the theory says.
    result
        The result.
    """
    beyond = [replace(known, level=level, title=title, text=text) for level, title, text in _by_joints(result)]
    return beyond if beyond and known.level == "good" else [known, *beyond]


def _by_joints(result: Result) -> list[Reason]:
    """Say what rigid arms and guides leave out of an answer, its frequencies and its stiffness."""
    attributes, found = result.data.attrs, list[Reason]()
    if "joints_place" not in attributes:
        return found
    place, turn = str(attributes["joints_place"]), float(attributes["joints_turn"])
    of_answer, of_frequency, of_stiffness = (
        float(attributes[f"joints_{name}"]) for name in ("share", "frequency", "buckling")
    )
    if of_answer >= JOINTS.warned:
        text = (
            f"{sentence(place)} turns elastically by up to {turn:.3g} rad. The moment of the forces by this turn is "
            f"left out, which is about {share(of_answer)} of a strain, deflection or joint force. {remedy(place)}."
        )
        level: Literal["warn", "bad"] = "warn" if of_answer < JOINTS.refused else "bad"
        found.append((level, f"rigid arms and guides leave out {share(of_answer)}", text))
    if of_frequency >= JOINTS.warned:
        text = (
            f"The moment of the forces on {place} by its turn is left out of the natural frequencies, of which it "
            f"changes one by about {share(of_frequency)}. {remedy(place)}."
        )
        found.append(("warn", f"frequencies are wrong by up to {share(of_frequency)}", text))
    if of_stiffness >= JOINTS.of_stiffness:
        text = (
            f"The moment of the forces on {place} by its turn is left out. It takes away {share(of_stiffness)} of the "
            f"stiffness, so that buckling loads are lower than those that are told. {remedy(place)}."
        )
        level = "warn" if of_stiffness < 1 else "bad"
        found.append((level, "nearer to buckling than is told", text))
    return found
