"""Labels of small motions about an equilibrium."""

from __future__ import annotations

import numpy as np
import xarray as xr

from fenics_mech.response.static.small_motions import SmallMotions


def of_small_motions(motions: SmallMotions) -> xr.Dataset:
    """Label the small motions about an equilibrium.

    Parameters
    ----------
    motions
        The small motions.
    """
    along = ("small_motion",)
    variables = {"rest_frequency": (along, motions.frequency), "rest_decay": (along, motions.decay)}
    return xr.Dataset(variables, {"small_motion": np.arange(1, len(motions.decay) + 1)})
