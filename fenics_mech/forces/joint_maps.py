"""What joints leave out of forces and displacements, as they are linearised about the rigid motion.

A point of a rigid link at an arm r from its centre is taken to move by ``u + phi Q r``, Q being a quarter turn. A pin
in a guide is taken to move by ``d phi Q t + s t`` against the guide's point: t is the guide's direction, d the pin's
rigid distance along it, s what the pin slides beside that. Their second order in phi and s,

    -phi^2 r/2,    s phi Q t - phi^2 d t/2,

is left out of places. With forces F on the points it is also left out of the equilibrium: as a moment
``-phi sum F . r`` on a rigid link, and as ``-s F . Q t`` on the guide's turn with ``-phi F . Q t`` on the slide.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from fenics_mech._arrays import Array, Index, turned
from fenics_mech._constants import TINY
from fenics_mech.beams.attachment import QUARTER, Attachment
from fenics_mech.effects.dampers import damper_forces
from fenics_mech.effects.springs import spring_forces
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.joint_forces import Reactions
from fenics_mech.kinematics import Motion
from fenics_mech.mechanism import System
from fenics_mech.mechanism.constraints import ConstraintEquation
from fenics_mech.mechanism.contact import travelled
from fenics_mech.scene import Load, Prismatic, Scene, Slot
from fenics_mech.scene.numbering import GROUND
from fenics_mech.scene.springs_dampers import Hinge

RIGID = "the rigid link"


@dataclass(frozen=True)
class Motions:
    """A turn or a slide, of which joints leave out the second order.

    Parameters
    ----------
    place
        The rigid link or the guide, in words.
    dofs, values
        Nodal dofs that make it, and how much of it each makes, ``(angles, k)``.
    """

    place: str
    dofs: Index
    values: Array

    def of(self, v: Array) -> Array:
        """Give the turn (rad) or the slide (m) by a displacement of the nodes, both ``(angles, ...)``."""
        return np.asarray(np.sum(np.take_along_axis(v, self.dofs, axis=1) * self.values, axis=1))

    def forces(self, force: Array, size: int) -> Array:
        """Give the forces on the nodal dofs that do the work of one on the motion, ``(angles, nodal dofs)``."""
        found = np.zeros((len(force), size))
        np.add.at(found, (np.arange(len(force))[:, None], self.dofs), force[:, None] * self.values)
        return found


@dataclass(frozen=True)
class Guide:
    """A guide on a link that turns elastically.

    Parameters
    ----------
    turn, slide
        Numbers of its motions.
    link
        Its link.
    direction
        Of the guide in the axes of its link, ``(2,)``.
    arm
        From the place that turns with the link to the pin, in these axes (m), ``(angles, 2)``.
    """

    turn: int
    slide: int
    link: int
    direction: Array
    arm: Array


@dataclass
class JointMaps:
    """Turns and slides of a motion, with the forces on them that its joints leave out.

    Parameters
    ----------
    system
        The mechanism.
    motions
        The turns and slides.
    stiffness
        By the numbers of two motions: force on the first left out by the second, ``(angles,)``.
    turns
        Number of the turn of each rigid link, by its rotational dof.
    guides
        Guides by joint.
    """

    system: System
    motions: list[Motions] = field(default_factory=list)
    stiffness: defaultdict[tuple[int, int], Array | float] = field(default_factory=lambda: defaultdict(float))
    turns: dict[int, int] = field(default_factory=dict)
    guides: dict[str, Guide] = field(default_factory=dict)

    @property
    def stiffnesses(self) -> Array:
        """What is left out of the stiffness, ``(angles, motions, motions)``."""
        count = len(self.motions)
        found = np.zeros((len(self.system.motion.theta), count, count))
        for (i, j), value in self.stiffness.items():
            found[:, i, j] = value
        return found

    def sizes(self, v: Array) -> Array:
        """Give all turns and slides of a displacement, ``(angles, motions)``."""
        return np.stack([motion.of(v) for motion in self.motions], axis=1)

    def forces(self, sizes: Array) -> Array:
        """Give what is left out of the forces on the nodal dofs, by turns and slides, ``(angles, nodal dofs)``."""
        missing, height = -np.einsum("tij,tj->ti", self.stiffnesses, sizes), self.system.transformation.height
        parts = (motion.forces(force, height) for motion, force in zip(self.motions, missing.T))
        return np.asarray(sum(parts))

    def off(self, equation: ConstraintEquation, sizes: Array, ends: dict[str, Attachment]) -> Array:
        """Give by how much the bodies of a joint are not where it wants them, in the rows of an equation."""
        motion = self.system.motion
        found = np.zeros((len(sizes), equation.rows))
        if equation.rows == 1:
            return found
        point = ends[equation.body]
        if (turn := self._turn(point)) is not None:
            found -= sizes[:, turn, None] ** 2 / 2 * arm_of(point)
        if (guide := self.guides.get(equation.joint)) is not None:
            turned_by, slide = sizes[:, guide.turn, None], sizes[:, guide.slide, None]
            beside = slide * turned_by * (QUARTER @ guide.direction) - turned_by**2 / 2 * guide.arm
            angle = motion.angle[:, guide.link]
            found -= turned(beside, angle - (motion.angle[:, equation.frame] if equation.frame != GROUND else 0.0))
        return -found

    def _turn(self, point: Attachment) -> int | None:
        return self.turns.get(int(point.dofs[2])) if len(point.dofs) else None

    def carry(self, point: Attachment, arm: Array, force: Array, place: str) -> None:
        """Let a force, ``(angles, 2)``, act on a node at an arm; both are in the axes of the node's link."""
        if not np.any(arm):
            return
        rotation = int(point.dofs[2])
        if rotation not in self.turns:
            self.turns[rotation] = self.add(place, np.array([[rotation]]), np.ones((1, 1)))
        turn = self.turns[rotation]
        self.stiffness[turn, turn] += np.sum(arm * force, axis=-1)

    def add(self, place: str, dofs: Index, values: Array) -> int:
        """Add a turn or a slide, and give its number."""
        count = len(self.system.motion.theta)
        shape = (count, dofs.shape[1])
        self.motions.append(Motions(place, np.broadcast_to(dofs, shape), np.broadcast_to(values, shape)))
        return len(self.motions) - 1


def arm_of(point: Attachment) -> Array:
    """Arm of a point from its node, in the axes of its link (m), ``(2,)``.

    Parameters
    ----------
    point
        The point.
    """
    return np.array([point.shift[1, 2], -point.shift[0, 2]])


def joint_maps(scene: Scene, system: System, response: ElasticResponse, found: Reactions) -> JointMaps:
    """Find the turns and slides of which joints leave out the second order, and the forces on them.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism.
    response
        A motion of it.
    found
        Forces of the joints on their bodies; see `reactions`.
    """
    maps = JointMaps(system)
    mesh, motion = system.beams.mesh, system.motion
    for name, joint in scene.constraints.items():
        ends = [Attachment.of(scene.links, scene.joints, mesh, point) for point in joint.connect]
        if isinstance(joint, Slot | Prismatic):
            _guided(maps, scene, name, joint, (ends[0], ends[1]), found)
            continue
        for end in ends:
            if end.link != GROUND:
                force = turned(found[name, end.body, 2], -motion.angle[:, end.link])
                maps.carry(end, arm_of(end), force, f"{RIGID} {end.body!r}")
    for point, force in _applied(scene, system, response):
        in_link = turned(force, -motion.angle[:, point.link])
        maps.carry(point, arm_of(point), in_link, f"{RIGID} {point.body!r}")
    for law in system.terms.joint_laws:
        for i, link in enumerate(law.frames.links):
            point = Attachment(motion.links[link], int(link), law.frames.dofs[i], law.frames.shifts[i])
            in_link = turned(law.values[:, i, :2], -motion.angle[:, link])
            maps.carry(point, arm_of(point), in_link, f"{RIGID} {point.body!r}")
    return maps


def attachments(scene: Scene, system: System) -> dict[str, dict[str, Attachment]]:
    """Give the attachments of the joints, by joint and body.

    Parameters
    ----------
    scene, system
        The scene and its mechanism.
    """
    points = {name: joint.connect for name, joint in scene.constraints.items()}
    return {
        name: {
            end.body: end
            for end in (Attachment.of(scene.links, scene.joints, system.beams.mesh, point) for point in connect)
        }
        for name, connect in points.items()
    }


def _guided(
    maps: JointMaps,
    scene: Scene,
    name: str,
    joint: Slot | Prismatic,
    ends: tuple[Attachment, Attachment],
    found: Reactions,
) -> None:
    """Add the turn of a guide and the slide of its pin, with the force between them."""
    guide, pin = ends
    motion = maps.system.motion
    force = found[name, pin.body, 2]
    if pin.link != GROUND:
        maps.carry(pin, arm_of(pin), turned(force, -motion.angle[:, pin.link]), f"{RIGID} {pin.body!r}")
    if guide.link == GROUND:
        return
    in_guide, angle = turned(force, -motion.angle[:, guide.link]), scene.guide_angle(joint)
    contact = maps.system.transformation.constraints.contacts.get(name)
    along, place = np.array([np.cos(angle), np.sin(angle)]), f"the guide of joint {name!r} on link {guide.body!r}"
    arm = np.zeros_like(force)
    if contact is None:
        places = [scene.point(point)[1] for point in joint.connect]
        distance = travelled(motion, guide.body, pin.body, places, angle, 1)[0]
        arm = arm_of(guide) + distance[:, None] * along
        maps.carry(guide, arm, -in_guide, place)
        if int(guide.dofs[2]) in maps.turns:
            turn = maps.turns[int(guide.dofs[2])]
        else:
            turn = maps.turns[int(guide.dofs[2])] = maps.add(place, guide.dofs[None, 2:], np.ones((1, 1)))
        dofs, shape = guide.dofs[None], guide.shift[None]
    else:
        of_turn, (back,) = contact.turn(motion, 1)
        turn = maps.add(place, of_turn, -back[:, 0])
        dofs, (shape,) = contact.shift(motion, 1)
    slide = maps.add(place, *_between(motion, ends, along, (dofs, shape)))
    across = in_guide @ (QUARTER @ along)
    maps.stiffness[turn, slide] += across
    maps.stiffness[slide, turn] += across
    maps.guides[name] = Guide(turn, slide, guide.link, along, arm)


def _between(
    motion: Motion, ends: tuple[Attachment, Attachment], along: Array, moved: tuple[Index, Array]
) -> tuple[Index, Array]:
    """Dofs and values of a pin's displacement along its guide against that of the guide, ``(angles, k)`` each."""
    (guide, pin), (dofs, shape), count = ends, moved, len(motion.theta)
    values = [np.broadcast_to(-along @ shape, (count, dofs.shape[1]))]
    columns = [np.broadcast_to(dofs, (count, dofs.shape[1]))]
    if pin.link != GROUND:
        values.append(turned(along, motion.angle[:, guide.link] - motion.angle[:, pin.link]) @ pin.shift)
        columns.append(np.broadcast_to(pin.dofs, (count, 3)))
    return np.concatenate(columns, axis=1), np.concatenate(values, axis=1)


def _applied(scene: Scene, system: System, response: ElasticResponse) -> Iterator[tuple[Attachment, Array]]:
    """Give points of links and the forces of loads, springs and dampers on them in the fixed frame, ``(angles, 2)``.

    Forces that turn with a rigid link keep their moment about its centre.
    """
    mesh, motion = system.beams.mesh, system.motion

    def at(name: str) -> Attachment:
        return Attachment.of(scene.links, scene.joints, mesh, name)

    for load in scene.loads.values():
        if isinstance(load, Load) and "@" not in load.at and not load.follows:
            yield at(load.at), load.factor_at(motion.theta)[:, None] * np.array(load.force)
    v = system.to_links(response.displacement)
    parts = (
        (scene.springs, lambda: spring_forces(scene, mesh, motion, v)),
        (scene.dampers, lambda: damper_forces(scene, mesh, motion, v, response.velocity)),
    )
    for between, tensions in parts:
        lines = {name: part.between for name, part in between.items() if not isinstance(part, Hinge)}
        pulled = tensions() if lines else {}
        for name, points in lines.items():
            first, second = (motion.of_point(*scene.point(point))[0] for point in points)
            apart = second - first
            pull = (pulled[name] / np.maximum(np.linalg.norm(apart, axis=1), TINY))[:, None] * apart
            yield from ((at(p), sign * pull) for p, sign in zip(points, (1.0, -1.0)) if not p.startswith("ground."))
