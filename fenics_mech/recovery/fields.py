"""Strains, stresses, forces and deflections of a response, at the stations of the members."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fenics_mech._arrays import Array, norms
from fenics_mech.accuracy.at_stations import AtStations
from fenics_mech.accuracy.joint_map_errors import LeftByJoints, left_by_joints
from fenics_mech.accuracy.validity import bow, euler_ratio, largest_rotation
from fenics_mech.effects import NOTHING
from fenics_mech.effects.dampers import damper_forces
from fenics_mech.effects.springs import spring_forces
from fenics_mech.forces.air import drag_known
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.element_loads import pin_loads, point_loads
from fenics_mech.forces.joint_forces import Reactions, joint_forces, nodal_forces, reactions
from fenics_mech.forces.section_forces import MemberState, recover_members, section_forces
from fenics_mech.forces.strains import stress_over_modulus, young_modulus
from fenics_mech.forces.viscous import elastic_strain, sampling_error
from fenics_mech.mechanism import System
from fenics_mech.recovery.peak_places import along_member, beside, even_share, places_between_stations
from fenics_mech.recovery.peaks import CYCLIC, curves_over_cycle
from fenics_mech.response.solution import Solution, StaticSolution
from fenics_mech.scene import Scene
from fenics_mech.scene.sections import Rigidity

Variables = dict[str, tuple[tuple[str, ...], Array]]


@dataclass(frozen=True)
class Fields:
    """What is recovered from a response.

    Parameters
    ----------
    system
        The mechanism, on which the drag of the air acts as a load.
    members
        The members' state at the stations.
    variables
        Labelled arrays by their names; see `variables.ATTRIBUTES`.
    coordinates
        Labels of their dimensions.
    reactions
        Forces and moments of the joints on their bodies; see `forces.joint_forces.reactions`.
    under_pins
        Largest strain of each member under pins that travel along it, 0 where none do, ``(members,)``.
    sampling
        Error of the members' strains by the number of positions, ``(members,)``, where the material damps.
    joints
        What rigid arms and guides leave out; None where there are none.
    """

    system: System
    members: MemberState
    variables: Variables
    coordinates: dict[str, Any]
    reactions: Reactions
    under_pins: Array
    sampling: Array | None = None
    joints: LeftByJoints | None = None

    @property
    def at_stations(self) -> AtStations:
        """What errors are told of: strains of both fibres, and magnitudes of deflections (m)."""
        bent = norms(self.variables["deflection"][1])[..., None]
        curves = {"strain": self.variables["strain"][1], "deflection": bent}
        return AtStations(curves, self.under_pins, self.sampling)


def recover(solution: Solution) -> Fields:
    """Recover strains, stresses, section forces, deflections and joint forces from a response.

    Parameters
    ----------
    solution
        The motion that a solver found.
    """
    scene, response = solution.scene, solution.response
    system = drag_known(scene, solution.system, response)
    s = np.linspace(0, 1, scene.analysis.stations)
    members, elastic, found = _with_viscous_forces(system, response, s)
    by_joint = joint_forces(scene.joints, found, system.terms.joint_laws)
    forces = np.array(list(by_joint.values())).reshape(len(by_joint), len(system.motion.theta), 2)
    sections = scene.rigidities(s)
    strains = _elastic_strains(scene, sections, elastic)
    variables = _of_members(sections, system.beams.mesh.member_length, members, strains)
    variables |= _of_springs(scene, system, response)
    variables["joint_force"] = (("theta", "joint", "component"), np.moveaxis(forces, 0, 1))
    largest, under_pins = _largest_strain(scene, system, response, variables["strain"][1])
    variables["largest_strain"] = (("member",), largest)
    coordinates = {
        "theta": system.motion.theta,
        "time": ("theta", system.motion.time),
        "member": list(system.beams.mesh.members),
        "s": s,
        "fibre": ["+", "-"],
        "joint": list(by_joint),
        "component": ["x", "y"],
        **{kind: list(parts) for kind, parts in (("spring", scene.springs), ("damper", scene.dampers)) if parts},
    }
    sampling = None
    if scene.damping.material and not isinstance(solution, StaticSolution):
        axial, bending = stress_over_modulus(sections, elastic.axial_force, elastic.moment)
        sampling = sampling_error(scene, axial[..., None] + bending)
    joints = left_by_joints(solution, system, found)
    return Fields(system, members, variables, coordinates, found, under_pins, sampling, joints)


def _with_viscous_forces(
    system: System, response: ElasticResponse, s: Array
) -> tuple[MemberState, MemberState, Reactions]:
    """Members with the forces of modal damping and without them, and the joints' reactions with them."""
    found = reactions(system, nodal_forces(system, response.undamped))
    elastic = recover_members(system, response.undamped, s, point_loads(system, found))
    if response.by_modal_damping is None:
        return elastic, elastic, found
    bare = replace(system, terms=NOTHING)
    viscous = reactions(bare, nodal_forces(bare, response.by_modal_damping))
    forces = section_forces(bare, response.by_modal_damping, s, point_loads(bare, viscous))
    return elastic.with_forces(*forces), elastic, {key: force + viscous[key] for key, force in found.items()}


def _elastic_strains(scene: Scene, sections: Sequence[Rigidity], members: MemberState) -> tuple[Array, Array]:
    """Strains of the axis, and by bending of both fibres, where the material may damp; see `stress_over_modulus`."""
    parts = stress_over_modulus(sections, members.axial_force, members.moment)
    axial, bending = (elastic_strain(scene, part) for part in parts)
    return axial, bending


def _of_members(
    sections: Sequence[Rigidity], lengths: Array, members: MemberState, strains: tuple[Array, Array]
) -> Variables:
    """Strains, stresses, section forces and deflections of the members, with their dimensions.

    `strains` are those of the axes and by bending, without the forces of modal damping; lengths are in m.
    """
    whole_axial, whole_bending = stress_over_modulus(sections, members.axial_force, members.moment)
    stress = young_modulus(sections) * (whole_axial[..., None] + whole_bending)
    axial, bending = strains
    along = ("theta", "member", "s")
    return {
        "strain": ((*along, "fibre"), axial[..., None] + bending),  # (6.38)
        "strain_axial": (along, axial),
        "strain_bending": ((*along, "fibre"), bending),
        "stress": ((*along, "fibre"), stress),
        "moment": (along, members.moment),
        "axial_force": (along, members.axial_force),
        "shear_force": (along, members.shear_force),
        "deflection": ((*along, "component"), members.deflection),
        "euler_ratio": (("member",), euler_ratio(sections, lengths, members)),
        "bow": (("member",), bow(lengths, members)),
        "rotation": (("member",), largest_rotation(members)),
    }


def _largest_strain(scene: Scene, system: System, response: ElasticResponse, strain: Array) -> tuple[Array, Array]:
    """Largest strain of each member, at its stations and between them, and under pins alone, ``(members,)`` each."""
    found, places = np.abs(strain).max(axis=(0, 2, 3)), places_between_stations(scene, system, response)
    pins, members = pin_loads(system, response.undamped), system.beams.mesh.cell_member

    def at(places: Array) -> Array:
        there = recover_members(system, response.undamped, places, pins)
        axial, bending = _elastic_strains(scene, scene.rigidities(places), there)
        return axial[..., None] + bending

    if len(places):
        found = np.maximum(found, np.abs(at(places)).max(axis=(0, 2, 3)))
    under_pins = np.zeros_like(found)
    for pin in pins if scene.analysis.method in CYCLIC else ():
        some, member = even_share(len(strain)), members[pin.element[0]]
        place = along_member(system, pin)[some]
        for side in beside(place) if np.any(pin.moment) or np.any(pin.along) else (place,):
            under = at(side)[some, member, np.arange(len(some))]
            under_pins[member] = max(under_pins[member], np.abs(curves_over_cycle(scene, under).largest()[1]).max())
    return np.maximum(found, under_pins), under_pins


def _of_springs(scene: Scene, system: System, response: ElasticResponse) -> Variables:
    """Forces of springs and dampers, where there are some."""
    mesh, motion, v = system.beams.mesh, system.motion, system.to_links(response.displacement)
    forces = {
        "spring": spring_forces(scene, mesh, motion, v),
        "damper": damper_forces(scene, mesh, motion, v, response.velocity),
    }
    return {
        f"{kind}_force": (("theta", kind), np.stack(list(found.values()), axis=1))
        for kind, found in forces.items()
        if found
    }
