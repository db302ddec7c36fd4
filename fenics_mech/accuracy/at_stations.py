"""What lies between the stations of a result."""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array


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
