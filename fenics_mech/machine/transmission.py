"""Transmission angles: how well pairs of links take the motion of the driven ones on.

Two links that meet at a pin, each held by links whose motion is known, are put together there. Each alone lets the pin
move in one direction: across the line to the link's other pin, or along its guide. The acute angle between these two
directions is the transmission angle: 90 degrees are best, and at 0 the linkage locks or is free. A link on a pin and in
a slot is such a pair with its guide. Only a linkage that is made of such pairs, one after another, has these angles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.kinematics import Motion
from fenics_mech.scene import Prismatic, Scene, Slot


class _Joint(NamedTuple):
    name: str
    bodies: tuple[str, str]
    kind: str  # "rigid", "pin", "slide" (without turning), "slot", "driven" (a slot at a given stroke: in no pair)
    place: Array  # in the fixed frame (m), (positions, 2)
    along: Array  # of the guide, (positions, 2); of a pin nothing is meant


def transmission_angles(scene: Scene, motion: Motion) -> dict[tuple[str, tuple[str, ...]], Array] | None:
    """Give the transmission angle (rad) by joint and links ``(positions,)``; None where some are not known."""
    joints, known = _joints(scene, motion), {"ground"}
    found: dict[tuple[str, tuple[str, ...]], Array] = {}

    def mover(link: str, joint: _Joint) -> Array | None:
        """Give the direction in which a link, held by known bodies only, lets the place of a joint move."""
        for holder in joints:
            if holder.kind in ("pin", "slide") and link in holder.bodies and known & set(holder.bodies):
                x, y = (joint.place - holder.place).T
                return np.stack([-y, x], axis=-1) if holder.kind == "pin" else holder.along
        return None

    def joined() -> set[str]:
        """Give the links whose motion is known next, by one joint more."""
        for joint in joints:
            new = tuple(body for body in joint.bodies if body not in known)
            if len(new) == 1 and joint.kind == "rigid":
                return set(new)
            moves = [move for link in new if (move := mover(link, joint)) is not None]
            if joint.kind == "slot":
                moves.append(joint.along)
            if len(moves) == 2 and len(new) == {"pin": 2, "slot": 1}.get(joint.kind):
                one, other = moves
                cross = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
                found[joint.name, new] = np.arctan2(np.abs(cross), np.abs(np.sum(one * other, axis=-1)))
                return set(new)
        return set()

    while new := joined():
        known |= new
    return found if len(known) == len(scene.links) + 1 else None


def _joints(scene: Scene, motion: Motion) -> list[_Joint]:
    """Give pins, then guides, with their places and directions in the fixed frame."""
    found = []
    for name, joint in scene.constraints.items():
        (first, _), *others = map(scene.point, joint.connect)
        slides, driven = isinstance(joint, Slot | Prismatic), name in scene.moved_joints
        kind = {"weld": "rigid", "prismatic": "slide", "slot": "slot"}.get(joint.kind, "pin")
        if driven:
            kind = "driven" if kind == "slot" else "rigid"
        angle = np.zeros(len(motion.theta)) if first == "ground" else motion.angle[:, motion.links.index(first)]
        angle = angle + (scene.guide_angle(joint) if isinstance(joint, Slot | Prismatic) else 0.0)
        along = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        for second, pin in others:
            found.append((slides, _Joint(name, (first, second), kind, motion.of_point(second, pin)[0], along)))
    return [joint for slides in (False, True) for is_guide, joint in found if is_guide is slides]
