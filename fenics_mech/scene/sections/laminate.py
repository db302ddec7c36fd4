"""A strip of plies of different materials, one on the other in the plane of motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field

from fenics_mech._arrays import Array
from fenics_mech.scene.base import Name, Part, check_known
from fenics_mech.scene.sections.rigidity import Positive, Rigidity, Section, Stock, lines_from
from fenics_mech.scene.units import Length

if TYPE_CHECKING:
    from fenics_mech.scene.bodies import Material


class Ply(Part):
    """A ply of a laminate.

    Parameters
    ----------
    thickness
        Thickness (m).
    material
        Name of its material, whose modulus is that along the member.

    Examples
    --------
    >>> fm.Ply(thickness="0.5 mm", material="carbon").thickness
    0.0005
    """

    thickness: Annotated[Length, Positive]
    material: Name


class LaminateSection(Section):
    """A laminated strip that bends about its neutral line: equivalent EA, EI and rho A (ref. 44).

    An unsymmetric laminate has its neutral line, its middle and its centre of mass at three places; all of them count.
    Its rho I is about the neutral line. In shear it has the energy of the stresses that balance those of bending, which
    needs no factor: for one material it is 5/6 of G A.

    Parameters
    ----------
    width
        Size normal to the plane of motion (m).
    plies
        The plies, from the side opposite to the member's normal ("-") to the normal's side ("+").
    axis
        Where the member's axis, with its pins, welds and loads, passes the section. It is the "neutral" line, or the
        "middle" of the thickness. Both are one line where the laminate is symmetric.

    Examples
    --------
    >>> plies = (fm.Ply(thickness="1 mm", material="glass"), fm.Ply(thickness="1 mm", material="carbon"))
    >>> len(fm.LaminateSection(width="20 mm", plies=plies).plies)
    2
    """

    complete = True
    shape: Literal["laminate"] = "laminate"
    width: Annotated[Length, Positive]
    plies: Annotated[tuple[Ply, ...], Field(min_length=1)]
    axis: Literal["neutral", "middle"] = "neutral"

    def rigidity(self, s: Array, stock: Stock) -> Rigidity:
        """Sum over the plies by the rule of beams with plane sections, as `Section.rigidity` says."""
        t, e, middle = self._plies(stock.materials)
        rho = np.array([stock.materials[ply.material].density for ply in self.plies])
        second = self.width * (t**3 / 12 + t * middle**2)
        outer = (float(middle[-1] + t[-1] / 2), float(middle[0] - t[0] / 2))
        ea, rho_a = self.width * np.sum(e * t), self.width * np.sum(rho * t)
        axis = 0.0 if self.axis == "neutral" else (outer[0] + outer[1]) / 2
        lines = lines_from(axis, 0.0, float(np.sum(rho * t * middle) / np.sum(rho * t)), outer[0] - outer[1])
        return Rigidity.at(s, ea, np.sum(e * second), rho_a, np.sum(rho * second), (e[-1], e[0]), outer, *lines)

    def bending_across(self, s: Array, stock: Stock) -> Array:
        """Sum over the plies, each of which is as wide as the strip, as `Section.bending_across` says."""
        t, e, _ = self._plies(stock.materials)
        return np.full_like(s, np.sum(e * t) * self.width**3 / 12)

    def shear_stiffness(self, s: Array, stock: Stock, place: str) -> Array:
        """Give ``EI^2/int S^2/(G b) dy``, S the stiffness-weighted first moment beyond y, as `Section` says."""
        t, e, middle = self._plies(stock.materials)
        modulus = np.array([stock.materials[ply.material].rigidity for ply in self.plies])
        points, weights = np.polynomial.legendre.leggauss(3)  # exact for S^2, of degree 4 in a ply
        y = middle[:, None] + t[:, None] / 2 * points
        bottom = middle - t / 2
        before = np.cumsum(e * t * middle) - e * t * middle
        moment = before[:, None] + e[:, None] * (y**2 - bottom[:, None] ** 2) / 2  # over the width
        energy = np.sum((moment**2 @ weights) * t / 2 / modulus)
        return np.full_like(s, self.width * np.sum(e * (t**3 / 12 + t * middle**2)) ** 2 / energy)

    def _plies(self, materials: Mapping[str, Material]) -> tuple[Array, Array, Array]:
        """Thickness (m), Young's modulus (Pa) and the middle's place from the neutral axis (m) of each ply."""
        t = np.array([ply.thickness for ply in self.plies])
        e = np.array([materials[ply.material].modulus for ply in self.plies])
        middle = np.cumsum(t) - t / 2  # from the outer face of the first
        return t, e, middle - np.sum(e * t * middle) / np.sum(e * t)

    def check(self, place: str, stock: Stock) -> None:
        """Raise `SceneError` where a ply's material is not there."""
        for i, ply in enumerate(self.plies):
            check_known(ply.material, stock.materials, "material", f"{place}.plies.{i}.material")
