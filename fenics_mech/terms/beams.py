"""Beams between two poses: strains against the chord, stiffness and shallow-arch numbers of each element."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.geometry import End, Geometry
from fenics_mech.terms.inertia import Masses, hermite_mass
from fenics_mech.terms.modal_damping import ModalDamping
from fenics_mech.terms.term import Response, Term


@dataclass(frozen=True)
class Element:
    """Numbers of one beam element, in the order stretch, shear modes, curvature modes, twist.

    Parameters
    ----------
    length
        Length without load (m).
    stiffness
        Of its strains, ``(strains, strains)`` (N m): energy is half of strain times stiffness times strain.
    arch
        Shallow-arch numbers of each plane of bending, ``(bends, 3)``: the share of the stretch that s^2, s k, k^2 make.
    mass
        Between places and first axes of both ends, ``(4, 4)`` (kg, kg m, kg m^2).
    rotary
        Rotary inertia of its sections along axes 2 (and 3), rho I L ``(bends,)`` (kg m^2).
    """

    length: float
    stiffness: Array
    arch: Array
    mass: Array
    rotary: Array

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
        """Give the numbers of a uniform beam: EA L, 12 EI/L, EI/L, GJ/L; 1/10, 0, 1/24.

        Parameters
        ----------
        length
            Length (m).
        EA, EI, GJ
            Axial stiffness (N), bending stiffness about the third and in space about the second axis, torsional
            stiffness (N m^2).
        line_mass
            kg/m.
        rotary
            rho I about the same axes (kg m); none by default.
        """
        bending = np.asarray(EI)
        values = [EA * length, *(12 * bending / length), *(bending / length)]
        if len(bending) == 2:
            values.append(GJ / length)
        arch = np.tile([1 / 10, 0, 1 / 24], (len(bending), 1))
        of_sections = length * np.asarray(rotary) if len(rotary) else np.zeros(len(bending))
        return cls(length, np.diag(values), arch, hermite_mass(length, line_mass), of_sections)


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
    """

    def __init__(
        self, pairs: Sequence[tuple[End, End]], elements: Sequence[Element], damping: Sequence[float] | float = 0.0
    ) -> None:
        super().__init__(pairs)
        self.elements = list(elements)
        self.stiffness = np.array([e.stiffness for e in elements])
        self.damping = np.broadcast_to(np.asarray(damping, dtype=float), len(self.elements))
        self.modal: ModalDamping | None = None

    @property
    def modes(self) -> int:  # type: ignore[override]
        """Modes of viscous stress."""
        return 0 if self.modal is None else self.modal.modes

    def add_to(self, masses: Masses) -> None:
        """Add the inertia of all elements."""
        for (first, second), element in zip(self.pairs, self.elements):
            masses.add_beam((first, second), element.mass, element.rotary)

    def parameters(self, geometry: Geometry) -> Array:
        """Give what the kernel takes: length and arch numbers, ``(elements, 1 + 3 bends)``."""
        return np.array([[e.length, *e.arch.ravel()] for e in self.elements]).reshape(len(self.elements), -1)

    def respond(self, t: Array, x: Array, v: Array) -> Response:
        """Give D (strain + tau strain rate), and the stress of modes."""
        tau = self.damping[:, None]
        stress = np.einsum("eij,tej->tei", self.stiffness, x + tau * v)
        shape = (len(t), *self.stiffness.shape)
        by_rate = None
        if self.damping.any():
            by_rate = np.ascontiguousarray(np.broadcast_to(tau[..., None] * self.stiffness, shape))
        by_measure = np.ascontiguousarray(np.broadcast_to(self.stiffness, shape))
        return Response(stress, by_measure, by_rate, None if self.modal is None else self.modal.at(t))

    def stiffening(self, present: Array, static: Array) -> Array:
        """Give the axial forces of the static answer."""
        return static * (np.arange(static.shape[-1]) == 0)

    def energy(self, t: Array, x: Array) -> Array:
        """Give the energy of the strains."""
        return np.einsum("tei,eij,tej->te", x, self.stiffness, x) / 2
