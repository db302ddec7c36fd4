"""Inertia of the sections of axes that turn far, beyond that of linear theory, which takes slopes for angles."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array, Index, each
from fenics_mech.beams.element_dofs import element_dofs, member_rotation
from fenics_mech.beams.shapes import CUBIC, NORMAL

if TYPE_CHECKING:
    from fenics_mech.beams.element_matrices import Beams

PLACES, WEIGHTS = (np.polynomial.legendre.leggauss(4) + np.array([[1.0], [0.0]])) / 2  # of integrals along elements


@dataclass(frozen=True, eq=False)
class SectionSpin:
    """The kinetic energy ``rho I (omega + phi')^2/2`` of sections, less that of linear theory.

    The slope b of an axis is the sine of the rotation phi of its section. With ``c = 1/sqrt(1 - b^2)`` the section
    turns at the rate ``phi' = c b'`` in its link's frame, whose angular velocity is omega. Its angular acceleration is
    ``alpha + c b'' + c^3 b b'^2``, and the moment that it needs does its work on ``c db``. Linear theory takes c for 1.
    The stretch of the axis is left out here: it changes this inertia by a share of its own size.
    Source: Simo and Vu-Quoc, J. Appl. Mech. 53 (1986) 849, for the kinetic energy.

    Parameters
    ----------
    dofs
        The links' coordinates of each element, ``(elements, n)``.
    link
        Link of each element.
    shape
        b at places of each element by these coordinates, ``(elements, places, n)``.
    weight
        rho I times the length that each place stands for (kg m^2), ``(elements, places)``.
    of_nodes
        The same by the nodal dofs, where the links are reduced.
    """

    dofs: Index
    link: Index
    shape: Array
    weight: Array
    of_nodes: SectionSpin | None = None

    @classmethod
    def of(cls, beams: Beams) -> SectionSpin | None:
        """Give it by what moves the elements; None where sections have no inertia, or their mass is beside the axis.

        Parameters
        ----------
        beams
            The links' matrices.
        """
        mesh, layout, rotary = beams.mesh, beams.layout, beams.inertia.rotary
        if rotary is None or layout.offsets is not None:
            return None
        shape = np.zeros((len(mesh.cell), len(PLACES), 6))
        slopes = np.stack([f.deriv()(PLACES) for f in CUBIC], axis=-1) / mesh.cell_length[:, None, None]
        slopes[..., [1, 3]] *= mesh.cell_length[:, None, None]
        shape[..., NORMAL] = slopes
        if layout.shear_angle is not None:
            shape = shape @ layout.tie
            shape[..., NORMAL] -= layout.shear_angle[:, None]
        powers = PLACES[:, None] ** np.arange(rotary.powers.shape[-1])
        weight = (rotary.powers @ powers.T) * WEIGHTS * mesh.cell_length[:, None]
        link = mesh.member_link[mesh.cell_member]
        nodal = cls(element_dofs(mesh), link, shape @ member_rotation(mesh), weight)
        if beams.reduction is None:
            return nodal
        dofs, moved = beams.reduction.of_elements
        return replace(nodal, dofs=dofs, shape=nodal.shape @ moved, of_nodes=nodal)

    @property
    def on_elements(self) -> SectionSpin:
        """The same by the nodal dofs."""
        return self.of_nodes or self

    def force(self, v: Array, rate: Array, second: Array, alpha: Array) -> Array:
        """Forces that the inertia needs, ``(angles, elements, n)``.

        Parameters
        ----------
        v, rate, second
            Displacement of the links' coordinates and its two derivatives, ``(angles, links' coordinates)``.
        alpha
            Angular acceleration of the links (rad/s^2), ``(angles, links)``.
        """
        b, b_rate, b_second, c = self._sections(v, rate, second)
        own = alpha[:, self.link, None]
        moment = c * (own + c * b_second + c**3 * b * b_rate**2) - own - b_second
        return each(self.shape.transpose(0, 2, 1), self.weight * moment)

    def linearised(self, v: Array, rate: Array, second: Array, alpha: Array) -> tuple[Array, Array, Array, Array]:
        """Force about a state, ``constant + by_v v + by_rate v' + by_second v''``; parameters are those of `force`.

        Returns
        -------
        tuple
            The constant ``(angles, elements, n)``, and three matrices ``(angles, elements, n, n)``.
        """
        b, b_rate, b_second, c = self._sections(v, rate, second)
        own = alpha[:, self.link, None]
        by_second, by_rate = c**2 - 1, 2 * c**4 * b * b_rate
        by_b = c**3 * b * (own + 2 * c * b_second) + c**4 * (1 + 4 * c**2 * b**2) * b_rate**2
        moment = (c - 1) * own + by_second * b_second + c**4 * b * b_rate**2
        left = moment - by_b * b - by_rate * b_rate - by_second * b_second
        constant = each(self.shape.transpose(0, 2, 1), self.weight * left)
        by_v, by_speed, by_acceleration = (self._matrices(part) for part in (by_b, by_rate, by_second))
        return constant, by_v, by_speed, by_acceleration

    def mass(self, v: Array) -> Array:
        """What it adds to the mass at a displacement as of `force`, ``(angles, elements, n, n)``: by_second there."""
        return self._matrices(_secant(each(self.shape, v[:, self.dofs])) ** 2 - 1)

    def on_frames(self, v: Array, rate: Array, second: Array) -> Array:
        """Moment that the inertia of each element needs as its link turns (N m), ``(angles, elements)``.

        Parameters are those of `force`.
        """
        b, b_rate, b_second, c = self._sections(v, rate, second)
        return np.asarray(np.sum(self.weight * ((c - 1) * b_second + c**3 * b * b_rate**2), axis=-1))

    def energy(self, v: Array, rate: Array, omega: Array) -> Array:
        """Kinetic energy of each element beyond that of linear theory (J), ``(angles, elements)``.

        Parameters
        ----------
        v, rate
            As of `force`.
        omega
            Angular velocity of the links (rad/s), ``(angles, links)``.
        """
        _, b_rate, _, c = self._sections(v, rate, rate)
        own = omega[:, self.link, None]
        return np.asarray(np.sum(self.weight * ((own + c * b_rate) ** 2 - (own + b_rate) ** 2), axis=-1) / 2)

    def _sections(self, v: Array, rate: Array, second: Array) -> tuple[Array, Array, Array, Array]:
        """Give b, its two derivatives and c at the places; no numbers where a section turns by 90 degrees."""
        b, b_rate, b_second = (each(self.shape, part[:, self.dofs]) for part in (v, rate, second))
        return b, b_rate, b_second, _secant(b)

    @cached_property
    def _products(self) -> Array:
        """Products of the shapes at the places, ``(elements, n x n, places)``."""
        both = np.einsum("epi,epj->eijp", self.shape, self.shape)
        return both.reshape(len(both), -1, both.shape[-1])

    def _matrices(self, of_sections: Array) -> Array:
        """Give the matrices of numbers at the places."""
        found = each(self._products, self.weight * of_sections)
        return found.reshape(*found.shape[:2], *2 * (self.shape.shape[-1],))


def _secant(sine: Array) -> Array:
    """Give c of sections by b, the sine of their rotation."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(1 / np.sqrt(1 - sine**2))
