"""Putting everything that was computed into one labelled dataset."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from fenics_mech.effects.dampers import damper_forces
from fenics_mech.effects.effect import Choice
from fenics_mech.effects.springs import spring_forces
from fenics_mech.mechanism import System
from fenics_mech.modes import Modes
from fenics_mech.recovery.contacts import point_loads
from fenics_mech.recovery.joints import drive_efforts, joint_forces, nodal_forces, reactions
from fenics_mech.recovery.members import MemberState, recover_members
from fenics_mech.recovery.result import Result, stamp
from fenics_mech.recovery.validity import bow, euler_ratio, rotation
from fenics_mech.recovery.viscous import elastic_part
from fenics_mech.response import History
from fenics_mech.scene import Scene

ATTRIBUTES = {
    "strain": ("1", "strain of the outer fibre"),
    "strain_axial": ("1", "axial strain"),
    "strain_bending": ("1", "bending strain of the outer fibre"),
    "stress": ("Pa", "stress of the outer fibre"),
    "moment": ("N m", "bending moment"),
    "axial_force": ("N", "axial force, tension positive"),
    "shear_force": ("N", "shear force dM/ds"),
    "deflection": ("m", "elastic displacement, fixed frame"),
    "joint_force": ("N", "force of the joint's first body on its second, fixed frame"),
    "input_torque": ("N m", "torque of the first drive on the second body of its joint, or its force (N)"),
    "drive_effort": ("N m", "torque of each drive on the second body of its joint, or its force (N)"),
    "drive_twist": ("rad", "angle of the crank ahead of its drive"),
    "drive_rate": ("rad/s", "rate of the crank"),
    "spring_force": ("N", "tension of each spring, or the moment with which it turns its second body back (N m)"),
    "damper_force": ("N", "tension of each damper, or the moment with which it turns its second body back (N m)"),
    "frequency": ("Hz", "natural frequency"),
    "euler_ratio": ("1", "largest axial force over the Euler load of the member on two pins"),
    "bow": ("1", "largest distance of the member's axis from its chord, over its length"),
    "rotation": ("rad", "largest rotation of the member's axis from its rigid position"),
    "multiplier": ("1", "Floquet multiplier: what a cycle makes of a small disturbance, largest magnitude first"),
    "growth_rate": ("1/s", "rate at which the disturbance grows; it decays where negative"),
    "multiplier_frequency": ("Hz", "frequency of the disturbance"),
    "multiplier_mode": ("1", "mode that has the largest part of the disturbance"),
    "state": ("1", "displacement (m, rad) and velocity of the coordinates at the end, from which to go on"),
    "assurance": ("1", "MAC of each mode with itself at the next position"),
}


def collect(
    scene: Scene, system: System, history: History, modes: Modes | None, choices: Sequence[Choice] = ()
) -> Result:
    """Recover strains, forces and deflections of a history and label them."""
    found = reactions(system, nodal_forces(system, history))
    s = np.linspace(0, 1, scene.analysis.stations)
    members = recover_members(system, history, s, point_loads(system, found))
    by_joint = joint_forces(scene, found)
    variables = _of_members(scene, members) | _of_springs(scene, system, history)
    variables["joint_force"] = (("theta", "joint", "component"), np.stack(list(by_joint.values()), axis=1))
    coordinates: dict[str, object] = {
        "theta": system.motion.theta,
        "time": ("theta", system.motion.time),
        "member": list(system.beams.mesh.members),
        "s": s,
        "fibre": ["+", "-"],
        "joint": list(by_joint),
        "component": ["x", "y"],
    }
    if scene.drives:
        efforts = drive_efforts(scene, system.motion, found)
        variables["input_torque"] = (("theta",), efforts[scene.drives[0].joint])
        variables["drive_effort"] = (("theta", "drive"), np.stack(list(efforts.values()), axis=1))
        coordinates["drive"] = list(efforts)
    if history.twist is not None:
        variables |= {
            "drive_twist": (("theta",), history.twist[0]),
            "drive_rate": (("theta",), scene.cycle_rate + history.twist[1]),
        }
    if modes is not None:
        variables |= {
            "frequency": (("theta", "mode"), modes.frequency),
            "assurance": (("theta", "mode"), modes.assurance),
        }
        coordinates["mode"] = np.arange(1, modes.frequency.shape[1] + 1)
    stability = history.stability
    if stability is not None and len(stability.multipliers):
        multipliers = stability.multipliers
        variables |= {
            "multiplier": (("disturbance", "part"), np.stack([multipliers.real, multipliers.imag], axis=1)),
            "growth_rate": (("disturbance",), stability.growth_rate),
            "multiplier_frequency": (("disturbance",), stability.frequency),
            "multiplier_mode": (("disturbance",), stability.mode + 1),
        }
        coordinates |= {"disturbance": np.arange(1, len(multipliers) + 1), "part": ["real", "imaginary"]}
    data = xr.Dataset(variables, coordinates, stamp(scene) | _decisions(system, choices))
    if stability is not None:
        data.attrs["stability_limit"] = stability.limit
    if history.course is not None:
        state = np.stack([history.course.displacement[-1], history.course.velocity[-1]], axis=1)
        data["state"] = (("dof", "derivative"), state)
        data.attrs |= {
            "cycle_change": history.course.change,
            "time_steps": history.course.steps,
            "interpolation_error": history.course.interpolation,
        }
    if history.error_estimate is not None:
        data.attrs["error_estimate"] = history.error_estimate
    for name, (units, meaning) in ATTRIBUTES.items():
        if name in data:
            data[name].attrs.update(units=units, long_name=meaning)
    data["theta"].attrs.update(units="rad", long_name="drive angle")
    data["time"].attrs.update(units="s", long_name="time")
    data["s"].attrs.update(units="1", long_name="place along the member, from its first to its second end")
    return Result(data)


def _decisions(system: System, choices: Sequence[Choice]) -> dict[str, object]:
    """Attributes that say what was decided; the effects as JSON: name, size if it was estimated, whether it acts."""
    effects = [{"name": c.effect.name, "size": c.size, "acts": c.acts, "lacking": c.lacking} for c in choices]
    return {"dofs": system.size, "elements": len(system.beams.mesh.cell), "effects": json.dumps(effects)}


def _of_springs(scene: Scene, system: System, history: History) -> dict[str, xr.DataArray]:
    """Forces of springs and dampers, where there are some."""
    mesh, motion, v = system.beams.mesh, system.motion, system.to_links(history.displacement)
    forces = {
        "spring": spring_forces(scene, mesh, motion, v),
        "damper": damper_forces(scene, mesh, motion, v, history.velocity),
    }
    return {
        f"{kind}_force": xr.DataArray(np.stack(list(found.values()), axis=1), {kind: list(found)}, ("theta", kind))
        for kind, found in forces.items()
        if found
    }


def _of_members(scene: Scene, members: MemberState) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    """Strains, stresses, section forces and deflections of the members, with their dimensions."""
    rigidity = [scene.rigidity(label, members.s) for label in scene.members()]
    ea, ei = np.stack([r.axial for r in rigidity]), np.stack([r.bending for r in rigidity])
    modulus, fibre = np.stack([r.modulus for r in rigidity]), np.stack([r.fibre for r in rigidity])
    axial = members.axial_force / ea
    bending = -members.moment[..., None] * fibre / ei[..., None]  # + fibre on the normal's side
    stress = modulus * (axial[..., None] + bending)
    retardation = scene.damping.material  # a part of the stress goes with the strain's rate
    if retardation and scene.analysis.method == "periodic":
        axial, bending = (elastic_part(part, retardation, scene.period) for part in (axial, bending))
    if retardation and scene.analysis.method == "transient":
        step = scene.period / scene.analysis.sub_intervals
        axial, bending = (delayed(part, retardation, step) for part in (axial, bending))
    strain = axial[..., None] + bending  # (6.38)
    along = ("theta", "member", "s")
    return {
        "strain": ((*along, "fibre"), strain),
        "strain_axial": (along, axial),
        "strain_bending": ((*along, "fibre"), bending),
        "stress": ((*along, "fibre"), stress),
        "moment": (along, members.moment),
        "axial_force": (along, members.axial_force),
        "shear_force": (along, members.shear_force),
        "deflection": ((*along, "component"), members.deflection),
        "euler_ratio": (("member",), euler_ratio(scene, members)),
        "bow": (("member",), bow(scene, members)),
        "rotation": (("member",), rotation(members)),
    }


def delayed(stress: np.ndarray, retardation: float, step: float) -> np.ndarray:
    """Solve ``strain + retardation strain' = stress/E`` in time, exactly for a stress that is a cubic spline.

    In each step the strain is ``sum (-retardation)^m`` times the m-th derivative of the stress, and a part that dies
    out. It begins as if it did not change.

    Parameters
    ----------
    stress
        Stress over the modulus at equal steps of time, ``(times, ...)``.
    retardation, step
        Both in s.
    """
    cubic, square, slope, start = CubicSpline(step * np.arange(len(stress)), stress).c
    polynomial = np.stack([start, slope, 2 * square, 6 * cubic])  # derivatives at the start of each step
    shift = np.array([[step ** (m - k) / math.factorial(m - k) if m >= k else 0.0 for m in range(4)] for k in range(4)])
    by_order = (-retardation) ** np.arange(4.0)
    forced_start, forced_end = np.tensordot(np.stack([by_order, by_order @ shift]), polynomial, 1)
    decay = math.exp(-step / retardation)
    gain = np.concatenate([stress[:1], forced_end - decay * forced_start])
    return lfilter([1.0], [1.0, -decay], gain, axis=0)
