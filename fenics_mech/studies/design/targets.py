"""How far a point of a link is from the path that it is to follow."""

from __future__ import annotations

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.recovery import Result
from fenics_mech.scene.study import Target

PATHS = ("point_position_bent", "point_position")  # of links that bend, and of those that do not


def tracer_error(result: Result, target: Target) -> xr.DataArray:
    """Distance of a point from each place of its target (m), ``(theta,)``, one entry for each place."""
    name = next((name for name in PATHS if name in result.data), PATHS[-1])
    points = [str(point) for point in result.data["point"].to_numpy()] if name in result.data else []
    if target.point not in points:
        raise SceneError(
            f"there is no point {target.point!r}", place="study.targets", hint=f"Known: {', '.join(points)}"
        )
    path = result.data[name].isel(point=points.index(target.point)).transpose("theta", "component").to_numpy()
    wanted = np.array(target.path)
    if target.angles:
        found = at_angles(result.data["theta"].to_numpy(), path, np.array(target.angles))
        return xr.DataArray(np.linalg.norm(found - wanted, axis=1), dims="theta")
    return xr.DataArray(nearest(path, wanted), dims="theta")


def at_angles(theta: Array, values: Array, angles: Array) -> Array:
    """Give values of a cycle at other drive angles, by a periodic cubic spline, ``(angles, ...)``."""
    from scipy.interpolate import CubicSpline  # noqa: PLC0415  (slow to import)

    turn = np.copysign(2 * np.pi, theta[1] - theta[0])
    order = np.argsort(whole := np.append(theta, theta[0] + turn))
    spline = CubicSpline(whole[order], np.concatenate([values, values[:1]])[order], bc_type="periodic")
    return spline(angles)


def nearest(path: Array, wanted: Array) -> Array:
    """Distance of each wanted place from a closed path (m), ``(places,)``."""
    along = np.roll(path, -1, axis=0) - path
    square = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
    apart = wanted[:, None] - path
    share = np.clip((apart * along).sum(axis=2) / square, 0, 1)
    return np.linalg.norm(apart - share[..., None] * along, axis=2).min(axis=1)
