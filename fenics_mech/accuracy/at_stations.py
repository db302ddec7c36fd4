"""What errors are told of at the stations of a result, and what lies between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.accuracy.missed_peaks import MissedPeaks


@dataclass(frozen=True)
class AtStations:
    """What was recovered at the stations of a result.

    Parameters
    ----------
    curves
        As magnitudes ``(angles, members, stations, fibres)`` or with their sign: "strain" of the outer fibres and
        "deflection" (m).
    under_pins
        Largest strain of each member under pins that travel along it, 0 where none do, ``(members,)``.
    sampling
        Error of the members' strains by the number of positions, ``(members,)``; it counts as "time".
    missed
        What lies between the positions of a cycle; None where nothing is known of it.
    """

    curves: Mapping[str, Array]
    under_pins: Array
    sampling: Array | None = None
    missed: MissedPeaks | None = None

    @property
    def largest(self) -> dict[str, Array]:
        """Largest value of each member at the stations, by quantity, ``(members,)``."""
        return {name: np.abs(curve).max(axis=(0, 2, 3)) for name, curve in self.curves.items()}

    @property
    def between(self) -> dict[str, Array]:
        """By how much values between stations surpass the largest that are known, by quantity, ``(members,)``."""
        surpassing = {name: between_stations(curve) for name, curve in self.curves.items()}
        known = np.maximum(self.under_pins - self.largest["strain"], 0.0)  # where strains along members have corners
        return surpassing | {"strain": np.maximum(surpassing["strain"] - known, 0.0)}


def between_stations(strain: Array) -> Array:
    """By how much parabolas through three stations surpass the largest strain at the stations, ``(members,)``."""
    size = np.abs(strain)
    highest = size.max(axis=(0, 2, 3))
    if strain.shape[2] < 3:
        return np.zeros_like(highest)
    before, middle, after = strain[:, :, :-2], strain[:, :, 1:-1], strain[:, :, 2:]
    bend, slope = after - 2 * middle + before, (after - before) / 2
    inside = (np.abs(slope) < np.abs(bend)) & (bend != 0)
    vertex = middle - np.where(inside, slope**2 / (2 * np.where(inside, bend, 1.0)), 0.0)
    return np.maximum(np.abs(vertex).max(axis=(0, 2, 3)) - highest, 0.0)
