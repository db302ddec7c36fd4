"""What the joints demand of elastic displacements, linearised about the rigid motion: ``G(theta) v = 0``.

v holds the nodal dofs that take part (in link axes, see `beams`) and the coordinates of the joints. These are the
displacement X, Y of a pin in the fixed frame, and the slide of a slot. Every equation belongs to a joint and to one of
its bodies, so that its multiplier is the force or the moment of the joint on that body.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.beams.attachment import QUARTER, Attachment
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.kinematics import Motion
from fenics_mech.mechanism.contact import Contact, travelled
from fenics_mech.mechanism.jets import Jets, constant, product, rotation_matrices
from fenics_mech.scene import Prismatic, Scene, Slot
from fenics_mech.scene.numbering import GROUND

Term = tuple[Index, Jets]  # columns ``(angles or 1, k)``, and jets ``(angles, rows, k)``


@dataclass(frozen=True)
class ConstraintEquation:
    """Rows of G: the point of a body is where its joint wants it (two rows), or its rotation is (one row).

    Parameters
    ----------
    joint, body
        Name of the joint, and the body that its multiplier acts on.
    frame
        Link in whose axes the rows stand, `GROUND` for the fixed frame.
    rows
        Number of rows.
    terms
        Functions of (motion, orders) that give the columns and values of the rows.
    contact
        Where the pin of a slot along a member is.
    """

    joint: str
    body: str
    frame: int
    rows: int
    terms: tuple[Callable[[Motion, int], Term], ...]
    contact: Contact | None = None

    def columns(self, motion: Motion) -> Index:
        """All columns that take part at any angle, also at others than the motion's: a pin may come to any element.

        Parameters
        ----------
        motion
            The rigid motion.
        """
        travelled_along = [] if self.contact is None else [self.contact.dofs]
        return np.unique(np.concatenate([*travelled_along, *(term(motion, 1)[0].ravel() for term in self.terms)]))

    def jets(self, motion: Motion, orders: int, columns: Index) -> Jets:
        """Give the rows over sorted `columns`, ``(angles, rows, columns)``.

        Parameters
        ----------
        motion
            The rigid motion.
        orders
            1 for values, 3 with two time derivatives.
        columns
            Ascending columns that take part.
        """
        count = len(motion.theta)
        matrices = [np.zeros((count, self.rows, len(columns))) for _ in range(orders)]
        angles, rows = np.arange(count)[:, None, None], np.arange(self.rows)[None, :, None]
        for term in self.terms:
            where, values = term(motion, orders)  # of which no column comes twice
            place = np.searchsorted(columns, where)[:, None, :]
            for matrix, value in zip(matrices, values):
                matrix[angles, rows, place] += value
        return matrices


@dataclass(frozen=True)
class Constraints:
    """The equations of all joints, drives and freedoms.

    Parameters
    ----------
    equations
        All equations.
    names
        Names of the joints' own coordinates: "joint.X", "joint.Y", "joint.slide"; their columns follow the nodal dofs.
    contacts
        By joint: where the pin of a slot along a member is.
    bodies
        Dofs of the rigid links' centres.
    """

    equations: tuple[ConstraintEquation, ...]
    names: tuple[str, ...]
    contacts: dict[str, Contact]
    bodies: Index


def build_constraints(scene: Scene, mesh: BeamMesh) -> Constraints:
    """State the equations of a scene's joints and drives.

    Parameters
    ----------
    scene
        The scene.
    mesh
        The mesh of its members.
    """
    driven = set(scene.moved_joints)
    equations: list[ConstraintEquation] = []
    own: dict[str, int] = {}
    contacts: dict[str, Contact] = {}

    def column(name: str) -> int:
        return own.setdefault(name, 3 * len(mesh.node_name) + len(own))

    for name, joint in scene.constraints.items():
        points = [Attachment.of(scene.links, scene.joints, mesh, point) for point in joint.connect]
        if isinstance(joint, Slot | Prismatic):
            places = [scene.point(point)[1] for point in joint.connect]
            contact = None if joint.member is None else Contact.of(name, joint, places, scene.members(), mesh)
            if contact is not None:
                contacts[name] = contact
            slide = None if name in driven else column(f"{name}.slide")
            equations += _slot(name, joint, (points[0], points[1]), places, scene.guide_angle(joint), slide, contact)
        else:
            grounded = any(point.link == GROUND for point in points)
            pin = None if grounded else np.array([column(f"{name}.X"), column(f"{name}.Y")])
            equations += [_pinned(name, point, pin) for point in points if point.link != GROUND]
            if joint.kind == "weld" or name in driven:
                equations.append(_tied(name, points[0], points[1]))
    centres = [mesh.node(f"{name}.centre") for name, link in scene.links.items() if link.rigid]
    bodies = (3 * np.array(centres, dtype=np.int64)[:, None] + np.arange(3)).ravel()
    return Constraints(tuple(equations), tuple(own), contacts, bodies)


def _pinned(joint: str, point: Attachment, pin: Index | None) -> ConstraintEquation:
    """A body's point moves as its pin, (4.41): ``shift u - R^T (X, Y) = 0`` in the axes of the link."""
    terms: list[Callable[[Motion, int], Term]] = [_fixed(point.dofs, point.shift)]
    if pin is not None:
        terms.append(lambda motion, orders: (pin[None], [-r for r in _into(motion, point.link, GROUND, orders)]))
    return ConstraintEquation(joint, point.body, point.link, 2, tuple(terms))


def _tied(joint: str, first: Attachment, second: Attachment) -> ConstraintEquation:
    """Two bodies have one rotation, by a weld or a drive: ``phi_2 - phi_1 = 0``."""
    terms = [_fixed(p.dofs[2:], sign * np.ones((1, 1))) for p, sign in ((second, 1.0), (first, -1.0)) if p.dofs.size]
    held = second if second.dofs.size else first
    return ConstraintEquation(joint, held.body, held.link, 1, tuple(terms))


def _slot(
    name: str,
    joint: Slot | Prismatic,
    ends: tuple[Attachment, Attachment],
    places: list[tuple[float, float]],
    angle: float,
    slide: int | None,
    contact: Contact | None,
) -> list[ConstraintEquation]:
    """A pin moves as its guide does where it is, and along it; `ends` and `places` are those of guide and pin."""
    guide, pin = ends
    frame = pin.link if pin.link != GROUND else guide.link
    along = np.array([[np.cos(angle)], [np.sin(angle)]])  # in the guide's axes

    def carried(motion: Motion, orders: int) -> Term:
        turn = _into(motion, frame, guide.link, orders)
        if contact is not None:
            dofs, shape = contact.shift(motion, orders)
            return dofs, [-value for value in product(turn, shape)]
        distance = travelled(motion, guide.body, pin.body, places, angle, orders)
        jets = [value.copy() for value in constant(guide.shift, motion, orders)]
        for jet, d in zip(jets, distance):
            jet[:, :, 2] += (QUARTER @ along)[:, 0] * d[:, None]  # the guide's rotation swings the pin
        return guide.dofs[None], [-value for value in product(turn, jets)]

    def slid(motion: Motion, orders: int) -> Term:
        turn = _into(motion, frame, guide.link, orders)
        return np.array([[slide]]), [-value for value in product(turn, constant(along, motion, orders))]

    terms: list[Callable[[Motion, int], Term]] = []
    if pin.link != GROUND:
        terms.append(_fixed(pin.dofs, pin.shift))
    if guide.link != GROUND:
        terms.append(carried)
    if slide is not None:
        terms.append(slid)
    equations = [ConstraintEquation(name, pin.body, frame, 2, tuple(terms), contact)]
    if isinstance(joint, Prismatic):
        turning = [_fixed(pin.dofs[2:], np.ones((1, 1)))] if pin.dofs.size else []
        if contact is not None:
            turning.append(contact.turn)
        elif guide.dofs.size:
            turning.append(_fixed(guide.dofs[2:], -np.ones((1, 1))))
        equations.append(ConstraintEquation(name, pin.body, frame, 1, tuple(turning), contact))
    return equations


def _fixed(columns: Index, values: Array) -> Callable[[Motion, int], Term]:
    """Give a term that does not depend on the angle."""
    return lambda motion, orders: (columns[None], constant(values, motion, orders))


def _into(motion: Motion, link: int, other: int, orders: int) -> Jets:
    """Rotation of vectors from the axes of link `other` into those of `link`; either may be `GROUND`."""
    zero = np.zeros(len(motion.theta))
    angle, omega, alpha = (
        (array[:, other] if other != GROUND else zero) - (array[:, link] if link != GROUND else zero)
        for array in (motion.angle, motion.omega, motion.alpha)
    )
    return rotation_matrices(angle, omega, alpha, orders)
