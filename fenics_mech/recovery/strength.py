"""Where the largest stress of a member exceeds the strength that its material states."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from fenics_mech._constants import MEGA
from fenics_mech.scene import Material, Member
from fenics_mech.scene.sections import AnySection, LaminateSection


def exceeded(
    members: Mapping[str, tuple[str, Member]],
    sections: Mapping[str, AnySection],
    materials: Mapping[str, Material],
    data: xr.Dataset,
) -> tuple[str, ...]:
    """Compare the stresses of the outer fibres with the strengths of their materials.

    Parameters
    ----------
    members
        Link and member, by label.
    sections, materials
        Those that the members refer to.
    data
        The result, with the stress (Pa) over theta, member, s and fibre.

    Returns
    -------
    tuple
        One sentence for each member of which an outer fibre exceeds the strength of its material.
    """
    found = []
    for label, (_, member) in members.items():
        most, worst = 1.0, ""
        for fibre, material in outer_materials(member, sections[member.section]).items():
            if material is None or (strength := materials[material].strength) is None:
                continue
            stress = data["stress"].sel(member=label, fibre=fibre).transpose("theta", "s").to_numpy()
            k, i = np.unravel_index(int(np.abs(stress).argmax()), stress.shape)
            if abs(stress[k, i]) <= most * strength:
                continue
            most, angle = abs(stress[k, i]) / strength, np.degrees(float(data["theta"][k])) % 360
            worst = (
                f"materials.{material}.strength: the stress of member {label} reaches {MEGA * stress[k, i]:.4g} MPa at "
                f"s = {float(data['s'][i]):.3g}, fibre {fibre}, drive angle {angle:.4g} deg; the strength of "
                f"{material} is {MEGA * strength:.4g} MPa"
            )
        found += [worst] if worst else []
    return tuple(found)


def outer_materials(member: Member, section: AnySection) -> dict[str, str | None]:
    """Materials of a member's outer fibres; None where the section is a polygon of several materials.

    Parameters
    ----------
    member, section
        The member and its section.
    """
    if isinstance(section, LaminateSection):
        return {"+": section.plies[-1].material, "-": section.plies[0].material}
    return dict.fromkeys("+-", None if section.complete else member.material)
