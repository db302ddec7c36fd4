"""Stress-life curves of materials: how many cycles of a stress they bear."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from fenics_mech._arrays import Array
from fenics_mech.scene.base import Part
from fenics_mech.scene.units import Modulus


class StressLife(Part):
    """A stress-life (S-N) curve by Basquin: ``N = cycles (range / S)^slope`` for a stress range S.

    Parameters
    ----------
    range
        Stress range (Pa), from the least to the largest stress, that is borne `cycles` times.
    cycles
        Number of cycles at that range.
    slope
        Exponent of the curve.
    limit
        Stress range (Pa) up to which a cycle does no damage.
    ultimate
        Tensile strength (Pa). With it a tensile mean stress lowers what is borne, by Goodman's line.

    Examples
    --------
    >>> curve = fm.StressLife(range="90 MPa", cycles=2e6, slope=5)
    >>> float(curve.damage(180e6, 0.0)) * 2e6
    32.0
    """

    range: Annotated[Modulus, Field(gt=0)]
    cycles: Annotated[float, Field(gt=0, le=1e15)] = 2e6
    slope: Annotated[float, Field(ge=1, le=50)] = 5.0
    limit: Annotated[Modulus, Field(ge=0)] = 0.0
    ultimate: Annotated[Modulus, Field(gt=0)] | None = None

    def damage(self, ranges: Array | float, mean: Array | float) -> Array:
        """Damage of cycles by stress range and mean (Pa), 1 over the number borne; infinite at the strength."""
        ranges, mean = np.asarray(ranges, dtype=float), np.asarray(mean, dtype=float)
        if self.ultimate is not None:
            left = 1 - np.clip(mean, 0, None) / self.ultimate
            with np.errstate(divide="ignore", invalid="ignore"):
                ranges = np.where(left > 0, ranges / left, np.inf)
        return np.where(ranges > self.limit, (ranges / self.range) ** self.slope / self.cycles, 0.0)
