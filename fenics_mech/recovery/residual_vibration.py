"""Vibration that is left over in the dwells of a drive that moves from rest to rest."""

from __future__ import annotations

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array, Index
from fenics_mech.scene import RestToRest, Scene

LEAST_POSITIONS = 8  # in a dwell, to see its vibration
DWELLS = "after out", "after back"


def residual_vibration(scene: Scene, data: xr.Dataset) -> xr.Dataset:
    """Give how far each member swings on in the dwells: half of the range of its deflection where that is largest."""
    # Of a motion in time it is the last dwell of each kind that has enough positions. A scene whose one drive does
    # not move from rest to rest, or that has freedoms, gives nothing.
    drives = scene.drives
    moves = len(drives) == 1 and isinstance(drives[0].law, RestToRest) and not scene.freedoms
    if not moves or scene.analysis.method not in ("periodic", "transient"):
        return xr.Dataset()
    law = drives[0].law
    assert isinstance(law, RestToRest)
    theta = data["theta"].to_numpy() * np.sign(scene.cycle_rate)
    bent = data["deflection"].transpose("theta", "member", "s", "component").to_numpy()
    found = {}
    for name, begin, end in zip(DWELLS, (law.out[1], law.back[1]), (law.back[0], 1 + law.out[0])):
        inside = _last_dwell(theta / (2 * np.pi), begin, end, repeats=scene.analysis.method == "periodic")
        if len(inside) >= LEAST_POSITIONS:
            found[name] = np.linalg.norm(np.ptp(bent[inside], axis=0), axis=-1).max(axis=-1) / 2
    if not found:
        return xr.Dataset()
    size = np.stack(list(found.values()))
    return xr.Dataset({"residual_vibration": (("dwell", "member"), size)}, {"dwell": list(found)})


def _last_dwell(turns: Array, begin: float, end: float, *, repeats: bool) -> Index:
    """Positions in the last dwell that has enough of them; `turns` count cycles from the start."""
    if repeats:
        return np.flatnonzero((turns - begin) % 1.0 <= end - begin)
    for cycle in range(int(np.floor(turns[-1])), int(np.floor(turns[0])) - 2, -1):
        inside = np.flatnonzero((turns >= cycle + begin) & (turns <= cycle + end))
        if len(inside) >= LEAST_POSITIONS and turns[0] <= cycle + begin:
            return inside
    return np.zeros(0, dtype=np.int64)
