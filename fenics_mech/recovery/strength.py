"""Where the largest stress of a member exceeds the strength that its material states."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from fenics_mech._constants import MEGA
from fenics_mech.recovery.faces import faces_of
from fenics_mech.scene import Material, Member
from fenics_mech.scene.sections import AnySection


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
