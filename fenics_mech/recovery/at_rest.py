"""Labels of an equilibrium: small motions about it, and the friction that holds it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from fenics_mech.answers.held_by_friction import Held
from fenics_mech.solve.rest import SmallMotions


def of_small_motions(motions: SmallMotions) -> xr.Dataset:
    """Label the small motions about an equilibrium."""
    along = ("small_motion",)
    variables = {"rest_frequency": (along, motions.frequency), "rest_decay": (along, motions.decay)}
    return xr.Dataset(variables, {"small_motion": np.arange(1, len(motions.decay) + 1)})


def of_friction(held: Held, freedom: str, laws: Sequence[str]) -> xr.Dataset:
    """Label the range in which friction holds a freedom, and what it uses of its limits."""
    lowest, highest = held.range
    used = [held.used.get(name, np.nan) for name in laws]
    variables = {
        "rest_lowest": (("freedom",), [lowest]),
        "rest_highest": (("freedom",), [highest]),
        "friction_used": (("law",), used),
    }
    return xr.Dataset(variables, {"freedom": [freedom], "law": list(laws)})
