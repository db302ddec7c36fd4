"""Faces of the materials in a section, at which their stress is largest, and where it exceeds the strength."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._constants import MEGA
from fenics_mech.scene import Material, Member, Scene
from fenics_mech.scene.sections import AnySection, LaminateSection
from fenics_mech.scene.sections.polygon import PolygonSection


@dataclass(frozen=True)
class Face:
    """An edge of a material in a section, between the outer fibres: the strain is linear over the section."""

    material: str  # name of the material
    place: float = 1.0  # 0 at the "-" fibre to 1 at the "+" fibre
    stiffness: tuple[float, float] = (1.0, 1.0)  # its modulus over that of the "+" and of the "-" fibre

    @property
    def side(self) -> str:
        """The nearer outer fibre."""
        return "+" if self.place >= 0.5 else "-"

    @property
    def is_outer(self) -> bool:
        """Whether the stress there is that of an outer fibre."""
        return self.place in (0.0, 1.0) and self.stiffness[0 if self.place else 1] == 1

    def stress(self, plus: Array, minus: Array) -> Array:
        """Give the stress there (Pa) from that of both outer fibres."""
        # plus, minus: stress of the "+" and of the "-" fibre (Pa), of one shape
        if self.is_outer:
            return plus if self.place else minus
        return self.place * self.stiffness[0] * plus + (1 - self.place) * self.stiffness[1] * minus


def faces_by_member(scene: Scene) -> dict[str, list[Face]]:
    """Give the faces of all members, by label."""
    return {
        label: faces_of(member, scene.sections[member.section], scene.materials)
        for label, (_, member) in scene.members().items()
    }


def faces_of(member: Member, section: AnySection, materials: Mapping[str, Material]) -> list[Face]:
    """Give both faces of every material of a member: two where it has one material."""
    if isinstance(section, LaminateSection):
        ends = np.cumsum([0.0, *(ply.thickness for ply in section.plies)])
        extents = [(ply.material, low, high) for ply, low, high in zip(section.plies, ends, ends[1:])]
    elif isinstance(section, PolygonSection) and section.parts:
        heights = [[y for y, _ in part.outline] for part in section.parts]
        extents = [(part.material, min(y), max(y)) for part, y in zip(section.parts, heights)]
    else:
        return [] if member.material is None else [Face(member.material, 1.0), Face(member.material, 0.0)]
    bottom, top = min(low for _, low, _ in extents), max(high for *_, high in extents)
    modulus = {name: materials[name].modulus for name, *_ in extents}
    outer = (
        max(modulus[name] for name, _, high in extents if high == top),
        max(modulus[name] for name, low, _ in extents if low == bottom),
    )
    return [
        Face(name, float((y - bottom) / (top - bottom)), (modulus[name] / outer[0], modulus[name] / outer[1]))
        for name, *both in extents
        for y in both[::-1]
    ]


def exceeded(
    members: Mapping[str, tuple[str, Member]],
    sections: Mapping[str, AnySection],
    materials: Mapping[str, Material],
    data: xr.Dataset,
) -> tuple[str, ...]:
    """Compare the stresses of all materials, at their faces, with their strengths."""
    # data: the result, with the stress (Pa) over theta, member, s and fibre
    found = []
    for label, (_, member) in members.items():
        most, worst = 1.0, ""
        for face in faces_of(member, sections[member.section], materials):
            material = face.material
            if (strength := materials[material].strength) is None:
                continue
            both = (data["stress"].sel(member=label, fibre=fibre).transpose("theta", "s").to_numpy() for fibre in "+-")
            stress = face.stress(*both)
            k, i = np.unravel_index(int(np.abs(stress).argmax()), stress.shape)
            if abs(stress[k, i]) <= most * strength:
                continue
            most, angle = abs(stress[k, i]) / strength, np.degrees(float(data["theta"][k])) % 360
            where = f"fibre {face.side}" if face.is_outer else f"{face.place:.3g} of the way from fibre - to +"
            worst = (
                f"materials.{material}.strength: the stress of member {label} reaches {MEGA * stress[k, i]:.4g} MPa at "
                f"s = {float(data['s'][i]):.3g}, {where}, drive angle {angle:.4g} deg; the strength of "
                f"{material} is {MEGA * strength:.4g} MPa"
            )
        found += [worst] if worst else []
    return tuple(found)
