"""The contact of a pin that travels along a member that bends: shape functions at a place that moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import Polynomial

from fenics_mech._arrays import Array, Index
from fenics_mech.beams.element_dofs import element_dofs, member_rotation
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.beams.shapes import AXIAL, CUBIC, LINEAR, NORMAL, evaluate
from fenics_mech.errors import AssemblyError
from fenics_mech.kinematics import Motion
from fenics_mech.mechanism.jets import Jets, constant, product, rotation_matrices
from fenics_mech.scene import Member, Prismatic, Slot
from fenics_mech.scene.bodies import MESH
from fenics_mech.scene.joints import members_under_pins
from fenics_mech.scene.numbering import GROUND


@dataclass(frozen=True)
class Contact:
    """A pin on a member.

    Parameters
    ----------
    joint
        Name of the joint.
    slot
        The joint itself.
    places
        Points of guide and pin in the frames of their links (m).
    mesh
        The mesh of the members.
    member
        Index of the member.
    backwards
        Whether the guide's point is the member's second end.
    """

    joint: str
    slot: Slot | Prismatic
    places: list[tuple[float, float]]
    mesh: BeamMesh
    member: int
    backwards: bool

    @classmethod
    def of(
        cls,
        name: str,
        joint: Slot | Prismatic,
        places: list[tuple[float, float]],
        members: Mapping[str, tuple[str, Member]],
        mesh: BeamMesh,
    ) -> Contact:
        """Find the member along which a joint's pin travels.

        Parameters
        ----------
        name, joint
            The joint.
        places
            Points of guide and pin in the frames of their links (m).
        members
            Link and member, by label.
        mesh
            Their mesh.
        """
        member = mesh.members.index(members_under_pins({name: joint}, members)[name])
        first = mesh.cell_nodes[mesh.cell_member == member][0, 0]
        return cls(name, joint, places, mesh, member, bool(mesh.node(joint.connect[0]) != first))

    @cached_property
    def dofs(self) -> Index:
        """Nodal dofs of the member."""
        return np.unique(element_dofs(self.mesh)[self.mesh.cell_member == self.member])

    def angle(self, motion: Motion) -> Array:
        """Angle of the member in the fixed frame (rad), ``(angles,)``.

        Parameters
        ----------
        motion
            The rigid motion.
        """
        return np.asarray(motion.angle[:, self.mesh.member_link[self.member]] + self.mesh.member_angle[self.member])

    def place(self, motion: Motion, orders: int) -> tuple[Index, Jets]:
        """Element that the pin is on, ``(angles,)``, and its place 0..1 in it with time derivatives.

        Parameters
        ----------
        motion
            The rigid motion.
        orders
            1 for values, 3 with two time derivatives.

        Raises
        ------
        AssemblyError
            When the pin leaves the member.
        """
        mesh = self.mesh
        guide, pin = (point.split(".")[0] for point in self.slot.connect)
        distance = travelled(motion, guide, pin, self.places, float(mesh.member_angle[self.member]), orders)
        length = float(mesh.member_length[self.member])
        if self.backwards:
            distance = [length + distance[0], *distance[1:]]
        k = int(np.abs(distance[0] - length / 2).argmax())
        if not -MESH.past_end * length <= distance[0][k] <= (1 + MESH.past_end) * length:
            raise AssemblyError(
                f"the pin of joint {self.joint} leaves member {mesh.members[self.member]} at drive angle "
                f"{np.degrees(motion.theta[k]):.6g} deg: it is {distance[0][k]:.6g} m along its {length:.6g} m"
            )
        cells = np.flatnonzero(mesh.cell_member == self.member)
        inside = np.searchsorted(mesh.cell_start[cells], distance[0], side="right") - 1
        element = cells[np.clip(inside, 0, len(cells) - 1)]
        h = mesh.cell_length[element]
        return element, [(distance[0] - mesh.cell_start[element]) / h, *(d / h for d in distance[1:])]

    def shift(self, motion: Motion, orders: int) -> tuple[Index, Jets]:
        """Displacement of the member at the pin, in link axes: dofs ``(angles, 6)`` and jets ``(angles, 2, 6)``.

        Parameters are those of `place`.
        """
        element, xi = self.place(motion, orders)
        h = self.mesh.cell_length[element]
        jets = [np.zeros((len(element), 2, 6)) for _ in range(orders)]
        scale = np.stack([np.ones_like(h), h] * 2, axis=-1)
        for jet, along, across in zip(jets, _at_pin(LINEAR, xi), _at_pin(CUBIC, xi)):
            jet[:, 0, AXIAL], jet[:, 1, NORMAL] = along, scale * across
        into_member = member_rotation(self.mesh)[element]
        out = constant(into_member[0, :2, :2].T, motion, orders)
        return element_dofs(self.mesh)[element], product(out, [jet @ into_member for jet in jets])

    def turn(self, motion: Motion, orders: int) -> tuple[Index, Jets]:
        """Minus the member's rotation at the pin: dofs ``(angles, 6)`` and jets ``(angles, 1, 6)``.

        Parameters are those of `place`.
        """
        element, xi = self.place(motion, orders)
        h = self.mesh.cell_length[element]
        jets = [np.zeros((len(element), 1, 6)) for _ in range(orders)]
        scale = np.stack([1 / h, np.ones_like(h)] * 2, axis=-1)
        for jet, slope in zip(jets, _at_pin(tuple(f.deriv() for f in CUBIC), xi)):
            jet[:, 0, NORMAL] = -scale * slope
        return element_dofs(self.mesh)[element], [jet @ member_rotation(self.mesh)[element] for jet in jets]


def travelled(
    motion: Motion, guide: str, pin: str, places: list[tuple[float, float]], angle: float, orders: int
) -> Jets:
    """Distance of a pin along its guide from the guide's point (m), with time derivatives, ``(angles,)`` each.

    Parameters
    ----------
    motion
        The rigid motion.
    guide, pin
        Links of the guide and of the pin, or "ground".
    places
        Points of guide and pin in the frames of their links (m).
    angle
        Direction of the guide in its link's frame (rad).
    orders
        1 for values, 3 with two time derivatives.
    """
    gap = [b - a for a, b in zip(motion.of_point(guide, places[0]), motion.of_point(pin, places[1]))]
    zero = np.zeros(len(motion.theta))
    link = GROUND if guide == "ground" else motion.links.index(guide)
    turn = [a[:, link] if link != GROUND else zero for a in (motion.angle, motion.omega, motion.alpha)]
    tangent = [r[:, :, 0] for r in rotation_matrices(turn[0] + angle, turn[1], turn[2], orders)]
    along = product([t[:, None, :] for t in tangent], [g[:, :, None] for g in gap[:orders]])
    return [value[:, 0, 0] for value in along]


def _at_pin(functions: tuple[Polynomial, ...], xi: Jets) -> Jets:
    """Functions at a place that moves, by the chain rule, ``(angles, functions)`` each."""
    value, slope, curvature = (evaluate(tuple(f.deriv(n) for f in functions), xi[0]) for n in range(3))
    if len(xi) == 1:
        return [value]
    rate, change = xi[1][:, None], xi[2][:, None]
    return [value, slope * rate, curvature * rate**2 + slope * change]
