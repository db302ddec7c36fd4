"""Displacement of places along members, and of what is fixed to their sections, with its time derivatives.

Where axes turn far, vectors in the plane are complex numbers: what turns by psi is multiplied by ``exp(i psi)``.
"""

from __future__ import annotations

import operator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index
from fenics_mech.beams.element_dofs import element_dofs, member_rotation
from fenics_mech.beams.shapes import CUBIC, NORMAL
from fenics_mech.forces.bent_axes import PLACES, WEIGHTS, by_shape_functions, refuse_turned
from fenics_mech.mechanism import System
from fenics_mech.mechanism.jets import Jets, product

Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class BentLinks:
    """The links of a mechanism as they are bent, by their nodes.

    Parameters
    ----------
    system
        The mechanism.
    nodal
        Displacement of the nodal dofs in link axes, alone or with its two time derivatives, ``(angles, nodal dofs)``.
    """

    system: System
    nodal: Jets

    @cached_property
    def shapes(self) -> tuple[Jets, Jets] | None:
        """Stretch and shape of the elements, see `ArcLength.shapes`; None where rotations are small."""
        law = self.system.terms.law
        return None if law is None else law.on_elements.shapes(self.nodal)


@dataclass(frozen=True)
class AtNode:
    """What is fixed to a node.

    Parameters
    ----------
    dofs
        The three dofs of the node.
    shift
        Displacement of the place in link axes by these dofs, ``(2, 3)``.
    offset
        Vector from the place to what is fixed there, in link axes (m).
    on_axis
        Whether the node is that of an axis. Rigid links turn by small rotations, as their joints do.
    """

    dofs: Index
    shift: Array
    offset: tuple[float, float]
    on_axis: bool

    def displacement(self, links: BentLinks) -> Jets:
        """Give the displacement in link axes, ``(angles, 2)``, and its derivatives where they are known.

        Parameters
        ----------
        links
            The links as they are bent.
        """
        own, (x, y) = [v[:, self.dofs] for v in links.nodal], self.offset
        if links.system.terms.law is None or not self.on_axis or not (x or y):
            return [v @ (self.shift + np.outer([-y, x], [0.0, 0.0, 1.0])).T for v in own]
        swung = _swings([v[:, 2] for v in own], complex(x, y))
        return [v @ self.shift.T + _as_vectors(part) for v, part in zip(own, swung)]


@dataclass(frozen=True)
class InElement:
    """What is fixed to a section between two nodes.

    Parameters
    ----------
    element, xi
        The element, and the place 0..1 in it.
    offset
        Vector from its axis to what is fixed there, in link axes (m).
    """

    element: int
    xi: float
    offset: tuple[float, float]

    def displacement(self, links: BentLinks) -> Jets:
        """Give the displacement in link axes, ``(angles, 2)``, and its derivatives where they are known.

        Parameters
        ----------
        links
            The links as they are bent.
        """
        own = [v[:, element_dofs(links.system.beams.mesh)[self.element]] for v in links.nodal]
        if links.shapes is not None:
            return self._of_bent_axis(links.system, own, links.shapes)
        shift = self._of_straight_axis(links.system)
        return [v @ shift.T for v in own]

    def _of_straight_axis(self, system: System) -> Array:
        """Give the displacement by each dof of the element in link axes, ``(2, 6)``: rotations are small."""
        mesh, layout, xi = system.beams.mesh, system.beams.layout, np.array([self.xi])
        rotation = member_rotation(mesh)[self.element]
        hermite = layout.tie[self.element] @ rotation if layout.tied else rotation
        length, first = mesh.cell_length[[self.element]], np.zeros(1, dtype=int)
        u, w, turn = (part[:, 0] for part in by_shape_functions(hermite.T[:, None], length, first, xi))
        if layout.tied:
            sheared, neutral = _shear_and_neutral_line(system, self.element)
            turn = turn - sheared @ rotation[NORMAL]  # of the section
            u = u + neutral * turn  # of the axis
        (c, sine), (x, y) = rotation[0, :2], self.offset
        return np.stack([c * u - sine * w, sine * u + c * w]) + np.outer([-y, x], turn)

    def _of_bent_axis(self, system: System, own: Jets, shapes: tuple[Jets, Jets]) -> Jets:
        """Give the displacement by the exact shape of the axis.

        The derivative of its place by its old length is ``lambda exp(i psi)``. The stretch lambda is that of the
        element, and the sine of the rotation psi is the slope of the element's shape.
        """
        layout, rotation = system.beams.layout, member_rotation(system.beams.mesh)[self.element]
        stretch, shape = ([part[:, self.element] for part in of_all] for of_all in shapes)
        slopes = self._slopes(system, self.xi * (PLACES + 1) / 2)
        sines = [z @ slopes.T for z in shape]
        refuse_turned(system, np.full(len(PLACES), self.element), sines[0])
        along = system.beams.mesh.cell_length[self.element] * self.xi
        tangents = product([part[:, None] for part in stretch], _rotations(sines), operator.mul)
        way = [part @ WEIGHTS / 2 * along for part in tangents]
        way[0] = way[0] - along
        sheared, neutral = _shear_and_neutral_line(system, self.element)
        section = self._slopes(system, np.array([self.xi]))[0] - sheared
        turn = [z @ section for z in shape]
        refuse_turned(system, np.array([self.element]), turn[0][:, None])
        axes = complex(*rotation[0, :2])  # of the member in its link
        start = (np.array([1, 1j, 0]) @ layout.tie[self.element, :3]) @ rotation  # of the neutral line
        found = [v @ start + part + neutral * sine for v, part, sine in zip(own, way, turn)]
        return [_as_vectors(axes * part + swung) for part, swung in zip(found, _swings(turn, complex(*self.offset)))]

    def _slopes(self, system: System, xi: Array) -> Array:
        """Give the slopes of the element's shape by its dofs, ``(places, 4)``."""
        h, tie = system.beams.mesh.cell_length[self.element], system.beams.layout.tie[self.element]
        slopes = np.stack([f.deriv()(xi) for f in CUBIC], axis=-1) / h * [1, h, 1, h]
        return np.asarray(slopes @ tie[np.ix_(NORMAL, NORMAL)])


def _shear_and_neutral_line(system: System, element: int) -> tuple[Array, float]:
    """Give an element's angle of shear by the dofs of its shape, ``(4,)``, and the place of its neutral line (m)."""
    layout = system.beams.layout
    sheared = np.zeros(4) if layout.shear_angle is None else layout.shear_angle[element]
    return sheared, 0.0 if layout.offsets is None else float(layout.offsets.neutral[element])


def _rotations(sines: Jets) -> list[Complex]:
    """Give ``exp(i psi)`` and its time derivatives from those of ``sin(psi)``."""
    with np.errstate(invalid="ignore"):
        cosine = np.sqrt(1 - sines[0] ** 2)
    found = [cosine + 1j * sines[0]]
    if len(sines) > 1:
        rate = sines[1] / cosine
        second = (sines[2] + sines[0] * rate**2) / cosine
        found += [1j * rate * found[0], (1j * second - rate**2) * found[0]]
    return found


def _swings(sines: Jets, arm: complex) -> list[Complex]:
    """Give how far the end of an arm moves that turns by psi, and its time derivatives, from those of ``sin(psi)``."""
    turned = _rotations(sines)
    return [arm * (part - 1 if order == 0 else part) for order, part in enumerate(turned)]


def _as_vectors(vectors: Complex) -> Array:
    """Give complex numbers as vectors, ``(angles, 2)``."""
    return np.stack([vectors.real, vectors.imag], axis=-1)
