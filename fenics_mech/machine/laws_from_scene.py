"""Efforts in freedoms, and laws of joints, as terms of a scene's machine."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.scene.freedoms import Freedom, with_slopes
from fenics_mech.terms import Effort, Term

if TYPE_CHECKING:
    from fenics_mech.machine.acting_from_scene import OfJoint
    from fenics_mech.machine.machine import Machine


def effort_in(machine: Machine, name: str, freedom: Freedom, joint: OfJoint) -> Term:
    """Give the term of the effort in a freedom, and let what turns with its second body have its inertia.

    Parameters
    ----------
    machine
        The machine.
    name
        Of the freedom.
    freedom
        The freedom.
    joint
        Its ends, and the measure that is its angle or stroke.

    Raises
    ------
    SceneError
        When an inertia turns between two bodies that both move.
    """
    pair, measure, _ = joint
    start = freedom.start or 0.0
    if freedom.inertia:
        moving = [end for end in pair if end.pose != machine.ground]
        if len(moving) > 1:
            raise SceneError(
                "no term states inertia between two bodies that both move yet", place=f"freedoms.{name}.inertia"
            )
        machine.masses.add_body(moving[0], 0.0, np.eye(2) * freedom.inertia / 2)

    def law(t: Array, place: Array, rate: Array) -> tuple[Array, Array, Array]:
        return with_slopes(freedom.effort, t, (place, rate), start)

    return Effort(pair, measure, law, lambda t: np.full(len(t), start))
