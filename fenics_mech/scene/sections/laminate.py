"""A strip of plies of different materials, one on the other in the plane of motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field

from fenics_mech.scene.base import Name, Part
from fenics_mech.scene.sections.rigidity import Array, Positive, Rigidity, Section, known
from fenics_mech.units import Length

if TYPE_CHECKING:
    from fenics_mech.scene.models import Material


class Ply(Part):
    """A ply: its thickness (m) and the name of its material, whose modulus is that along the member."""

    thickness: Annotated[Length, Positive]
    material: Name


class LaminateSection(Section):
    """A laminated strip that bends about its neutral axis: equivalent EA, EI and rho A (ref. 44).

    The member's axis is the neutral one, so that axial force and bending stay apart. The offset of the plies' centre of
    mass from it, which an unsymmetric laminate of different densities has, is neglected.

    Parameters
    ----------
    width
        Size normal to the plane of motion (m).
    plies
        The plies, from the side opposite to the member's normal ("-") to the normal's side ("+").
    """

    complete = True
    shape: Literal["laminate"]
    width: Annotated[Length, Positive]
    plies: Annotated[tuple[Ply, ...], Field(min_length=1)]

    def rigidity(
        self, s: Array, material: Material | None, materials: Mapping[str, Material], sections: Mapping[str, Section]
    ) -> Rigidity:
        """Sum over the plies by the rule of beams with plane sections, as `Section.rigidity` says."""
        t = np.array([ply.thickness for ply in self.plies])
        e = np.array([materials[ply.material].modulus for ply in self.plies])
        rho = np.array([materials[ply.material].density for ply in self.plies])
        middle = np.cumsum(t) - t / 2  # of each ply, from the outer face of the first
        neutral = np.sum(e * t * middle) / np.sum(e * t)
        ei = self.width * np.sum(e * (t**3 / 12 + t * (middle - neutral) ** 2))
        outer = (float(np.sum(t) - neutral), float(-neutral))
        return Rigidity.at(s, self.width * np.sum(e * t), ei, self.width * np.sum(rho * t), (e[-1], e[0]), outer)

    def check(self, place: str, materials: Mapping[str, Material], sections: Mapping[str, Section]) -> None:
        """Raise `SceneError` where a ply's material is not there."""
        for i, ply in enumerate(self.plies):
            known(ply.material, materials, "material", f"{place}.plies.{i}.material")
