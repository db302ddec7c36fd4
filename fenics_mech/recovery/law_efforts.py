"""What joint laws exert, as variables of a result."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from fenics_mech.recovery.of_poses import OfPoses


def law_efforts(
    found: OfPoses, inside: OfPoses | None = None, peaks: Mapping[str, float] | None = None, closings: int = 0
) -> xr.Dataset:
    """Label what joint laws exert, the most of it (N or N m), and how far and how often contacts closed."""
    # inside: the motion at the stages of its steps; peaks: the most between these, by law
    efforts, depths = found.laws(), found.depths()
    if not efforts:
        return xr.Dataset()
    seen = {name: [(peaks or {}).get(name, 0.0)] for name in efforts}
    for part in (efforts, {} if inside is None else inside.laws()):
        for name, effort in part.items():
            seen[name].append(float(np.abs(effort).max()))
    data = xr.Dataset(
        {
            "law_effort": (("theta", "law"), np.stack(list(efforts.values()), axis=1)),
            "largest_law_effort": (("law",), list(map(max, seen.values()))),
        },
        {"law": list(efforts)},
    )
    if depths:
        data["indentation"] = (("theta", "contact"), np.stack(list(depths.values()), axis=1))
        data = data.assign_coords(contact=list(depths)).assign_attrs(contacts_closed=closings)
    return data
