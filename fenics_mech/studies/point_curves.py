"""Curves over the cycle that a sweep keeps of each point, in bounded size: what its page shows beside a slider.

They are given at `ANGLES` equal angles of the drive: of each member the highest and lowest stress and strain of all its
stations and fibres, of each joint the size of its force, and the effort of the first drive. Whole numbers of 16 bits
hold them, with the largest of each curve as the scale: they are off by 2e-5 of it at most.
"""

from __future__ import annotations

import base64
import binascii
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.recovery import Result
from fenics_mech.recovery.signal import last_cycle
from fenics_mech.scene import Scene
from fenics_mech.scene.joints import joint_names

ANGLES = 120  # of a cycle: every 3 degrees, which shows vibration of up to 20 times the drive's frequency
MOST_POINTS = 2000  # of a sweep that keeps them: 10 MB of a machine with three members and four joints
STEPS = 32767  # of a 16-bit number
CURVES = {  # by variable: its dimension beside the angle, unit, meaning
    "curve_strain_highest": ("member", "1", "highest strain of all stations and fibres"),
    "curve_strain_lowest": ("member", "1", "lowest strain of all stations and fibres"),
    "curve_stress_highest": ("member", "Pa", "highest stress of all stations and fibres"),
    "curve_stress_lowest": ("member", "Pa", "lowest stress of all stations and fibres"),
    "curve_joint_force": ("joint", "N", "size of the force in the joint"),
    "curve_input_torque": ("", "N m", "torque of the first drive; force where it slides"),
}


def packed_curves(result: Result) -> str:
    """Give the curves of a result as a text; an empty one where its motion is no cycle."""
    data = result.data
    cycle = last_cycle(result.scene.analysis, result.scene.drives, data)
    if cycle is None:
        return ""
    theta = np.mod(data["theta"].to_numpy()[cycle], TURN)
    order = np.argsort(theta, kind="stable")
    found = []
    for values in _curves(data.isel(theta=cycle)).values():
        at = np.stack([np.interp(angles(), theta[order], curve, period=TURN) for curve in values[order].T])
        scale = np.maximum(np.abs(at).max(axis=1, keepdims=True), np.finfo(np.float32).tiny)
        found += [scale.astype("<f4").tobytes(), np.rint(at / scale * STEPS).astype("<i2").tobytes()]
    return base64.b64encode(b"".join(found)).decode()


def angles() -> Array:
    """Drive angles of the curves (rad), ``(ANGLES,)``."""
    return TURN * np.arange(ANGLES) / ANGLES


def _curves(data: xr.Dataset) -> dict[str, Array]:
    """Give the curves at positions of a cycle, ``(positions, members, joints or 1)`` each, in the order of `CURVES`."""
    found: dict[str, Array] = {}
    for name in ("strain", "stress"):
        along = data.variables[name].transpose("theta", "member", "s", "fibre").to_numpy()
        found[f"curve_{name}_highest"], found[f"curve_{name}_lowest"] = along.max(axis=(2, 3)), along.min(axis=(2, 3))
    force = data.variables["joint_force"].transpose("theta", "joint", "component").to_numpy()
    found["curve_joint_force"] = np.linalg.norm(force, axis=-1)
    torque = data.variables.get("input_torque")
    found["curve_input_torque"] = np.zeros((len(force), 1)) if torque is None else torque.to_numpy()[:, None]
    return found


def _sizes(scene: Scene) -> dict[str, int]:
    """Number of curves by the dimension beside the angle."""
    return {"member": len(scene.members()), "joint": len(joint_names(scene.joints)), "": 1}


def unpacked_curves(text: str, scene: Scene) -> dict[str, Array] | None:
    """Give curves from their text, ``(angles, members, joints or 1)`` each; None where it is not of such a scene."""
    try:
        content = base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        return None
    sizes = _sizes(scene)
    if len(content) != sum(sizes[dim] * (4 + 2 * ANGLES) for dim, _, _ in CURVES.values()):
        return None
    found, at = {}, 0
    for name, (dim, _, _) in CURVES.items():
        count = sizes[dim]
        scale = np.frombuffer(content, "<f4", count, at)
        whole = np.frombuffer(content, "<i2", count * ANGLES, at + 4 * count).reshape(count, ANGLES)
        found[name] = (scale[:, None] * whole / STEPS).astype(np.float32).T
        at += count * (4 + 2 * ANGLES)
    return found if all(np.isfinite(curve).all() for curve in found.values()) else None


def with_curves(
    data: xr.Dataset, path: str, texts: Sequence[str], scene: Scene, units: Mapping[str, str]
) -> xr.Dataset:
    """Add the curves of the points of a sweep over one field; NaN where a point has none."""
    points = [unpacked_curves(text, scene) if text else None for text in texts]
    if not any(points):
        return data
    sizes = _sizes(scene)
    for name, (dim, unit, meaning) in CURVES.items():
        empty = np.full((ANGLES, sizes[dim]), np.nan, dtype=np.float32)
        values = np.stack([empty if point is None else point[name] for point in points])
        attributes = {"units": units.get(name, unit), "long_name": meaning}
        dims = (path, "curve_theta", *([dim] if dim else []))
        data[name] = (dims, values if dim else values[..., 0], attributes)
    return data.assign_coords(curve_theta=("curve_theta", angles(), {"units": "rad", "long_name": "drive angle"}))
