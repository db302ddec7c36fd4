"""What joint laws exert, as variables of a result."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.scene import Prismatic, Scene, Slot
from fenics_mech.scene.joint_laws import OPEN

Efforts = Mapping[str, Array]


def law_efforts(efforts: Efforts, depths: Efforts, largest: Mapping[str, float], contacts: int) -> xr.Dataset:
    """Label what joint laws exert."""
    # efforts: what each law exerts (N or N m), ``(times,)`` each; depths: indentation at the contacts of each law
    # that has some (m or rad), ``(times,)`` each
    if not efforts:
        return xr.Dataset()
    seen = {name: max(float(np.abs(x).max()), largest.get(name, 0.0)) for name, x in efforts.items()}
    found = xr.Dataset(
        {
            "law_effort": (("theta", "law"), np.stack(list(efforts.values()), axis=1)),
            "largest_law_effort": (("law",), [seen[name] for name in efforts]),
        },
        {"law": list(efforts)},
    )
    if depths:
        found["indentation"] = (("theta", "contact"), np.stack(list(depths.values()), axis=1))
        found = found.assign_coords(contact=list(depths)).assign_attrs(contacts_closed=contacts)
    return found


def with_law_units(scene: Scene, data: xr.Dataset) -> xr.Dataset:
    """Give a result whose efforts of laws have the units of their joints."""
    if "law_effort" in data:
        units = [_unit_of(scene, str(name)) for name in data["law"].to_numpy()]
        for name in ("law_effort", "largest_law_effort"):
            data[name].attrs["units"] = units[0] if len(set(units)) == 1 else ", ".join(units)
    return data


def _unit_of(scene: Scene, name: str) -> str:
    """Unit of what a joint law exerts."""
    stated, _, driven = name.partition(":")
    law = scene.joint_laws[stated]
    slides = isinstance(scene.joints[driven or law.joint], Slot | Prismatic)
    return "N" if slides or isinstance(law, OPEN) else "N m"
