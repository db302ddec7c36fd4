"""Beams between two poses: strains against the chord, stiffness and shallow-arch numbers of each element."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.geometry import End, Geometry
from fenics_mech.terms.inertia import Masses, beside_line, hermite_mass
from fenics_mech.terms.inner_places import MOST, Along, Shapes
from fenics_mech.terms.modal_damping import HeldDamping, ModalDamping
from fenics_mech.terms.term import Response, Term


@dataclass(frozen=True)
class Element:
    """Numbers of one beam element, in the order stretch, shear modes, curvature modes, twist.

    With places inside, the strains are Legendre modes of the stretch, and of the turn per share of the length.

    Parameters
    ----------
    length
        Length without load (m).
    stiffness
        Of its strains, ``(strains, strains)`` (N m): energy is half of strain times stiffness times strain.
    arch
        Shallow-arch numbers of each plane of bending, ``(bends, 3)``: the share of the stretch that s^2, s k, k^2 make.
    mass
        Between places and first axes of both ends, and places inside, ``(4 + inner, 4 + inner)`` (kg, kg m, kg m^2).
    rotary
        Rotary inertia of its sections along axes 2 (and 3), rho I L ``(bends,)`` (kg m^2).
    moment
        Of the mass about the neutral line along axes 2 (and 3), rho A e ``(bends,)`` (kg).
    shear
        Angle between the axis and its cubic by places, over the length, and first axes of both ends ``(4,)``: 0 where
        sections stay normal to the axis.
    """

    length: float
    stiffness: Array
    arch: Array
    mass: Array
    rotary: Array
    moment: Array
    shear: Array = field(default_factory=lambda: np.zeros(4))

    @classmethod
    def uniform(
        cls,
        length: float,
        EA: float,
        EI: Sequence[float],
        GJ: float = 0.0,
        line_mass: float = 0.0,
        rotary: Sequence[float] = (),
    ) -> Element:
        """Give the numbers of a uniform beam: EA L, 12 EI/L, EI/L, GJ/L; 1/10, 0, 1/24."""
        # length (m); EA, EI, GJ (N)
        bending = np.asarray(EI)
        values = [EA * length, *(12 * bending / length), *(bending / length)]
        if len(bending) == 2:
            values.append(GJ / length)
        arch = np.tile([1 / 10, 0, 1 / 24], (len(bending), 1))
        of_sections = length * np.asarray(rotary) if len(rotary) else np.zeros(len(bending))
        return cls(length, np.diag(values), arch, hermite_mass(length, line_mass), of_sections, 0 * of_sections)

    @classmethod
    def with_places(
        cls, inner: int, length: float, EA: Along, EI: Along, line_mass: Along = 0.0, rotary: Along = 0.0
    ) -> Element:
        """Give the numbers of a beam in the plane with places inside, from 1 to 4."""
        # length, EA, EI, line_mass, rotary (shares,)
        # Its places are a polynomial of the degree 3 + inner, however far it bends. A place is two unknowns.
        if not 1 <= inner <= MOST:
            raise ValueError(
                f"an element has 1 to {MOST} places inside, not {inner}; without them it is Element.uniform"
            )
        shapes, none = Shapes(inner), np.zeros(1)
        mass = shapes.mass(length, line_mass, rotary)
        return cls(length, shapes.stiffness(length, EA, EI), np.zeros((1, 3)), mass, none, none)

    @property
    def inner(self) -> int:
        """Places inside."""
        return len(self.mass) - 4


class Beams(Term):
    """All beam elements of a machine.

    Parameters
    ----------
    pairs
        Ends of each element, the first axes along the member.
    elements
        Their numbers.
    damping
        Stress per rate of strain over stress per strain, of each element (s).
    inside
        Poses of the places inside each element, as many of each.
    """

    def __init__(
        self,
        pairs: Sequence[tuple[End, End]],
        elements: Sequence[Element],
        damping: Sequence[float] | float = 0.0,
        inside: Sequence[Sequence[int]] | None = None,
    ) -> None:
        super().__init__(pairs)
        self.elements = list(elements)
        if len({element.inner for element in elements}) > 1:
            raise ValueError("all elements of a machine have as many places inside: give each the same number `inner`")
        self.inside = [()] * len(self.elements) if inside is None else list(inside)
        self.inner = elements[0].inner if elements else 0
        self.stiffness = np.array([e.stiffness for e in elements])
        self.damping = np.broadcast_to(np.asarray(damping, dtype=float), len(self.elements))
        self.twisting = TwistInside(self.stiffness, len(elements[0].arch) if elements else 1)
        self.modal: ModalDamping | HeldDamping | None = None

    @property
    def modes(self) -> int:  # type: ignore[override]
        """Modes of viscous stress."""
        return 0 if self.modal is None else self.modal.modes

    def after(self, others: Beams) -> Beams:
        """Give these elements after others."""
        damping = [*others.damping, *self.damping]
        elements, inside = [*others.elements, *self.elements], [*others.inside, *self.inside]
        return Beams([*others.pairs, *self.pairs], elements, damping, inside)

    def add_to(self, masses: Masses) -> None:
        """Add the inertia of all elements."""
        for pair, element, inside in zip(self.pairs, self.elements, self.inside):
            masses.add_beam(pair, element.mass, element.rotary, beside_line(element.length, element.moment), inside)

    def parameters(self, geometry: Geometry) -> Array:
        """Give what the kernel takes: length and arch numbers, ``(elements, 1 + 3 bends)``, or lengths alone."""
        if self.inner:
            return np.array([e.length for e in self.elements])
        return np.array([[e.length, *e.arch.ravel()] for e in self.elements]).reshape(len(self.elements), -1)

    def respond(self, t: Array, x: Array, v: Array) -> Response:
        """Give D (strain + tau strain rate), stresses by twist inside elements, which is not damped."""
        tau = self.damping[:, None]
        stress = np.einsum("eij,tej->tei", self.stiffness, x + tau * v)
        shape = (len(t), *self.stiffness.shape)
        by_strain, by_rate = np.broadcast_to(self.stiffness, shape).copy(), None
        if self.damping.any():
            by_rate = np.ascontiguousarray(np.broadcast_to(tau[..., None] * self.stiffness, shape))
        self.twisting.add_to(x, stress, by_strain)
        return Response(stress, by_strain, by_rate)

    def patterns(self, t: Array) -> Array | None:
        """Give the patterns of damped modes."""
        return None if self.modal is None else self.modal.at(t)

    def stiffening(self, present: Array, static: Array | None) -> Array:
        """Give the axial forces of the static answer."""
        if static is None:
            return present
        return static * (np.arange(static.shape[-1]) <= self.inner)

    def energy(self, t: Array, x: Array) -> Array:
        """Give the energy of the strains."""
        return np.einsum("tei,eij,tej->te", x, self.stiffness, x) / 2 + self.twisting.energy(x)


class TwistInside:
    """Twist that varies inside elements whose two bending stiffnesses differ, without an unknown of its own."""

    # The section at xi, from 0 to 1, turns by 4 xi (1 - xi) c more. D is the difference of both bending stiffnesses
    # over the length, G the torsional stiffness over it, p and r the curvature modes of the stiff and of the soft
    # plane:
    # energy = 1/2 (16/3 G + 8/15 D r^2) c^2 + 2/3 D p r c.
    # Its least value by c is -1/2 p^2 f, with f = D^2 r^2/(12 G + 6/5 D r^2). It takes up to 5/6 of D from the stiff
    # plane, and the energy of the strains stays positive. Left out is -4/15 D p^2 c^2, which matters where p^2 is
    # near 10 G/D: there an element would buckle alone.

    def __init__(self, stiffness: Array, planes: int) -> None:
        # stiffness (elements, strains, strains)
        own = np.diagonal(stiffness, axis1=1, axis2=2)
        bending = own[:, 1 + planes : 1 + 2 * planes]
        difference = np.ptp(bending, axis=1)  # 0 in the plane, where there is one of them
        self.at = np.flatnonzero(difference)
        self.stiff = 1 + planes + bending.argmax(axis=1)[self.at]
        self.soft = 1 + planes + bending.argmin(axis=1)[self.at]
        self.difference, self.torsion = difference[self.at], own[self.at, -1]

    def _softening(self, x: Array) -> tuple[Array, Array, Array, Array]:
        """Give the stiff plane's curvature, and f with its derivatives by that of the soft one."""
        D, G, p, r = self.difference, self.torsion, x[:, self.at, self.stiff], x[:, self.at, self.soft]
        whole = 12 * G + 1.2 * D * r * r
        share = 24 * G * (D / whole) ** 2
        return p, (D * r) ** 2 / whole, share * r, share * (48 * G / whole - 3)

    def energy(self, x: Array) -> Array:
        """Give its energy by the strains ``(instants, elements, strains)``."""
        p, f, *_ = self._softening(x)
        energy = np.zeros(x.shape[:2])
        energy[:, self.at] = -p * p * f / 2
        return energy

    def add_to(self, x: Array, stress: Array, by_strain: Array) -> None:
        """Add its stresses, and their derivatives by the strains."""
        p, f, slope, bend = self._softening(x)
        at, stiff, soft = self.at, self.stiff, self.soft
        stress[:, at, stiff] -= p * f
        stress[:, at, soft] -= p * p * slope / 2
        by_strain[:, at, stiff, stiff] -= f
        by_strain[:, at, stiff, soft] -= p * slope
        by_strain[:, at, soft, stiff] -= p * slope
        by_strain[:, at, soft, soft] -= p * p * bend / 2
