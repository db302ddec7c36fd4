"""Loads inside elements, beside the distributed inertia: forces of pins that travel along members, spread loads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.beams.shapes import (
    LINEAR,
    between_clamped_ends,
    between_fixed_ends,
    integral,
    point_equivalent,
)
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.joint_forces import Reactions, nodal_forces, reactions
from fenics_mech.mechanism import System


@dataclass(frozen=True)
class PointLoad:
    """A load at a place of a member that changes with the drive angle; arrays of shape ``(angles,)``.

    Parameters
    ----------
    element
        Element that it acts on.
    place
        Place 0..1 in the element.
    along, across, moment
        Force along the member's axis and its normal (N), and moment (N m).
    """

    element: Index
    place: Array
    along: Array
    across: Array
    moment: Array

    def at_ends(self, length: Array) -> Array:
        """Forces at the element's nodes that do the same work, ``(angles, 6)``.

        Parameters
        ----------
        length
            Length of the element at each angle (m), ``(angles,)``.
        """
        return point_equivalent(self.place, np.stack([self.along, self.across, self.moment], axis=-1), length)

    def beyond(self, element: Index, xi: Array, length: Array) -> tuple[Array, Array, Array]:
        """What it adds to N, V and M at places of elements, each ``(angles, places)``.

        Parameters
        ----------
        element, xi
            Places 0..1 in elements, ``(places,)`` each.
        length
            Length of these elements (m), ``(places,)``.
        """
        passed = (self.element[:, None] == element) & (xi > self.place[:, None])
        arm = (xi - self.place[:, None]) * length
        across = self.across[:, None]
        return -self.along[:, None] * passed, across * passed, (across * arm - self.moment[:, None]) * passed

    def displacement(self, element: Index, xi: Array, length: Array) -> tuple[Array, Array]:
        """EA u and EI w of an element with fixed, clamped ends under it, each ``(angles, places)`` (N m, N m^3).

        Parameters
        ----------
        element, xi
            Places 0..1 in elements, ``(places,)`` each.
        length
            Length of these elements (m), ``(places,)``.
        """
        here = self.element[:, None] == element
        a = np.broadcast_to(self.place[:, None], here.shape)
        x = np.broadcast_to(xi, here.shape)
        before = x <= a
        p, y = np.where(before, a, 1 - a), np.where(before, x, 1 - x)  # seen from the other end where it is beyond
        u = y * (1 - p) * self.along[:, None] * length
        force = (1 - p) ** 2 * y**2 * (3 * p - y * (2 * p + 1)) / 6
        slope = y**2 * (-2 * (1 - p) * (3 * p - y * (2 * p + 1)) + (1 - p) ** 2 * (3 - 2 * y)) / 6
        couple = np.where(before, slope, -slope)
        w = force * self.across[:, None] * length**3 + couple * self.moment[:, None] * length**2
        return u * here, w * here

    def gap(self, system: System) -> tuple[Array, Array]:
        """Deflection (m) and slope of its element, between clamped ends, where it acts, each ``(angles,)``.

        The pin follows the element's shape functions, which have neither. Elements are rigid in shear: the effect
        `shear` refuses such pins.

        Parameters
        ----------
        system
            The mechanism, for the element's length and its EI.
        """
        beams, a, b = system.beams, self.place, 1 - self.place
        length, ei = beams.mesh.cell_length[self.element], beams.rigidity.bending.mean[self.element]
        mixed = (a * b) ** 2 * (b - a) / 2 * length**2
        w = ((a * b) ** 3 / 3 * length**3 * self.across + mixed * self.moment) / ei
        slope = (mixed * self.across + a * b * (a**2 - a * b + b**2) * length * self.moment) / ei
        return w, slope


@dataclass(frozen=True)
class SpreadLoad:
    """Loads spread linearly along every element.

    Parameters
    ----------
    line
        As in `Loads.line`: along the axis at both nodes, then along the normal (N/m), ``(angles, elements, 4)``.
    shear_number
        EI/(G A_s) over the length squared of the elements, ``(elements,)``; 0 where they are rigid in shear.
    arm
        Place of the neutral line beside the axis that they act on, ``(elements,)`` (m).
    """

    line: Array
    shear_number: Array
    arm: Array

    def beyond(self, element: Index, xi: Array, length: Array) -> tuple[Array, Array, Array]:
        """What it adds to N, V and M at places of elements, each ``(angles, places)``.

        Parameters are those of `PointLoad.beyond`.
        """
        along, across = self._at(element)
        once, twice = (integral(LINEAR, xi, times) for times in (1, 2))
        axial, moment = -length * np.sum(along * once, -1), length**2 * np.sum(across * twice, -1)
        return axial, length * np.sum(across * once, -1), moment + self.arm[element] * axial

    def displacement(self, element: Index, xi: Array, length: Array) -> tuple[Array, Array]:
        """EA u and EI w of an element with fixed, clamped ends under it, each ``(angles, places)`` (N m, N m^3).

        Parameters are those of `PointLoad.displacement`.
        """
        along, across = self._at(element)
        u = -(length**2) * np.sum(along * between_fixed_ends(LINEAR, xi), -1)
        w = length**4 * np.sum(across * between_clamped_ends(LINEAR, xi, self.shear_number[element]), -1)
        return u, w + self.by_arm(element, xi, length)

    def by_arm(self, element: Index, xi: Array, length: Array) -> Array:
        """Of `displacement` the EI w by the moments of loads along the axis on their arm, ``(angles, places)``.

        Parameters are those of `PointLoad.displacement`.
        """
        moments = self.arm[element, None] * self._at(element)[0]
        return -(length**3) * np.sum(moments * between_clamped_ends(LINEAR, xi, self.shear_number[element], 3), -1)

    def _at(self, element: Index) -> tuple[Array, Array]:
        here = self.line[:, element]
        return here[..., :2], here[..., 2:]


def applied_inside(system: System) -> list[PointLoad]:
    """Loads of the scene at places inside elements, which take no part in the forces on the elements' ends.

    Parameters
    ----------
    system
        The mechanism.
    """
    angles = len(system.motion.theta)
    return [
        PointLoad(np.full(angles, load.element), np.full(angles, load.place), *load.force.T)
        for load in system.terms.loads.inside
    ]


def pin_loads(system: System, response: ElasticResponse) -> list[PointLoad]:
    """Give the forces of pins that travel along members, in a response; without such pins nothing is computed.

    Parameters
    ----------
    system
        The mechanism.
    response
        A motion of it.
    """
    if not system.transformation.constraints.contacts:
        return []
    return point_loads(system, reactions(system, nodal_forces(system, response)))


def point_loads(system: System, found: Reactions) -> list[PointLoad]:
    """Loads of pins on the members that they travel along, in the order of `contacts`, from the joints' reactions.

    Parameters
    ----------
    system
        The mechanism.
    found
        Forces and moments of the joints on the bodies.
    """
    motion, loads = system.motion, []
    for name, contact in system.transformation.constraints.contacts.items():
        pin = contact.slot.connect[1].split(".")[0]
        force, moment = -found[name, pin, 2], found.get((name, pin, 1))
        element, place = contact.place(motion, 1)
        angle = contact.angle(motion)
        c, s, (x, y) = np.cos(angle), np.sin(angle), force.T
        couple = np.zeros(len(force)) if moment is None else -moment[:, 0]
        loads.append(PointLoad(element, place[0], c * x + s * y, c * y - s * x, couple))
    return loads
