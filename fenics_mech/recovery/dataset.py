"""Putting everything that was computed into one labelled dataset."""

from __future__ import annotations

import numpy as np
import xarray as xr

from fenics_mech.mechanism import System
from fenics_mech.modes import Modes
from fenics_mech.recovery.contacts import point_loads
from fenics_mech.recovery.joints import drive_efforts, joint_forces, nodal_forces, reactions
from fenics_mech.recovery.members import MemberState, recover_members
from fenics_mech.recovery.result import Result, stamp
from fenics_mech.recovery.validity import bow, euler_ratio
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
    "frequency": ("Hz", "natural frequency"),
    "euler_ratio": ("1", "largest axial force over the Euler load of the member on two pins"),
    "bow": ("1", "largest distance of the member's axis from its chord, over its length"),
    "assurance": ("1", "MAC of each mode with itself at the next position"),
}


def collect(scene: Scene, system: System, history: History, modes: Modes | None) -> Result:
    """Recover strains, forces and deflections of a history and label them."""
    found = reactions(system, nodal_forces(system, history))
    s = np.linspace(0, 1, scene.analysis.stations)
    members = recover_members(system, history, s, point_loads(system, found))
    by_joint = joint_forces(scene, found)
    variables = _of_members(scene, members)
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
    if modes is not None:
        variables |= {
            "frequency": (("theta", "mode"), modes.frequency),
            "assurance": (("theta", "mode"), modes.assurance),
        }
        coordinates["mode"] = np.arange(1, modes.frequency.shape[1] + 1)
    data = xr.Dataset(
        variables, coordinates, stamp(scene) | {"dofs": system.size, "elements": len(system.beams.mesh.cell)}
    )
    for name, (units, meaning) in ATTRIBUTES.items():
        if name in data:
            data[name].attrs.update(units=units, long_name=meaning)
    data["theta"].attrs.update(units="rad", long_name="drive angle")
    data["time"].attrs.update(units="s", long_name="time")
    data["s"].attrs.update(units="1", long_name="place along the member, from its first to its second end")
    return Result(data)


def _of_members(scene: Scene, members: MemberState) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    """Strains, stresses, section forces and deflections of the members, with their dimensions."""
    rigidity = [scene.rigidity(label, members.s) for label in scene.members()]
    ea, ei = np.stack([r.axial for r in rigidity]), np.stack([r.bending for r in rigidity])
    modulus, fibre = np.stack([r.modulus for r in rigidity]), np.stack([r.fibre for r in rigidity])
    axial = members.axial_force / ea
    bending = -members.moment[..., None] * fibre / ei[..., None]  # + fibre on the normal's side
    stress = modulus * (axial[..., None] + bending)
    if (
        scene.damping.material and scene.analysis.method == "periodic"
    ):  # a part of the stress goes with the strain's rate
        axial, bending = (elastic_part(part, scene.damping.material, scene.period) for part in (axial, bending))
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
    }
