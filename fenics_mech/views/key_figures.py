"""The key figures of a result as plain data, for other programs to read."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.recovery import Result
from fenics_mech.recovery.peaks import between_positions
from fenics_mech.recovery.spatial_result import SpatialResult
from fenics_mech.safety.critical_speeds import CriticalSpeed, critical_speeds, speeds_to_avoid
from fenics_mech.safety.load_cases import ENVELOPE, envelope
from fenics_mech.views.details import degrees_of, peak_of, values_of
from fenics_mech.views.judgements import acting, judgements, verdict
from fenics_mech.views.prefixes import prefixed
from fenics_mech.views.safety_words import frequency_ranges, safety_figures
from fenics_mech.views.space.summary import spatial_key_figures

ESTIMATES = ("error_estimate", "deflection_error_estimate", "joint_force_error_estimate", "drive_effort_error_estimate")
FIGURES = ("solver", "elements", "dofs", "mobility", "power_balance_error", "energy_fluctuation", "speed_fluctuation")


def key_figures(result: Result | SpatialResult) -> dict[str, Any]:
    """Give the numbers of a summary by name, in SI, with angles in degrees."""
    if isinstance(result, SpatialResult):
        return spatial_key_figures(result)
    data, scene = result.data, result.scene
    closer = between_positions(result)
    found: dict[str, Any] = {
        "scene": scene.name,
        "method": str(scene.analysis.method),
        "positions": data.sizes["theta"],
        "warnings": list(result.warnings),
        "notices": list(result.notices),
        "joints": _joints(closer),
    }
    judged = judgements(result)
    found["verdict"] = dict(zip(("level", "sentence"), verdict(judged)))
    found["judgements"] = [{"level": one.level, "title": one.title, "text": one.text} for one in judged]
    if "refined" in data.attrs:
        found["refined"] = json.loads(data.attrs["refined"])
    if scene.members():
        found["members"] = _members(closer, result)
        found["safety"] = safety_figures(result, prefixed(result, scene.answer_units))
    for name in ("input_torque", "shaking_force", "shaking_moment"):
        if name in closer.data:
            curve = closer.data[name].transpose("theta", ...).to_numpy()
            found[name] = _largest(closer, np.linalg.norm(curve, axis=-1) if curve.ndim > 1 else curve)
    if ranges := frequency_ranges(result):
        found["frequencies"] = [
            {"mode": mode, "lowest": low, "highest": high} for mode, (low, high) in enumerate(ranges, 1)
        ]
    if "critical_speed" in data:
        found["speeds_to_avoid"] = [_critical(one) for one in speeds_to_avoid(result)]
        found["critical_speeds"] = [_critical(one) for one in critical_speeds(result) if one.band]
    if result.cases:
        found |= _cases(result)
    attributes = {name: data.attrs[name] for name in (*FIGURES, *ESTIMATES) if name in data.attrs}
    if scene.members() and not any(effect.couples for effect in acting(result)):
        attributes.pop("power_balance_error", None)  # the equation leaves out power: it is no error
    return _plain(found | attributes)


def _cases(result: Result) -> dict[str, Any]:
    """Name the governing load case; give the largest numbers of each, and the case that governs each of them."""
    most, data = envelope(result), result.data
    largest: dict[str, Any] = {}
    for variable in (name for name in ENVELOPE if name in most):
        values, which = most[variable], most[f"{variable}_in"].to_numpy()
        labels = map(str, values[values.dims[0]].to_numpy())
        name = variable.removeprefix("case_")
        largest[name] = {
            label: {"value": float(value), "case": str(case)}
            for label, value, case in zip(labels, values.to_numpy(), which)
        }
    each = {
        case: {
            name: {label: float(data[f"case_{name}"].sel(case=case).to_numpy()[n]) for n, label in enumerate(of)}
            for name, of in largest.items()
        }
        for case in result.cases
    }
    return {"case": result.case, "scene": result.stated.name, "cases": each, "envelope": largest}


def _critical(one: CriticalSpeed) -> dict[str, Any]:
    """Give a critical speed in plain data: rates in rad/s, distance and rise as shares."""
    low, high = one.band or (one.speed, one.speed)
    return {
        "speed": one.speed,
        "lowest": low,
        "highest": high,
        "distance": one.distance,
        "order": one.order,
        "modes": list(one.modes),
        "link": one.link,
        "rise": one.rise,
    }


def _members(result: Result, at_positions: Result) -> dict[str, Any]:
    """Peaks of strain, stress and deflection of each member with angle, place, side, and its stress range."""
    s, fibres = result.data["s"].to_numpy(), result.data["fibre"].to_numpy()
    found: dict[str, Any] = {}
    bent = np.linalg.norm(values_of(result, "deflection", "member", "theta", "s", "component"), axis=-1)[..., None]
    for i, member in enumerate(result.data["member"].to_numpy()):
        curves = {name: values_of(result, name, "member", "theta", "s", "fibre")[i] for name in ("strain", "stress")}
        peaks: dict[str, Any] = {}
        for name, curve in (curves | {"deflection": bent[i]}).items():
            k, j, f = peak_of(curve)
            peaks[name] = {"value": float(curve[k, j, f]), "angle": float(degrees_of(result)[k]), "s": float(s[j])}
            if name != "deflection":
                peaks[name]["fibre"] = str(fibres[f])
        if "stress_range" in at_positions.data:
            sizes = values_of(at_positions, "stress_range", "member", "s", "fibre")[i]
            j, f = peak_of(sizes)
            peaks["stress_range"] = {"value": float(sizes[j, f]), "s": float(s[j]), "fibre": str(fibres[f])}
        found[str(member)] = peaks
    return found


def _joints(result: Result) -> dict[str, Any]:
    forces = np.linalg.norm(values_of(result, "joint_force", "joint", "theta", "component"), axis=-1)
    return {str(joint): _largest(result, curve) for joint, curve in zip(result.data["joint"].to_numpy(), forces)}


def _largest(result: Result, curve: Array) -> dict[str, float]:
    (k,) = peak_of(curve)
    return {"value": float(curve[k]), "angle": float(degrees_of(result)[k])}


def _plain(part: Any) -> Any:
    """Make numbers of NumPy those of Python, and what is not finite None, which JSON has no word for."""
    if isinstance(part, dict):
        return {str(key): _plain(value) for key, value in part.items()}
    if isinstance(part, list):
        return [_plain(value) for value in part]
    if isinstance(part, np.generic):
        part = part.item()
    return None if isinstance(part, float) and not np.isfinite(part) else part
