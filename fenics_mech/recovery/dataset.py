"""Putting everything that was computed into one labelled dataset (section 6 of the design)."""

from __future__ import annotations

import numpy as np
import xarray as xr

from fenics_mech.mechanism import System
from fenics_mech.modes import Modes
from fenics_mech.recovery.joints import input_torque, joint_forces, nodal_forces
from fenics_mech.recovery.members import recover_members
from fenics_mech.recovery.result import Result, stamp
from fenics_mech.response import History
from fenics_mech.scene import Scene

LONG_NAMES = {
    "strain": ("1", "strain of the outer fibre"),
    "strain_axial": ("1", "axial strain N/EA"),
    "strain_bending": ("1", "bending strain of the outer fibre"),
    "stress": ("Pa", "stress of the outer fibre"),
    "moment": ("N m", "bending moment EI w''"),
    "axial_force": ("N", "axial force, tension positive"),
    "shear_force": ("N", "shear force dM/ds"),
    "deflection": ("m", "elastic displacement, fixed frame"),
    "joint_force": ("N", "force of the joint's first body on its second, fixed frame"),
    "input_torque": ("N m", "torque of the drive"),
    "frequency": ("Hz", "natural frequency"),
    "assurance": ("1", "MAC of each mode with itself at the next position"),
}


def collect(scene: Scene, system: System, history: History, modes: Modes | None) -> Result:
    """Recover strains, forces and deflections of a history and label them."""
    s = np.linspace(0, 1, scene.analysis.stations)
    members = recover_members(system, history, s)
    rigidity, modulus, fibre = _member_properties(scene)
    axial = members.axial_force / rigidity[:, 0, None]
    bending = -members.moment[..., None] * fibre[:, None] / rigidity[:, 1, None, None]  # + fibre on the normal's side
    strain = axial[..., None] + bending  # (6.38)
    forces = nodal_forces(system, history)
    by_joint = joint_forces(scene, system, forces)
    along = ("theta", "member", "s")
    variables = {
        "strain": ((*along, "fibre"), strain),
        "strain_axial": (along, axial),
        "strain_bending": ((*along, "fibre"), bending),
        "stress": ((*along, "fibre"), modulus[:, None, None] * strain),
        "moment": (along, members.moment),
        "axial_force": (along, members.axial_force),
        "shear_force": (along, members.shear_force),
        "deflection": ((*along, "component"), members.deflection),
        "joint_force": (("theta", "joint", "component"), np.stack(list(by_joint.values()), axis=1)),
        "input_torque": (("theta",), input_torque(scene, system, forces)),
    }
    coordinates = {
        "theta": system.motion.theta,
        "time": ("theta", system.motion.time),
        "member": list(system.beams.mesh.members),
        "s": s,
        "fibre": ["+", "-"],
        "joint": list(by_joint),
        "component": ["x", "y"],
    }
    if modes is not None:
        variables |= {
            "frequency": (("theta", "mode"), modes.frequency),
            "assurance": (("theta", "mode"), modes.assurance),
        }
        coordinates["mode"] = np.arange(1, modes.frequency.shape[1] + 1)
    data = xr.Dataset(
        variables, coordinates, stamp(scene) | {"dofs": system.size, "elements": len(system.beams.mesh.cell)}
    )
    for name, (units, meaning) in LONG_NAMES.items():
        if name in data:
            data[name].attrs.update(units=units, long_name=meaning)
    data["theta"].attrs.update(units="rad", long_name="drive angle")
    data["time"].attrs.update(units="s", long_name="time")
    return Result(data)


def _member_properties(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """EA, EI ``(members, 2)``; E ``(members,)``; signed fibre distances ``(members, 2)``, of + and - fibre."""
    rigidity, modulus, fibre = [], [], []
    for _, member in scene.members().values():
        section, material = scene.sections[member.section], scene.materials[member.material]
        rigidity.append([material.modulus * section.area, material.modulus * section.inertia])
        modulus.append(material.modulus)
        fibre.append([section.fibre, -section.fibre])
    return np.array(rigidity), np.array(modulus), np.array(fibre)
