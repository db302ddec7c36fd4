"""Transmission angles: how well pairs of links take the motion of the driven ones on.

Two links that meet at a pin, each held by links whose motion is known, are put together there. Each alone lets the pin
move in one direction: across the line to the link's other pin, or along its guide. The acute angle between these two
directions is the transmission angle: 90 degrees are best, and at 0 the linkage locks or is free. A link on a pin and in
a slot is such a pair with its guide. Only a linkage that is made of such pairs, one after another, has these angles.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.kinematics.assembly import AssemblyBranch, coordinates_at
from fenics_mech.kinematics.conditioning import CONDITION
from fenics_mech.kinematics.loops import Loops
from fenics_mech.kinematics.minimum import minimum
from fenics_mech.scene.numbering import GROUND


@dataclass(frozen=True)
class Transmission:
    """The worst transmission angle of a pair of links, or of a link in a slot."""

    joint: str  # where they meet
    links: tuple[str, ...]  # their names
    theta: float  # drive coordinate (rad), 0 to 2 pi
    angle: float  # the angle there (rad), 0 to pi/2


@dataclass(frozen=True)
class _Joint:
    name: str
    bodies: tuple[int, int]
    kind: str  # "rigid", "pin", "slide" (without turning), "slot", "driven" (a slot at a given stroke: in no pair)
    place: Array  # in the fixed frame (m), (positions, 2)
    along: Array  # of the guide, (positions, 2); of a pin nothing, (positions, 0, 2)


def worst_transmission(loops: Loops, branch: AssemblyBranch) -> tuple[Transmission, ...]:
    """Find the worst transmission angle of every pair over a turn of the drive; nothing where some are not known."""

    def angles(theta: Array) -> dict[tuple[str, tuple[str, ...]], Array]:
        return transmission_angles(loops, coordinates_at(loops, theta, branch)) or {}

    def angle(pair: tuple[str, tuple[str, ...]]) -> Callable[[Array], Array]:
        return lambda theta: angles(theta)[pair]

    thetas = np.linspace(0.0, 2 * np.pi, CONDITION.samples)
    step, found = thetas[1] - thetas[0], []
    for pair, values in angles(thetas).items():
        middle = thetas[values.argmin()]
        theta, least = minimum(angle(pair), middle - step, middle + step, 1e-7)
        found.append(Transmission(*pair, theta % (2 * np.pi), least))
    return tuple(found)


def transmission_angles(loops: Loops, q: Array) -> dict[tuple[str, tuple[str, ...]], Array] | None:
    """Transmission angle (rad) by joint and links, ``(positions,)``; None where some are not known."""
    # q (positions, 3 links)
    joints, known = _joints(loops, q), {GROUND}
    found: dict[tuple[str, tuple[str, ...]], Array] = {}

    def mover(link: int, joint: _Joint) -> Array | None:
        """Give the direction in which a link, held by known bodies only, lets the place of a joint move."""
        for holder in joints:
            if holder.kind in ("pin", "slide") and link in holder.bodies and known & set(holder.bodies):
                return _turned(joint.place - holder.place) if holder.kind == "pin" else holder.along
        return None

    def joined() -> set[int]:
        """Give the links whose motion is known next, by one joint more."""
        for joint in joints:
            new = tuple(body for body in joint.bodies if body not in known)
            if len(new) == 1 and joint.kind == "rigid":
                return set(new)
            moves = [move for link in new if (move := mover(link, joint)) is not None]
            if joint.kind == "slot":
                moves.append(joint.along)
            if len(moves) == 2 and len(new) == {"pin": 2, "slot": 1}.get(joint.kind):
                found[joint.name, tuple(loops.links[link] for link in new)] = _angle(*moves)
                return set(new)
        return set()

    while new := joined():
        known |= new
    return found if len(known) == len(loops.links) + 1 else None


def _joints(loops: Loops, q: Array) -> list[_Joint]:
    """Give the joints with their places and, in the fixed frame, the directions of their guides."""
    stiff, driven = set(loops.angles.name), set(loops.driven_angles.name)
    pinned, guided = loops.places(q, loops.points), loops.places(q, loops.lines)
    tangents = loops.tangents(q, loops.lines)
    found = []
    for i, (name, bodies) in enumerate(zip(loops.points.name, loops.points.body)):
        kind = "rigid" if name in stiff | driven else "pin"
        found.append(_Joint(name, (int(bodies[0]), int(bodies[1])), kind, pinned[:, i, 1], tangents[:, :0]))
    for i, (name, bodies) in enumerate(zip(loops.lines.name, loops.lines.body)):
        kind = "slide" if name in stiff else "slot"
        if name in loops.driven_strokes.name:
            kind = "rigid" if name in stiff else "driven"
        found.append(_Joint(name, (int(bodies[0]), int(bodies[1])), kind, guided[:, i, 1], tangents[:, i]))
    return found


def _turned(vectors: Array) -> Array:
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)


def _angle(one: Array, other: Array) -> Array:
    """Acute angle between directions, ``(positions,)``."""
    cross = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    return np.arctan2(np.abs(cross), np.abs(np.sum(one * other, axis=-1)))
